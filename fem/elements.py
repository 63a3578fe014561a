"""scikit-fem's elements and quadrature, tabulated in the node order of the mesh.

A mesh lists an element's nodes in meshio's order (VTK's), scikit-fem its basis functions in its
own; both place each of them on the reference cell, and the tables are matched by that place. The
trap is the ten-node tetrahedron, whose last two mid-edge nodes gmsh swaps: meshio undoes it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem import element, quadrature

from vanelock.errors import InputError

Array = NDArray[np.float64]

_TETRA = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
_TETRA_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
_HEXA = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
_HEXA_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
_HEXA_EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
_HEXA_FACES = [[0, 0.5, 0.5], [1, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 1, 0.5], [0.5, 0.5, 0]]
_HEXA_FACES += [[0.5, 0.5, 1]]


def _with_edges(corners: list[list[int]], edges: list[tuple[int, int]]) -> Array:
    points = np.array(corners, float)
    middles = np.array([(points[a] + points[b]) / 2 for a, b in edges])
    return np.vstack([points, middles])


# meshio's cell type: scikit-fem's element, the nodes' places in meshio's order, and the degree
# that the quadrature integrates exactly (mass and stiffness of a straight-sided element).
_CELLS = {
    "tetra": (element.ElementTetP1, np.array(_TETRA, float), 2),
    "tetra10": (element.ElementTetP2, _with_edges(_TETRA, _TETRA_EDGES), 4),
    "hexahedron": (element.ElementHex1, np.array(_HEXA, float), 3),
    "hexahedron20": (element.ElementHexS2, _with_edges(_HEXA, _HEXA_EDGES), 5),
    "hexahedron27": (
        element.ElementHex2,
        np.vstack([_with_edges(_HEXA, _HEXA_EDGES), _HEXA_FACES, [[0.5, 0.5, 0.5]]]),
        5,
    ),
}


@dataclass(frozen=True)
class ReferenceElement:
    """Basis functions of one element type at its quadrature points.

    Attributes
    ----------
    nodes : (k, 3) float
        Place of each node on the reference cell, in meshio's order.
    values : (q, k) float
        Basis function of each node.
    gradients : (q, k, 3) float
        Its derivatives on the reference cell.
    weights : (q,) float
        Quadrature weights; they sum to the reference cell's volume.
    """

    nodes: Array
    values: Array
    gradients: Array
    weights: Array


def reference_element(cell_type: str) -> ReferenceElement:
    """Tables of a cell type, by meshio's name.

    Raises
    ------
    InputError
        If there is no solid element of that name.
    """
    if cell_type not in _CELLS:
        raise InputError(f"cell_type = {cell_type!r}: the solid elements are {', '.join(_CELLS)}")
    make, nodes, degree = _CELLS[cell_type]
    basis = make()
    distance = np.linalg.norm(nodes[:, None] - basis.doflocs[None], axis=2)
    order = np.argmin(distance, axis=1)
    assert distance[np.arange(len(nodes)), order].max() < 1e-12
    points, weights = quadrature.get_quadrature(basis.refdom, degree)
    tables = [basis.lbasis(points, i) for i in order]
    values = np.array([value + 0 * weights for value, _ in tables]).T
    slopes = [np.array([row + 0 * weights for row in slope]) for _, slope in tables]
    gradients = np.array(slopes).transpose(2, 0, 1)
    return ReferenceElement(nodes, values, np.ascontiguousarray(gradients), weights)
