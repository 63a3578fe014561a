"""scikit-fem's elements and quadrature, tabulated in the node order of the mesh.

A mesh lists an element's nodes in meshio's order (VTK's), scikit-fem its basis functions in its
own; both place each of them on the reference cell, and the tables are matched by that place. The
trap is the ten-node tetrahedron, whose last two mid-edge nodes gmsh swaps: meshio undoes it.

The quadrature rule of degree 5 with 14 points on the tetrahedron:
Walkington, Quadrature on simplices of arbitrary dimension, Carnegie Mellon University, 2000. Two
points lie on each line from a corner to the middle of the opposite face, and two on each line that
joins the middles of opposite edges. (scikit-fem's tables of degrees 5 to 8 miss moments by 1e-6 to
2e-5, measured.)
"""

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from skfem import element, quadrature

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError

_TOWARDS_CORNERS = (  # barycentric coordinate of three corners, share of the volume
    (0.31088591926330060980, 0.11268792571801585080),
    (0.092735250310891226402, 0.073493043116361949544),
)
_TOWARDS_EDGES = (0.045503704125649649492, 0.042546020777081466438)  # that of two corners


def tetrahedron_rule() -> tuple[Floats, Floats]:
    """Points (14, 3) on the reference tetrahedron and weights (14,), which sum to 1/6."""
    places, shares = [], []
    for coordinate, share in _TOWARDS_CORNERS:
        for corner in range(4):
            place = np.full(4, coordinate)
            place[corner] = 1 - 3 * coordinate
            places.append(place)
            shares.append(share)
    coordinate, share = _TOWARDS_EDGES
    for pair in combinations(range(4), 2):
        place = np.full(4, 0.5 - coordinate)
        place[list(pair)] = coordinate
        places.append(place)
        shares.append(share)
    return np.array(places)[:, 1:], np.array(shares) / 6


_TETRA = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
_TETRA_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
_HEXA = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
_HEXA_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
_HEXA_EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
_HEXA_FACES = [[0, 0.5, 0.5], [1, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 1, 0.5], [0.5, 0.5, 0]]
_HEXA_FACES += [[0.5, 0.5, 1]]


def _with_edges(corners: list[list[int]], edges: list[tuple[int, int]]) -> Floats:
    points = np.array(corners, float)
    middles = np.array([(points[a] + points[b]) / 2 for a, b in edges])
    return np.vstack([points, middles])


# meshio's cell type: scikit-fem's element, the nodes' places in meshio's order, and the degree
# that the quadrature integrates exactly. Mass and stiffness of a straight-sided element need no
# more, but curved sides do: in tetra10 degree 4 is 2e-3 off the exact integrals in a study's
# frequencies on a medium mesh, and degree 5, with 14 points instead of 11, 5e-4.
_CELLS = {
    "tetra": (element.ElementTetP1, np.array(_TETRA, float), 2),
    "tetra10": (element.ElementTetP2, _with_edges(_TETRA, _TETRA_EDGES), 5),
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
    points : (q, 3) float
        Quadrature points on the reference cell.
    weights : (q,) float
        Quadrature weights; they sum to the reference cell's volume.
    """

    nodes: Floats
    values: Floats
    gradients: Floats
    points: Floats
    weights: Floats


def reference_element(cell_type: str) -> ReferenceElement:
    """Tables of a cell type, by meshio's name."""
    make, nodes, degree = _known(cell_type)
    if cell_type == "tetra10":
        points, weights = tetrahedron_rule()
    else:
        columns, weights = quadrature.get_quadrature(make().refdom, degree)
        points = columns.T
    values, gradients = shape_functions(cell_type, points)
    return ReferenceElement(nodes, values, gradients, points, weights)


def shape_functions(cell_type: str, points: Floats) -> tuple[Floats, Floats]:
    """Basis functions (q, k) of a cell type and their derivatives (q, k, 3) at points (q, 3).

    Points and derivatives are those of the reference cell, nodes in meshio's order.
    """
    make, nodes, _ = _known(cell_type)
    basis = make()
    distance = np.linalg.norm(nodes[:, None] - basis.doflocs[None], axis=2)
    order = np.argmin(distance, axis=1)
    assert distance[np.arange(len(nodes)), order].max() < 1e-12
    zero = np.zeros(len(points))
    tables = [basis.lbasis(points.T, i) for i in order]
    values = np.array([value + zero for value, _ in tables]).T
    slopes = [np.array([row + zero for row in slope]) for _, slope in tables]
    return values, np.ascontiguousarray(np.array(slopes).transpose(2, 0, 1))


def sampling(cell_type: str) -> tuple[Floats, Floats]:
    """Where the strains of an element are best, and how they reach its nodes."""
    make, nodes, _ = _known(cell_type)
    found, _ = quadrature.get_quadrature(
        make().refdom, {"tetra": 1, "tetra10": 2}.get(cell_type, 3)
    )
    points = np.ascontiguousarray(found.T)
    if len(points) == 1:
        return points, np.ones((len(nodes), 1))
    linear = linear_type(cell_type)
    at_points, _ = shape_functions(linear, points)
    at_nodes, _ = shape_functions(linear, nodes)
    return points, at_nodes @ np.linalg.inv(at_points)


def linear_type(cell_type: str) -> str:
    """The cell type that has an element's corners alone."""
    return "tetra" if cell_type.startswith("tetra") else "hexahedron"


def _known(cell_type: str) -> tuple[Any, Floats, int]:
    if cell_type not in _CELLS:
        raise InputError(f"cell_type = {cell_type!r}: the solid elements are {', '.join(_CELLS)}")
    return _CELLS[cell_type]
