"""The skin of a part: what a picture shows of its elements, extracted once."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.mesh import Part

# Faces of an element (its corners in order, seen from outside), then the triangles that draw each
# face through its mid-edge nodes too, so that a quadratic shape bends in the picture.
_SIX: Final = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))  # corners 0-2, mid-edges 3-5
_EIGHT: Final = ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7))
_NINE: Final = tuple((a, b, 8) for a, b in ((0, 4), (4, 1), (1, 5), (5, 2))) + tuple(
    (a, b, 8) for a, b in ((2, 6), (6, 3), (3, 7), (7, 0))
)
_TETRA10: Final = ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6))
_HEXA20: Final = (
    (0, 3, 2, 1, 11, 10, 9, 8),
    (4, 5, 6, 7, 12, 13, 14, 15),
    (0, 1, 5, 4, 8, 17, 12, 16),
    (1, 2, 6, 5, 9, 18, 13, 17),
    (2, 3, 7, 6, 10, 19, 14, 18),
    (3, 0, 4, 7, 11, 16, 15, 19),
)
_HEXA27: Final = tuple(
    (*face, middle) for face, middle in zip(_HEXA20, (24, 25, 22, 21, 23, 20), strict=True)
)
_LINEAR: Final = {"tetra10": "tetra", "hexahedron20": "hexahedron", "hexahedron27": "hexahedron"}
_FACES: Final[dict[str, tuple[int, tuple[tuple[int, ...], ...], tuple[tuple[int, ...], ...]]]] = {
    "tetra": (3, tuple(face[:3] for face in _TETRA10), ((0, 1, 2),)),
    "tetra10": (3, _TETRA10, _SIX),
    "hexahedron": (4, tuple(face[:4] for face in _HEXA20), ((0, 1, 2), (0, 2, 3))),
    "hexahedron20": (4, _HEXA20, _EIGHT),
    "hexahedron27": (4, _HEXA27, _NINE),
}


BEND: Final = 35.0
"""Angle in degrees beyond which an edge belongs to the outline."""


@dataclass(frozen=True)
class Surface:
    """Triangles of a part's skin over its own nodes.

    Attributes
    ----------
    nodes : (m,) int
        The part's nodes on the skin, ascending: `part.points[nodes]`, `shape[nodes]`.
    triangles : (t, 3) int
        Into `nodes`, counter-clockwise seen from outside.
    outline : (k, 2) int
        Into `nodes`: edges where the skin bends by more than 35 degrees.
    mesh_edges : (g, 2) int
        Into `nodes`: the elements' edges on the skin, in halves where they have a mid-edge node.
    cyclic : (t,) bool
        Triangles on the sector's left and right faces, which a full ring hides.
    """

    nodes: Integers
    triangles: Integers
    outline: Integers
    mesh_edges: Integers
    cyclic: Booleans


def surface(part: Part, corners_only: bool = False) -> Surface:
    """Extract the skin of a part of tetrahedra or hexahedra, linear or quadratic."""
    if part.cell_type not in _FACES:
        allowed = ", ".join(_FACES)
        raise InputError(f"{part.name}: element type {part.cell_type}: pictures know {allowed}")
    drawn_type = _LINEAR.get(part.cell_type, part.cell_type) if corners_only else part.cell_type
    corners, faces, drawn = _FACES[drawn_type]
    every = np.concatenate([part.cells[:, list(face)] for face in faces])
    key = _packed(np.sort(every[:, :corners], axis=1), len(part.points))
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    skin = every[np.sort(first[count == 1])]  # a face of one element alone lies outside
    triangles = np.concatenate([skin[:, list(corner)] for corner in drawn])
    nodes, numbered = np.unique(triangles, return_inverse=True)
    numbered = numbered.reshape(-1, 3)
    place = np.full(len(part.points), -1)
    place[nodes] = np.arange(len(nodes))
    return Surface(
        nodes=nodes,
        triangles=numbered,
        outline=bent_edges(part.points[nodes], numbered),
        mesh_edges=_mesh_edges(place[skin], corners),
        cyclic=np.tile(_cyclic(part, skin[:, :corners]), len(drawn)),
    )


def _cyclic(part: Part, faces: Integers) -> Booleans:
    """Which faces have all their corners on the left, or all on the right cyclic face."""
    hidden = np.zeros(len(faces), bool)
    for name in ("left", "right"):
        if name in part.node_sets:
            hidden |= np.isin(faces, part.node_sets[name]).all(axis=1)
    return hidden


def bent_edges(points: Floats, triangles: Integers) -> Integers:
    """(k, 2) edges whose triangles turn by more than `BEND` degrees, or are other than two."""
    edges, _, cosine = skin_edges(points, triangles)
    bent: Integers = edges[cosine < np.cos(np.radians(BEND))]
    return bent


def skin_edges(points: Floats, triangles: Integers) -> tuple[Integers, Integers, Floats]:
    """Edges (e, 2) in order, both triangles (e, 2) of each, and the cosine between their normals.

    Of an edge with other than two triangles these are -1, and the cosine is -2.
    """
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.where(length > 0, length, 1)
    edges = np.sort(np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    key = _packed(edges, len(points))
    order = np.argsort(key, kind="stable")
    key, owner = key[order], owner[order]
    _, start, count = np.unique(key, return_index=True, return_counts=True)
    mates = np.full((len(start), 2), -1)
    mates[count == 2] = owner[start[count == 2, None] + [0, 1]]
    cosine = np.full(len(start), -2.0)
    one, other = mates[count == 2].T
    cosine[count == 2] = np.sum(normal[one] * normal[other], axis=1)
    return edges[order[start]], mates, cosine


def _mesh_edges(faces: Integers, corners: int) -> Integers:
    """Edges of the elements' faces, each once, in two halves where a mid-edge node is there."""
    pieces = []
    for i in range(corners):
        j = (i + 1) % corners
        if faces.shape[1] == corners:
            pieces.append(faces[:, [i, j]])
        else:
            pieces += [faces[:, [i, corners + i]], faces[:, [corners + i, j]]]
    edges = np.sort(np.concatenate(pieces), axis=1)
    first = np.unique(_packed(edges, int(edges.max()) + 1), return_index=True)[1]
    found: Integers = edges[first]
    return found


def _packed(rows: Integers, count: int) -> Integers:
    """One number for each row of numbers below `count`, in the rows' order, where they fit.

    Numbers are sorted ten times faster than rows. Four corners of up to 55,000 nodes fit into a
    number of 64 bits; beyond, the last two columns are left to a second number.
    """
    if count ** rows.shape[1] < 2**63:
        return np.asarray(rows @ count ** np.arange(rows.shape[1])[::-1])
    head, tail = rows[:, :2] @ [count, 1], rows[:, 2:] @ count ** np.arange(rows.shape[1] - 2)[::-1]
    numbered = np.unique(tail, return_inverse=True)[1]
    return np.asarray(np.unique(head, return_inverse=True)[1] * (numbered.max() + 1) + numbered)
