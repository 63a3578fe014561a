"""Outlines of revolved sections: polygons in the plane of radius and z, with fillets."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Place = NDArray[np.float64]  # (2,): radius and axial position, m

PIECE = np.pi / 4
"""The largest angle of a piece of an arc: every quarter of a circle has two elements or more."""


class Corner(NamedTuple):
    """A corner of an outline, rounded by an arc that is tangent to both sides.

    Attributes
    ----------
    radius, z : float
        Where the sides meet, m.
    fillet : float
        Radius of the arc, m; 0 leaves the corner sharp.
    """

    radius: float
    z: float
    fillet: float = 0.0


class Edge(NamedTuple):
    """A straight edge, or an arc about a centre.

    Attributes
    ----------
    start, end : (2,) float
        Radius and axial position, m.
    centre : (2,) float or None
        Of an arc.
    """

    start: Place
    end: Place
    centre: Place | None = None


def edges(corners: Sequence[Corner]) -> list[Edge]:
    """Edges around an outline, each starting where the one before it ends."""
    rounded = [
        _arc(before, corner, after)
        for before, corner, after in zip(
            [corners[-1], *corners[:-1]], corners, [*corners[1:], corners[0]], strict=True
        )
    ]
    found = []
    for arc, following in zip(rounded, [*rounded[1:], rounded[0]], strict=True):
        found += arc
        found.append(Edge(arc[-1].end, following[0].start))
    # The sharp corner's edge has no length.
    return [edge for edge in found if edge.start is not edge.end]


def _arc(before: Corner, corner: Corner, after: Corner) -> list[Edge]:
    """The pieces of a corner's arc, or for a sharp corner one edge without length."""
    here = np.array(corner[:2], dtype=float)
    if corner.fillet == 0:
        return [Edge(here, here)]
    to = np.array([before[:2], after[:2]]) - here
    to /= np.linalg.norm(to, axis=1)[:, None]
    half = np.arccos(np.clip(to[0] @ to[1], -1, 1)) / 2  # of the angle between the sides
    inwards = to.sum(axis=0) / np.linalg.norm(to.sum(axis=0))
    centre = here + corner.fillet / np.sin(half) * inwards
    first, last = here + corner.fillet / np.tan(half) * to
    turn = np.pi - 2 * half
    pieces = max(1, int(np.ceil(turn / PIECE - 1e-9)))
    from_middle = turn * (np.arange(1, pieces) / pieces - 0.5)
    along = (last - first) / np.linalg.norm(last - first)
    between = [
        centre + corner.fillet * (np.sin(a) * along - np.cos(a) * inwards) for a in from_middle
    ]
    places = [first, *between, last]
    return [Edge(*ends, centre) for ends in pairwise(places)]
