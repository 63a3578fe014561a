"""Reference cells of solid elements, the outside of a mesh, and how good its tetrahedra are.

Basis functions are scikit-fem's; a mesh lists an element's nodes in meshio's order (VTK's),
scikit-fem its functions in its own, and both place each of them on the reference cell: the tables
are matched by that place.
"""

from dataclasses import dataclass
from functools import cache
from itertools import permutations
from typing import Any

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.mesh.part import Part

_TETRA = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
_TETRA_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
_TETRA_FACES = [(0, 3, 2), (0, 1, 3), (0, 2, 1), (1, 2, 3)]  # outwards
_HEXA = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
_HEXA_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
_HEXA_EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
_HEXA_FACES = [(3, 0, 4, 7), (1, 2, 6, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 3, 2, 1), (4, 5, 6, 7)]
_HEXA_CENTRES = [(0, 0.5, 0.5), (1, 0.5, 0.5), (0.5, 0, 0.5), (0.5, 1, 0.5), (0.5, 0.5, 0)]
_HEXA_CENTRES += [(0.5, 0.5, 1), (0.5, 0.5, 0.5)]

_ELEMENTS = {
    "tetra": "ElementTetP1",
    "tetra10": "ElementTetP2",
    "hexahedron": "ElementHex1",
    "hexahedron20": "ElementHexS2",
    "hexahedron27": "ElementHex2",
}
_OF_FACES = {
    3: "ElementTriP1",
    6: "ElementTriP2",
    4: "ElementQuad1",
    8: "ElementQuadS2",
    9: "ElementQuad2",
}
"""By the number of nodes."""
SOLIDS = tuple(_ELEMENTS)
"""The solid elements, by meshio's names."""


@dataclass(frozen=True)
class Cell:
    """A reference cell, of a solid element or of a face."""

    nodes: Floats  # (k, d), place of each
    corners: int  # how many of the nodes, the first ones, are corners
    faces: Integers
    """(f, m) nodes of each face: its corners, outward by the right-hand rule, the middles of the
    sides between them, the centre. None on a face."""
    element: Any  # scikit-fem's

    def functions(self, positions: Floats) -> tuple[Floats, Floats]:
        """Basis functions (q, k) at positions (q, d), and their derivatives (q, k, d)."""
        zero = np.zeros(len(positions))
        away = np.linalg.norm(self.nodes[:, None] - self.element.doflocs, axis=2)
        tables = [self.element.lbasis(positions.T, i) for i in away.argmin(axis=1)]
        values = np.array([value + zero for value, _ in tables]).T
        slopes = [np.array([row + zero for row in slope]) for _, slope in tables]
        return values, np.ascontiguousarray(np.array(slopes).transpose(2, 0, 1))


def _element(name: str) -> Any:
    from skfem import element  # takes a third of a second, and checks need no functions

    return getattr(element, name)()


def linear_type(cell_type: str) -> str:
    """The cell type that has a solid element's corners alone."""
    return "tetra" if cell_type.startswith("tetra") else "hexahedron"


@cache
def solid(cell_type: str) -> Cell:
    """Reference cell of a solid element, by meshio's name."""
    if cell_type not in _ELEMENTS:
        raise InputError(f"cell_type = {cell_type!r}: the solid elements are {', '.join(SOLIDS)}")
    tetra = linear_type(cell_type) == "tetra"
    corners = np.array(_TETRA if tetra else _HEXA, float)
    middles = corners[np.array(_TETRA_EDGES if tetra else _HEXA_EDGES)].mean(axis=1)
    element = _element(_ELEMENTS[cell_type])
    nodes = np.concatenate([corners, middles, _HEXA_CENTRES])[: len(element.doflocs)]
    faces = []
    for face in _TETRA_FACES if tetra else _HEXA_FACES:
        places = _around(corners[list(face)])
        distance = np.abs(nodes[None] - places[:, None]).max(axis=2)
        faces.append([int(row.argmin()) for row in distance if row.min() < 1e-12])
    return Cell(nodes, len(corners), np.array(faces, np.int64), element)


@cache
def surface(count: int) -> Cell:
    """Reference cell of a face with 3, 6, 4, 8 or 9 nodes."""
    triangle = count in (3, 6)
    corners = np.array([(0, 0), (1, 0), (0, 1)] if triangle else [(0, 0), (1, 0), (1, 1), (0, 1)])
    nodes = _around(corners.astype(float))[:count]
    return Cell(nodes, len(corners), np.empty((0, 0), np.int64), _element(_OF_FACES[count]))


def _around(corners: Floats) -> Floats:
    """Corners of a face, the middles of the sides between them, and its centre."""
    middles = 0.5 * (corners + np.roll(corners, -1, axis=0))
    return np.concatenate([corners, middles, corners.mean(axis=0)[None]])


def single(corners: Integers) -> Integers:
    """Which of the faces (f, c), by their corners, belong to one element only, ascending."""
    key = np.sort(corners, axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return np.sort(first[count == 1])


def exterior(cells: Integers, reference: Cell) -> Integers:
    """(f, m) nodes of the faces that belong to one element only, outward by the right-hand rule."""
    faces = cells[:, reference.faces].reshape(-1, reference.faces.shape[1])
    return np.asarray(faces[single(faces[:, : 3 if reference.corners == 4 else 4])])


def area_vectors(points: Floats, faces: Integers, places: Floats) -> Floats:
    """(f, q, 3) outward normals times dA over dξ dη at places (q, 2) of curved faces (f, m), m²."""
    _, slopes = surface(faces.shape[1]).functions(places)
    tangents = np.einsum("fkx,qkd->fqdx", points[faces], slopes)
    return np.asarray(np.cross(tangents[:, :, 0], tangents[:, :, 1]))


def normals(points: Floats, faces: Integers) -> tuple[Floats, Floats]:
    """Unit outward normals (f, m, 3) of curved faces at each of their nodes, and areas (f,).

    A normal is zero where the face's sides lie on one line. The areas, of the corners' polygons,
    serve as weights.
    """
    cell = surface(faces.shape[1])
    normal = area_vectors(points, faces, cell.nodes)
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    corners = points[faces[:, : cell.corners]] - points[faces[:, [0]]]
    polygon = np.cross(corners[:, 1:-1], corners[:, 2:]).sum(axis=1)
    unit = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    return unit, 0.5 * np.linalg.norm(polygon, axis=1)


_ALIKE = np.cos(np.radians(45.0))  # a face and the contact at its nodes


def nodal_areas(points: Floats, faces: Integers, nodes: Integers, normal: Floats) -> Floats | None:
    """Area of each node of a set of contact nodes, m².

    The faces whose corners all belong to the set, and which look along the normals there, share
    their area among their nodes in the ratio of ∫ N_i², which is positive even where ∫ N_i is not
    (E. Hinton, T. Rock, O. C. Zienkiewicz, A note on mass lumping and related processes in the
    finite element method, Earthquake Engng Struct. Dyn. 4 (1976) 245-249).
    """
    cell = surface(faces.shape[1])
    whole = faces[np.isin(faces[:, : cell.corners], nodes).all(axis=1)]
    if not len(whole):
        return None
    place, weight = _quadrature(cell.corners)
    vectors = area_vectors(points, whole, place)
    order = np.argsort(nodes)
    first = order[np.searchsorted(nodes, whole[:, 0], sorter=order)]
    mean = np.einsum("q,fqx->fx", weight, vectors)
    along = np.sum(mean * normal[first], axis=1) > _ALIKE * np.linalg.norm(mean, axis=1)
    area = np.linalg.norm(vectors, axis=2)[along] @ weight
    share = weight @ cell.functions(place)[0] ** 2
    found = np.zeros(len(points))
    np.add.at(found, whole[along], area[:, None] * share / share.sum())
    return found[nodes] if (found[nodes] > 0).all() else None


def _quadrature(corners: int) -> tuple[Floats, Floats]:
    """Gauss points (q, 2) and weights (q,) of the square, or folded onto the triangle."""
    x, w = np.polynomial.legendre.leggauss(4)
    u, v = (grid.ravel() for grid in np.meshgrid(0.5 * (x + 1), 0.5 * (x + 1), indexing="ij"))
    weight = np.outer(w, w).ravel() / 4
    if corners == 4:
        return np.column_stack([u, v]), weight
    return np.column_stack([u, v * (1 - u)]), weight * (1 - u)


_CENTROIDS = np.array([[1, 1, 1], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) / 3  # of the faces
REGULAR = np.array([[1, 0.5, 0.5], [0, np.sqrt(3) / 2, np.sqrt(3) / 6], [0, 0, np.sqrt(2 / 3)]])
"""Edges of a regular tetrahedron over those of the reference one, as columns."""


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
    corners = np.linalg.det(_jacobians(points, cells, solid("tetra").nodes)).sum()
    faces = np.linalg.det(_jacobians(points, cells, _CENTROIDS)).sum()
    return Quality(
        nodes=len(part.points),
        elements=len(part.cells),
        volume=float(corners / 240 + 9 * faces / 240),
        smallest_jacobian=float(jacobian_bounds(points, cells).min()),
        smallest_sicn=float(condition(points, cells).min()),
    )


def condition(points: Floats, cells: Integers) -> Floats:
    """Signed inverse condition numbers (SICN) (e,) of tetrahedra that elements' corners span."""
    return inverse_condition(_jacobians(points, cells[:, :4], np.zeros((1, 3)))[:, 0], REGULAR)


def inverse_condition(jacobians: Floats, perfect: Floats) -> Floats:
    """3 / (|A| |A^-1|), A making the element of a perfect one: 1 for that, 0 for a flat one."""
    A = jacobians @ np.linalg.inv(perfect)
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
    a, b, c = np.moveaxis(_jacobians(points, cells, solid("tetra").nodes), -1, 0)  # each (e, 4, 3)
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
    _, slopes = solid("tetra" if cells.shape[1] == 4 else "tetra10").functions(positions)
    return np.asarray(np.einsum("eia,qib->eqab", points[cells], slopes))
