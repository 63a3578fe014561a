"""Reference cells of solid elements, the outside of a mesh, and how good its tetrahedra are.

Shape functions are the polynomials in given monomials that are one at their own node and zero at
the others (any textbook on finite elements); the monomials alone distinguish a serendipity
element from a complete one. Nodes are in meshio's order, VTK's.
"""

from dataclasses import dataclass
from functools import cache
from itertools import permutations, product

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.mesh.part import Part

_TETRA = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
_TETRA_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
_TETRA_FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]  # outwards
_HEXA = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
_HEXA_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
_HEXA_EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
_HEXA_FACES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
_HEXA_CENTRES = [(0, 0.5, 0.5), (1, 0.5, 0.5), (0.5, 0, 0.5), (0.5, 1, 0.5), (0.5, 0.5, 0)]
_HEXA_CENTRES += [(0.5, 0.5, 1), (0.5, 0.5, 0.5)]


@dataclass(frozen=True)
class Cell:
    """A reference cell, of a solid element or of a face.

    Attributes
    ----------
    nodes : (k, d) float
        Place of each node.
    powers : (k, d) int
        Exponents of the monomials.
    corners : int
        How many of the nodes, the first ones, are corners.
    faces : (f, m) int
        Nodes of each face: its corners, the outward normal by the right-hand rule, the middles of
        the sides between them, the centre. None on a face.
    """

    nodes: Floats
    powers: Integers
    corners: int
    faces: Integers

    def slopes(self, positions: Floats) -> Floats:
        """Derivatives (q, k, d) of the shape functions at positions (q, d)."""
        coefficients = np.linalg.inv(_monomials(self.nodes, self.powers))
        columns = []
        for axis in range(self.nodes.shape[1]):
            lowered = self.powers.copy()
            lowered[:, axis] = np.maximum(lowered[:, axis] - 1, 0)
            slope = _monomials(positions, lowered) * self.powers[:, axis]
            columns.append(slope @ coefficients)
        return np.stack(columns, axis=-1)

    def values(self, positions: Floats) -> Floats:
        """Shape functions (q, k) at positions (q, d)."""
        return np.asarray(
            _monomials(positions, self.powers) @ np.linalg.inv(_monomials(self.nodes, self.powers))
        )


def _monomials(positions: Floats, powers: Integers) -> Floats:
    return np.asarray(np.prod(positions[:, None, :] ** powers[None], axis=2))


def _powers(dimension: int, allowed: str) -> Integers:
    """Exponents up to 2 of a linear or quadratic simplex, a serendipity or a complete cube."""
    every = np.array(list(product(range(3), repeat=dimension)))
    kept = {
        "simplex1": every.sum(axis=1) <= 1,
        "simplex2": every.sum(axis=1) <= 2,
        "cube1": every.max(axis=1) <= 1,
        # Those of superlinear degree 2 (Arnold and Awanou, The serendipity family of finite
        # elements, Found. Comput. Math. 11 (2011) 337-344): exponents of 1 do not count.
        "serendipity": (every * (every > 1)).sum(axis=1) <= 2,
        "cube2": every.max(axis=1) <= 2,
    }[allowed]
    return np.asarray(every[kept])


@cache
def solid(cell_type: str) -> Cell:
    """Reference cell of a solid element, by meshio's name; KeyError for any other."""
    tetra = cell_type.startswith("tetra")
    corners = np.array(_TETRA if tetra else _HEXA, float)
    edges = np.array(_TETRA_EDGES if tetra else _HEXA_EDGES)
    middles = corners[edges].mean(axis=1)
    places = {
        "tetra": [corners],
        "tetra10": [corners, middles],
        "hexahedron": [corners],
        "hexahedron20": [corners, middles],
        "hexahedron27": [corners, middles, np.array(_HEXA_CENTRES)],
    }[cell_type]
    nodes = np.concatenate(places)
    families = ("simplex1", "simplex2", "cube1", "serendipity", "cube2")
    allowed = dict(zip(SOLIDS, families, strict=True))
    faces = []
    for face in _TETRA_FACES if tetra else _HEXA_FACES:
        around = corners[list(face)]
        wanted = [*around, *(0.5 * (around + np.roll(around, -1, axis=0))), around.mean(axis=0)]
        distance = np.abs(nodes[None] - np.array(wanted)[:, None]).max(axis=2)
        faces.append([int(row.argmin()) for row in distance if row.min() < 1e-12])
    powers = _powers(3, allowed[cell_type])
    return Cell(nodes, powers, len(corners), np.array(faces, np.int64))


SOLIDS = ("tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27")
"""The solid elements, by meshio's names."""


@cache
def surface(count: int) -> Cell:
    """Reference cell of a face with 3, 6, 4, 8 or 9 nodes."""
    triangle = count in (3, 6)
    corners = np.array([(0, 0), (1, 0), (0, 1)] if triangle else [(0, 0), (1, 0), (1, 1), (0, 1)])
    around = corners.astype(float)
    nodes = np.concatenate(
        [around, 0.5 * (around + np.roll(around, -1, axis=0)), around.mean(axis=0)[None]]
    )[:count]
    allowed = {3: "simplex1", 6: "simplex2", 4: "cube1", 8: "serendipity", 9: "cube2"}[count]
    return Cell(nodes, _powers(2, allowed), len(corners), np.empty((0, 0), np.int64))


def exterior(cells: Integers, reference: Cell) -> Integers:
    """(f, m) nodes of the faces that belong to one element only, outward by the right-hand rule."""
    faces = cells[:, reference.faces].reshape(-1, reference.faces.shape[1])
    corners = 3 if reference.corners == 4 else 4
    key = np.sort(faces[:, :corners], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return np.asarray(faces[np.sort(first[count == 1])])


def area_vectors(points: Floats, faces: Integers, places: Floats) -> Floats:
    """(f, q, 3) outward normals times dA over dξ dη at places (q, 2) of curved faces (f, m), m²."""
    slopes = surface(faces.shape[1]).slopes(places)
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
    share = weight @ cell.values(place) ** 2
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
