"""Figures of a tetrahedral mesh: counts, volume, and the worst element."""

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.mesh.part import Part

# Corners of the reference tetrahedron, then the middles of its edges in meshio's order.
_CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
_FACES = np.array([[1, 1, 1], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) / 3  # centroids
_CORNER_SLOPES = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])  # of the four corners
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
        Smallest of the elements' `jacobian_bounds`: 1 if all are straight-sided and the right way
        round; if it is positive, no element is inverted anywhere.
    smallest_sicn : float
        Smallest signed inverse condition number of the tetrahedra that the elements' corners span,
        1 for a regular one, near 0 for a sliver and negative for an inverted one.
    """

    nodes: int
    elements: int
    volume: float
    smallest_jacobian: float
    smallest_sicn: float


def quality(part: Part) -> Quality:
    """Figures of a mesh of tetrahedra, straight or curved.

    The condition number finds slivers, by the corners alone; the Jacobian finds what curved sides
    do to an element. The volume is exact: the determinant of a quadratic element is a cubic, which
    corners and centroids of the faces integrate with weights 1/240 and 9/240.

    Raises
    ------
    InputError
        If the elements are not tetrahedra.
    """
    if part.cell_type not in ("tetra", "tetra10"):
        raise InputError(f"{part.name}: quality needs tetrahedra, not {part.cell_type}")
    points, cells = part.points, part.cells
    corners = np.linalg.det(_jacobians(points, cells, _CORNERS)).sum()
    faces = np.linalg.det(_jacobians(points, cells, _FACES)).sum()
    return Quality(
        nodes=len(part.points),
        elements=len(part.cells),
        volume=float(corners / 240 + 9 * faces / 240),
        smallest_jacobian=float(jacobian_bounds(points, cells).min()),
        smallest_sicn=float(condition(points, cells).min()),
    )


def condition(points: Floats, cells: Integers) -> Floats:
    """Signed inverse condition numbers (SICN) (e,) of the tetrahedra that elements' corners span.

    3 / (|A| |A^-1|), where A makes the element of a regular one: 1 for that, 0 for a flat one.
    """
    A = _jacobians(points, cells[:, :4], _CORNERS[:1])[:, 0] @ np.linalg.inv(_REGULAR)
    with np.errstate(divide="ignore", invalid="ignore"):
        # A^-1 = adj(A)/det(A), so that a flat element counts as zero.
        cofactor = np.stack([np.cross(A[..., (k + 1) % 3], A[..., (k + 2) % 3]) for k in range(3)])
        norms = np.linalg.norm(A, axis=(-2, -1)) * np.sqrt((cofactor**2).sum(axis=(0, -1)))
        sicn = 3 * np.linalg.det(A) / norms
    return np.asarray(np.nan_to_num(sicn, nan=0.0))


def jacobian_bounds(points: Floats, cells: Integers) -> Floats:
    """Lower bounds on the elements' determinants, relative to the elements with straight sides.

    The derivatives of place by the reference coordinates, J = [a b c], are linear in a quadratic
    element, Σ λ_i [a_i b_i c_i] with the values at the corners. So det J is a cubic,

        det J = Σ_ijk λ_i λ_j λ_k β_ijk,    β_ijk = mean of det[a b c] over the orders of i, j, k,

    an average of the 20 different β with weights that are positive and sum to one, and no smaller
    than the smallest (the polynomial's Bézier form; Johnen, Remacle and Geuzaine, J. Comput. Phys.
    233, 2013). The bound is attained if a corner's determinant β_iii is the smallest.
    """
    a, b, c = np.moveaxis(_jacobians(points, cells, _CORNERS), -1, 0)  # each (e, 4, 3)
    one_order = np.einsum("eix,ejkx->eijk", a, np.cross(b[:, :, None], c[:, None, :]))
    orders = [one_order.transpose(0, *order) for order in permutations((1, 2, 3))]
    smallest = np.mean(orders, axis=0).min(axis=(1, 2, 3))
    straight = np.abs(np.linalg.det(points[cells[:, 1:4]] - points[cells[:, :1]]))
    flat = np.full(len(cells), -np.inf)
    return np.asarray(np.divide(smallest, straight, out=flat, where=straight > 0))


def valid(part: Part) -> Part:
    """The part itself, if every element is the right way round."""
    worst = quality(part).smallest_jacobian
    if not worst > 0:
        raise InputError(
            f"{part.name}: an element is inverted (Jacobian {worst:.2g} of a straight one's): "
            "choose another mesh.size"
        )
    return part


def _jacobians(points: Floats, cells: Integers, positions: Floats) -> Floats:
    """Derivative of place by reference coordinates at positions (q, 3): (e, q, 3, 3), m."""
    barycentric = np.column_stack([1 - positions.sum(axis=1), positions])
    if cells.shape[1] == 4:
        slopes = np.broadcast_to(_CORNER_SLOPES, (len(positions), 4, 3))
    else:
        slopes = quadratic_slopes(barycentric)
    return np.asarray(np.einsum("eia,qib->eqab", points[cells], slopes))


def quadratic_shapes(barycentric: Floats) -> Floats:
    """The ten shape functions (q, 10), in meshio's order, at barycentric positions (q, 4)."""
    L = barycentric
    first, second = _EDGES.T
    return np.hstack([L * (2 * L - 1), 4 * L[:, first] * L[:, second]])


def quadratic_slopes(barycentric: Floats) -> Floats:
    """Their derivatives (q, 10, 3) by the reference coordinates, barycentric 1 to 3."""
    L = barycentric[..., None]
    first, second = _EDGES.T
    edge = L[:, first] * _CORNER_SLOPES[second] + L[:, second] * _CORNER_SLOPES[first]
    return np.concatenate([(4 * L - 1) * _CORNER_SLOPES, 4 * edge], axis=1)
