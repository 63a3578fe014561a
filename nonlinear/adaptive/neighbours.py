"""Points of a curve beside their neighbours: bends, jumps, and maxima with their errors."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.adaptive.interpolant import SIMILAR
from vanelock.nonlinear.adaptive.points import TINY, Point, Pointwise

OTHER = 0.04
"""Relative distance of an amplitude from the line through a neighbour that suggests a jump."""


def bend(history: Sequence[Point], point: Point) -> float:
    """Relative distance of a new amplitude from the line through the last two."""
    if len(history) < 2:
        return 0.0
    a, b = history
    line = b.amplitude + (b.amplitude - a.amplitude) * (point.omega - b.omega) / (b.omega - a.omega)
    return abs(point.amplitude - line) / max(b.amplitude, TINY)


def may_jump(a: Point, b: Point) -> bool:
    """Whether two neighbours may lie on different branches, by their tangents."""
    if not (np.isfinite(a.slope) and np.isfinite(b.slope)):
        return True
    distance = b.omega - a.omega
    mean = 0.5 * (a.slope + b.slope) * distance
    return abs(b.amplitude - a.amplitude - mean) > OTHER * max(a.amplitude, b.amplitude)


def places_of_jumps(pointwise: Pointwise, points: Sequence[Point]) -> NDArray[np.int64]:
    """(j, 2) places of neighbours that no curve joins, among points of ascending frequency."""
    solved = [i for i, p in enumerate(points) if p.solution.converged]
    found = [
        (i, j)
        for i, j in pairwise(solved)
        if may_jump(points[i], points[j]) and not pointwise.joined(points[i], points[j])
    ]
    return np.array(found, np.int64).reshape(-1, 2)


def with_measured_maxima(pointwise: Pointwise, points: Sequence[Point]) -> list[Point]:
    """Points with the errors of the highest maxima measured rather than estimated."""
    found = list(points)
    sizes = np.array([-np.inf, *(point.amplitude for point in points), -np.inf])
    inner = sizes[1:-1]
    maxima = (inner >= sizes[:-2]) & (inner >= sizes[2:]) & (inner >= SIMILAR * inner.max())
    for i in np.flatnonzero(maxima):
        found[i] = pointwise.with_measured_error(found[i])
    return found
