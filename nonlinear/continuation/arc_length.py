"""Where a path of solutions leads: to a value of its parameter, and where a quantity vanishes.

Folds are passed on the way; they are found by such a quantity, as are peaks beside folds.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vanelock.nonlinear.continuation.path import (
    SHORTEST,
    PathPoint,
    SolutionPath,
    Tangent,
    tangent_at,
)
from vanelock.nonlinear.newton.newton import (
    CARRIED,
    TOLERANCE,
    CuttingPlane,
    Family,
    Solution,
    at_solution,
    refined,
    solve,
)

APART = 1e-6
"""Of w, what a way may be longer however short the straight one is."""


@dataclass(frozen=True)
class _Arc:
    """Where a path led: the state at the target, None if not there; parameters where it turned."""

    solution: Solution | None
    folds: tuple[float, ...]
    iterations: int


def follow(
    family: Family,
    start: Solution,
    target: float,
    tolerance: float = TOLERANCE,
    limit: int = 200,
    effort: int = 2000,
    shortest: float = SHORTEST,
    away: float = np.inf,
) -> _Arc:
    """Follow the path of solutions from a converged point until the parameter passes `target`."""
    if target == start.parameter:
        return _Arc(start, (), 0)
    path, folds, landing = SolutionPath(family, start, target, shortest=shortest), list[float](), 0
    forwards = float(np.sign(path.span))
    for _ in range(limit):
        here = path.here
        if here is None:
            break
        if here.rate * forwards < 0:
            folds.append(here.solution.parameter)
            forwards = -forwards
        ahead = path.ahead()
        if ahead is None or path.iterations + landing > effort:
            break
        if (ahead.parameter - target) / path.span >= 0:
            landed = land(family, here.solution, ahead, target, tolerance)
            landing += landed.iterations
            if landed.converged:
                spent = path.iterations + landing
                return _Arc(replace(landed, iterations=spent), tuple(folds), spent)
            if path.taken < 4 * shortest:
                break
            path.length = 0.25 * path.taken  # come closer before landing
            continue
        path.go(ahead)
        flown = np.abs(ahead.w * path.weight).max(initial=0.0) > CARRIED  # nothing holds it
        if flown or (start.parameter - ahead.parameter) / path.span > away:
            break
    return _Arc(None, tuple(folds), path.iterations + landing)


def land(
    family: Family,
    a: Solution,
    b: Solution,
    target: float,
    tolerance: float = TOLERANCE,
    bend: float | None = None,
) -> Solution:
    """The point of a path at a value of the parameter, between two of its points.

    Not converged where none is found, or one by way of which it is that much further than straight.
    """
    share, spent = (target - a.parameter) / (b.parameter - a.parameter), 0
    chord = np.linalg.norm(b.w - a.w) + APART * np.linalg.norm(b.w)
    for begin in (a.w + share * (b.w - a.w), b.w, a.w):
        found = solve(family, begin, target, tolerance=tolerance, reuse=a.reuse)
        spent += found.iterations
        way = np.linalg.norm(found.w - a.w) + np.linalg.norm(found.w - b.w)
        if found.converged and (bend is None or way <= bend * chord):
            return replace(found, iterations=spent)
    return replace(found, iterations=spent, converged=False)


def polished(family: Family, point: PathPoint, tolerance: float) -> Solution:
    """A point of a path, to the tolerance and better; not converged where that is not reached."""
    rough = point.solution
    there = at_solution(family, rough)
    found = refined(there, rough.w, rough.parameter, point.plane(), tolerance, rough.reuse)
    if found.converged:
        return found
    return replace(rough, converged=rough.residual <= tolerance)


_Measure = Callable[[Solution, Tangent], float]

_JUMP = 1e-3
"""Distance between the last points on either side, relative to that of the ends, that is a jump."""


@dataclass(frozen=True)
class _Located:
    """A point of a path at which a quantity vanishes, or jumps over zero while the path goes on.

    `solution`: the last one that was solved; `left`: what is left of the quantity, relative to its
    larger value at the ends of the piece; `spent`: points that were solved.
    """

    solution: Solution
    tangent: Tangent
    left: float
    spent: int


def locate(
    family: Family,
    before: PathPoint,
    after: PathPoint,
    measure: _Measure,
    values: tuple[float, float],
    tolerance: float = TOLERANCE,
) -> _Located | None:
    """Find where a quantity passes zero between two neighbouring points of a path."""
    a, b = before.solution, after.solution
    solved: list[tuple[float, Solution, Tangent]] = []
    planes = before.plane(), after.plane()
    normal_w = planes[0].normal_w + planes[1].normal_w
    normal_parameter = planes[0].normal_parameter + planes[1].normal_parameter

    def at(share: float) -> float:
        w = a.w + share * (b.w - a.w)
        parameter = a.parameter + share * (b.parameter - a.parameter)
        plane = CuttingPlane(w, parameter, normal_w, normal_parameter)
        found = solve(family, w, parameter, plane, tolerance, reuse=a.reuse)
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
    if left > _JUMP and gap > _JUMP * span:
        return None
    return _Located(replace(found, iterations=spent), tangent, left, len(solved))


def _bracketed(function: Callable[[float], float], values: tuple[float, float]) -> None:
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
        f = function(share)
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
