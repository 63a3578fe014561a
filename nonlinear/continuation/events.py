"""Where a quantity changes its sign along a path of solutions: folds, and peaks beside folds."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.continuation.path import PathPoint, Tangent, tangent_at
from vanelock.nonlinear.newton.newton import TOLERANCE, CuttingPlane, Family, Solution, solve

Floats = NDArray[np.float64]

Measure = Callable[[Solution, Tangent], float]

JUMP = 1e-3
"""Distance between the last points on either side, relative to that of the ends, that is a jump."""


@dataclass(frozen=True)
class Located:
    """A point of a path at which a quantity vanishes, or jumps over zero while the path goes on.

    Attributes
    ----------
    solution : Solution
        The last one that was solved.
    tangent : Tangent
    left : float
        What is left of the quantity, relative to its larger value at the ends of the piece.
    spent : int
        Points that were solved.
    """

    solution: Solution
    tangent: Tangent
    left: float
    spent: int


def locate(
    family: Family,
    before: PathPoint,
    after: PathPoint,
    measure: Measure,
    values: tuple[float, float],
    tolerance: float = TOLERANCE,
) -> Located | None:
    """Find where a quantity passes zero between two neighbouring points of a path."""
    a, b = before.solution, after.solution
    solved: list[tuple[float, Solution, Tangent]] = []
    normal = (
        before.plane.normal_w + after.plane.normal_w,
        before.plane.normal_parameter + after.plane.normal_parameter,
    )

    def at(share: float) -> float:
        w = a.w + share * (b.w - a.w)
        parameter = a.parameter + share * (b.parameter - a.parameter)
        found = solve(
            family, w, parameter, CuttingPlane(w, parameter, *normal), tolerance, kept=a.kept
        )
        tangent = tangent_at(family, found) if found.converged else None
        if tangent is None:
            raise ArithmeticError
        value = measure(found, tangent)
        solved.append((value, found, tangent))
        return value

    try:
        _bracketed(at, values)
    except ArithmeticError:
        return None
    value, found, tangent = solved[-1]  # where it jumps, smaller values may lie far away
    spent = sum(each[1].iterations for each in solved)
    left = abs(value) / max(map(abs, values))
    others = [(values[0], a), (values[1], b), *((each[0], each[1]) for each in solved)]
    other = [each for size, each in others if (size > 0) != (value > 0)][-1]
    gap, span = np.linalg.norm(found.w - other.w), np.linalg.norm(b.w - a.w)
    if left > JUMP and gap > JUMP * span:
        return None
    return Located(replace(found, iterations=spent), tangent, left, len(solved))


def _bracketed(at: Callable[[float], float], values: tuple[float, float]) -> None:
    """Close in on the root of a function between 0 and 1, given its values there.

    The secant through the ends, the end that stays twice counting half (the Illinois rule); a
    bisection where that is slow.
    """
    low, high = 0.0, 1.0
    f_low, f_high = values
    size, kept = max(map(abs, values)), 0
    for i in range(80):
        share = (low * f_high - high * f_low) / (f_high - f_low)
        if i % 4 == 3 or not low < share < high:
            share = 0.5 * (low + high)
        f = at(share)
        if abs(f) < 1e-13 * size or high - low < 1e-13:
            return
        if (f > 0) == (f_high > 0):
            high, f_high = share, f
            f_low *= 0.5 if kept == 1 else 1.0
            kept = 1
        else:
            low, f_low = share, f
            f_high *= 0.5 if kept == -1 else 1.0
            kept = -1
