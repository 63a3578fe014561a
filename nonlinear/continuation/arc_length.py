"""Follow a path of solutions, through folds, to a given value of its parameter."""

from dataclasses import dataclass, replace

import numpy as np

from vanelock.nonlinear.continuation.path import SHORTEST, PathPoint, SolutionPath
from vanelock.nonlinear.newton.newton import (
    CARRIED,
    TOLERANCE,
    Family,
    Solution,
    at_solution,
    refined,
    solve,
)

APART = 1e-6
"""Of w, what a way may be longer however short the straight one is."""


@dataclass(frozen=True)
class Arc:
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
) -> Arc:
    """Follow the path of solutions from a converged point until the parameter passes `target`."""
    if target == start.parameter:
        return Arc(start, (), 0)
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
                return Arc(replace(landed, iterations=spent), tuple(folds), spent)
            if path.taken < 4 * shortest:
                break
            path.shorten(0.25)  # come closer before landing
            continue
        path.go(ahead)
        flown = np.abs(ahead.w * path.weight).max(initial=0.0) > CARRIED  # nothing holds it
        if flown or (start.parameter - ahead.parameter) / path.span > away:
            break
    return Arc(None, tuple(folds), path.iterations + landing)


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
        found = solve(family, begin, target, tolerance=tolerance, kept=a.kept)
        spent += found.iterations
        way = np.linalg.norm(found.w - a.w) + np.linalg.norm(found.w - b.w)
        if found.converged and (bend is None or way <= bend * chord):
            return replace(found, iterations=spent)
    return replace(found, iterations=spent, converged=False)


def polished(family: Family, point: PathPoint, tolerance: float) -> Solution:
    """A point of a path, to the tolerance and better; not converged where that is not reached."""
    rough = point.solution
    there = at_solution(family, rough)
    found = refined(there, rough.w, rough.parameter, point.plane, tolerance, rough.kept)
    if found.converged:
        return found
    return replace(rough, converged=rough.residual <= tolerance)
