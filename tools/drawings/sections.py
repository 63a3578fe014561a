"""Outlines of the parts as a drawing needs them, in mm."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry import aerofoil, root_fillet
from vanelock.mesh.geometry.revolved import Corner, edges

Real = NDArray[np.float64]


def revolved(corners: Sequence[Corner]) -> Real:
    """An outline (n, 2) of z and radius, mm, its fillets as arcs."""
    points = []
    for edge in edges(corners):
        points.append(edge.start)
        if edge.centre is not None:
            ends = np.array([edge.start, edge.end]) - edge.centre
            share = np.linspace(0, 1, 7)[1:-1, None]
            between = (1 - share) * ends[0] + share * ends[1]
            length = np.linalg.norm(between, axis=1)[:, None]
            points += list(edge.centre + np.linalg.norm(ends[0]) * between / length)
    return flat(points)


def flat(places: ArrayLike) -> Real:
    """From (radius, z), m, to (z, radius), mm."""
    return np.asarray(1e3 * np.asarray(places, float)[:, ::-1])


def section(vane: VaneDimensions, along: float | None = None) -> Real:
    """Around an aerofoil's section: circumferential and axial position (n, 2), m.

    `along`, m, as in `aerofoil.outline`.
    """
    sides = aerofoil.outline(vane, np.linspace(-1, 1, 41), along)
    leading, trailing = aerofoil.edges(vane, along).control
    rear = _rounded(sides[0, -1], trailing, sides[1, -1])
    front = _rounded(sides[1, 0], leading, sides[0, 0])
    return np.concatenate([sides[0], rear, sides[1, ::-1], front])


def _rounded(start: Real, control: Real, end: Real) -> Real:
    """Points on a parabola between its ends."""
    t = np.linspace(0, 1, 17)[1:-1, None]
    return np.asarray((1 - t) ** 2 * start + 2 * t * (1 - t) * control + t**2 * end)


def root_fillets(vane: VaneDimensions, strip: int, place: int) -> list[Real]:
    """The fillets' corners at both shrouds, filled: (n, 3) m in the aerofoil's axes.

    Strip and place as in `root_fillet.strips`; nothing without fillets.
    """
    if not vane.root_fillet:
        return []
    ends = (root_fillet.strips(vane, outer)[strip] for outer in (False, True))
    return [np.vstack([end.arc(place, np.linspace(0, 1, 9)), end.corner[place]]) for end in ends]


def box(left: float, right: float, low: float, high: float) -> list[tuple[float, float]]:
    """Corners of a rectangle."""
    return [(left, low), (right, low), (right, high), (left, high)]


def polar(radius: float, angle: float) -> tuple[float, float]:
    """A place seen from the front, mm, the angle 0 upwards."""
    return 1e3 * radius * float(np.sin(angle)), 1e3 * radius * float(np.cos(angle))


def ring_piece(inner: float, outer: float, half: float) -> Real:
    """Between two radii, m, and two angles -half and half, seen from the front."""
    angles = np.linspace(-half, half, 61)
    there = [polar(outer, angle) for angle in angles]
    return np.array([*there, *(polar(inner, angle) for angle in angles[::-1])])
