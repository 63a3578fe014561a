"""Meshes of hexahedra from blocks: lattices between curves, swept, and glued where they meet.

A block is a lattice of points with an odd number of them in every direction: the corners of its
elements and all that lies half-way. Blocks that share a face must have the same points there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vanelock.mesh import Part
from vanelock.mesh.cells import solid

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Curve = Callable[[Floats], Floats]  # (n,) shares of the way from 0 to 1: (n, 2) points

TOLERANCE = 1e-9  # m, between like points of two blocks
GROWTH = 0.6

# Places of the nodes in an element's 3 x 3 x 3 points: corners, edges, faces, centre, in meshio's
# order.
_CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
_EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
_FACES = [(0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1)]
_MIDDLES = [tuple((np.array(_CORNERS[a]) + _CORNERS[b]) // 2) for a, b in _EDGES]
_PLACES = np.array([*_CORNERS, *_MIDDLES, *_FACES])
NODES = {"hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27}


def straight(start: Floats, end: Floats) -> Curve:
    """The straight line between two points."""
    return lambda t: start + np.multiply.outer(t, end - start)


def shares(
    length: float,
    size: float,
    corner: float | None = None,
    at: tuple[bool, bool] = (True, True),
) -> Floats:
    """The lattice's points along a side, as shares of the way: an odd number from 0 to 1.

    Parameters
    ----------
    length, size : float
        Of the side and about of an element, m.
    corner : float, optional
        Size at the ends, m, from which elements grow by `GROWTH` of the distance.
    at : (bool, bool)
        Which ends have such small elements.
    """
    way = np.linspace(0.0, length, 2001)
    local = np.full_like(way, size)
    if corner is not None:
        for distance in (way,) * at[0] + (way[::-1],) * at[1]:
            local = np.minimum(local, corner + GROWTH * distance)
    number = np.append(0.0, np.cumsum(0.5 * (1 / local[1:] + 1 / local[:-1]) * np.diff(way)))
    count = max(1, round(float(number[-1])))
    corners = np.interp(np.linspace(0.0, number[-1], count + 1), number, way / length)
    points = np.empty(2 * count + 1)
    points[::2] = corners
    points[1::2] = 0.5 * (corners[1:] + corners[:-1])
    points[[0, -1]] = 0.0, 1.0
    return points


@dataclass(frozen=True)
class Sizes:
    """Of elements.

    Attributes
    ----------
    size : float
        Along the walls, about, m.
    corner : float or None
        At the edges where walls meet at re-entrant angles, m, if smaller.
    thick : int
        Elements through the aerofoils' thickness, at least.
    """

    size: float
    corner: float | None = None
    thick: int = 1

    def along(self, length: float, start: bool = True, end: bool = True) -> Floats:
        """`shares` of a side with re-entrant corners at its start, its end, or both."""
        return shares(length, self.size, self.corner, (start, end))

    def across(self, thickness: float) -> Floats:
        """`shares` from one side of an aerofoil to the other."""
        return shares(thickness, min(self.size, thickness / self.thick), self.corner)


def between(low: Curve, high: Curve, first: Curve, last: Curve, u: Floats, v: Floats) -> Floats:
    """Lattice (a, b, 2) that blends four curves (S. A. Coons, 1967).

    Parameters
    ----------
    low, high : Curve
        Along the first direction, at the start and the end of the second.
    first, last : Curve
        Along the second direction, at the start and the end of the first.
    u, v : (a,) and (b,) float
        `shares` of both directions.
    """
    below, above, left, right = low(u), high(u), first(v), last(v)
    U, V = u[:, None, None], v[None, :, None]
    ruled = (1 - V) * below[:, None] + V * above[:, None]
    across = (1 - U) * left[None] + U * right[None]
    corners = (1 - U) * ((1 - V) * left[0] + V * left[-1])
    corners = corners + U * ((1 - V) * right[0] + V * right[-1])
    return np.asarray(ruled + across - corners)


def swept(low: Floats, high: Floats, t: Floats) -> Floats:
    """Block (a, b, c, 3) of straight lines between like points of two sheets, at shares t (c,)."""
    return np.asarray((1 - t[:, None]) * low[..., None, :] + t[:, None] * high[..., None, :])


def glued(name: str, blocks: Sequence[Floats], cell_type: str, sectors: int) -> Part:
    """One part of the elements of all blocks (a, b, c, 3), like points made one.

    Blocks may be right- or left-handed.

    Parameters
    ----------
    name : str
    blocks : sequence of (a, b, c, 3) float
    cell_type : {"hexahedron", "hexahedron20", "hexahedron27"}
    sectors : int
    """
    points, cells, start = [], [], 0
    for block in blocks:
        numbers = start + np.arange(block[..., 0].size).reshape(block.shape[:3])
        start += numbers.size
        points.append(block.reshape(-1, 3))
        cells.append(_elements(numbers if _handed(block) > 0 else numbers[::-1]))
    every, of = _merged(np.concatenate(points))
    used = of[np.concatenate(cells)[:, : NODES[cell_type]]]
    kept, cells_ = np.unique(used, return_inverse=True)
    return Part(name, every[kept], cells_.reshape(used.shape), cell_type, {}, {}, sectors)


def determinants(part: Part) -> tuple[Floats, Floats]:
    """Jacobian at the quadrature points and at the nodes of every element, over its mean: (e, q).

    1 everywhere in a parallelepiped, and positive where the element is the right way round.
    """
    points, weights = np.polynomial.legendre.leggauss(3)
    grid = np.stack(np.meshgrid(points, points, points, indexing="ij"), axis=-1).reshape(-1, 3)
    weight = np.multiply.outer(np.multiply.outer(weights, weights), weights).ravel() / 8
    at_points = _determinant(part, 0.5 * (grid + 1))
    mean = (at_points @ weight)[:, None]
    places = 0.5 * _PLACES[: NODES[part.cell_type]].astype(float)
    return at_points / mean, _determinant(part, places) / mean


def _determinant(part: Part, places: Floats) -> Floats:
    _, slopes = solid(part.cell_type).functions(places)
    return np.asarray(
        np.linalg.det(np.einsum("eka,qkb->eqab", part.points[part.cells], slopes, optimize=True))
    )


def _handed(block: Floats) -> float:
    """Sign of the block's volume."""
    a, b, c = (block.take(-1, axis) - block.take(0, axis) for axis in range(3))
    means = [side.mean(axis=(0, 1)) for side in (a, b, c)]
    return float(np.linalg.det(np.array(means)))


def _elements(numbers: Integers) -> Integers:
    """(e, 27) nodes of the elements of a lattice of numbers."""
    ends = [size - 2 for size in numbers.shape]
    columns = [
        numbers[i : ends[0] + i : 2, j : ends[1] + j : 2, k : ends[2] + k : 2].ravel()
        for i, j, k in _PLACES
    ]
    return np.stack(columns, axis=1)


def _merged(points: Floats) -> tuple[Floats, Integers]:
    """Distinct points, and which of them each point is."""
    pairs = cKDTree(points).query_pairs(TOLERANCE, output_type="ndarray")
    first = np.arange(len(points))
    np.minimum.at(first, pairs[:, 1], pairs[:, 0])  # pairs are ascending
    kept, of = np.unique(first, return_inverse=True)
    if not np.array_equal(first[kept], kept):
        raise ValueError("points lie too close together to tell which are the same")
    return points[kept], of
