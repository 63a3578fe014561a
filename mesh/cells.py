"""Reference cells of solid elements, the faces on the outside of a mesh, and its nodes' areas.

Shape functions are the polynomials in given monomials that are one at their own node and zero at
the others (any textbook on finite elements); the monomials alone distinguish a serendipity
element from a complete one. Nodes are in meshio's order, VTK's.
"""

from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from vanelock.common.arrays import Floats, Integers

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
