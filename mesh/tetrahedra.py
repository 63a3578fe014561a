"""Figures of a tetrahedral mesh: counts, volume, and the worst element."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.mesh.part import Part

# Corners of the reference tetrahedron, then the middles of its edges in meshio's order.
_CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
_NODES = np.concatenate([_CORNERS, _CORNERS[_EDGES].mean(axis=1)])
_FACES = np.array([[1, 1, 1], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) / 3  # centroids
_SLOPES = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])  # of the four corners
_REGULAR = np.array([[1, 0.5, 0.5], [0, np.sqrt(3) / 2, np.sqrt(3) / 6], [0, 0, np.sqrt(2 / 3)]])


@dataclass(frozen=True)
class Quality:
    """Figures of a mesh.

    Attributes
    ----------
    nodes, elements : int
        Counts.
    volume : float
        Sum over the elements, m³.
    smallest_jacobian : float
        Smallest determinant of the map from the reference element, m³; positive in a valid mesh.
    smallest_sicn : float
        Smallest signed inverse condition number of the elements, 1 for a regular tetrahedron and
        negative for an inverted one.
    """

    nodes: int
    elements: int
    volume: float
    smallest_jacobian: float
    smallest_sicn: float


def quality(part: Part) -> Quality:
    """Figures of a mesh of tetrahedra, straight or curved.

    Determinants and condition numbers are taken at every node of every element. The volume is
    exact: the determinant of a quadratic element is a cubic, which corners and centroids of the
    faces integrate with weights 1/240 and 9/240.

    Raises
    ------
    InputError
        If the elements are not tetrahedra.
    """
    if part.cell_type not in ("tetra", "tetra10"):
        raise InputError(f"{part.name}: quality needs tetrahedra, not {part.cell_type}")
    J = jacobians(part, _NODES[: part.cells.shape[1]])
    determinant = np.linalg.det(J)
    A = J @ np.linalg.inv(_REGULAR)
    with np.errstate(divide="ignore", invalid="ignore"):
        # 3 / (|A| |A^-1|), with A^-1 = adj(A)/det(A) so that a flat element counts as zero.
        cofactor = np.stack([np.cross(A[..., (k + 1) % 3], A[..., (k + 2) % 3]) for k in range(3)])
        norms = np.linalg.norm(A, axis=(-2, -1)) * np.sqrt((cofactor**2).sum(axis=(0, -1)))
        sicn = 3 * np.linalg.det(A) / norms
    corners = np.linalg.det(jacobians(part, _CORNERS)).sum()
    faces = np.linalg.det(jacobians(part, _FACES)).sum()
    return Quality(
        nodes=len(part.points),
        elements=len(part.cells),
        volume=float(corners / 240 + 9 * faces / 240),
        smallest_jacobian=float(determinant.min()),
        smallest_sicn=float(np.nan_to_num(sicn, nan=0.0).min()),
    )


def valid(part: Part) -> Part:
    """The part itself, if every element is the right way round.

    Raises
    ------
    InputError
        If an element is flat or inverted at any of its nodes.
    """
    worst = quality(part).smallest_jacobian
    if not worst > 0:
        raise InputError(
            f"{part.name}: an element is inverted (Jacobian {worst:.2g} m^3): "
            "choose another mesh.size"
        )
    return part


def jacobians(part: Part, positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Derivative of place by reference coordinates at positions (q, 3): (e, q, 3, 3), m."""
    gradients = np.array([_gradients(position, part.cells.shape[1]) for position in positions])
    return np.asarray(np.einsum("eia,qib->eqab", part.points[part.cells], gradients))


def _gradients(position: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Slopes (count, 3) of the linear or quadratic shape functions at a reference position."""
    if count == 4:
        return _SLOPES
    corner = np.array([1 - position.sum(), *position])
    first, second = _EDGES.T
    edge = corner[first, None] * _SLOPES[second] + corner[second, None] * _SLOPES[first]
    return np.concatenate([(4 * corner - 1)[:, None] * _SLOPES, 4 * edge])
