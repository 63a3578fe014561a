"""Jumps: neighbours of a sweep that no curve of solutions joins.

Where a branch of solutions ends in a fold, a sweep goes on with another branch. Two neighbours are
suspected where the solver did not get from the one to the other without turning back, or where
neither lies on the line through the two points on the other's side. They jump unless the path of
solutions that begins at one of them leads to the other and nowhere turns back.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver
from vanelock.nonlinear.newton.newton import Solution, scales

STRAIGHT = 0.1
"""Of the larger motion, how far a point may lie from a line, or two points apart."""
SAME = 1e-4
"""Of the larger motion, the difference of two states beyond which they are two."""
POINTS, EFFORT = 60, 300
"""Points of the path between two neighbours, and Newton steps, at most."""


def jumps(solver: PointSolver, swept: Sequence[Solution]) -> NDArray[np.int64]:
    """(j, 2) places of the points before and after each jump."""
    solved = [i for i, each in enumerate(swept) if each.converged]
    found = []
    for k in range(len(solved) - 1):
        around = [swept[i] for i in solved[max(k - 1, 0) : k + 3]]
        a, b = swept[solved[k]], swept[solved[k + 1]]
        before = around[0] if k > 0 else None
        after = around[-1] if k + 2 < len(solved) else None
        lost = solved[k + 1] > solved[k] + 1
        smooth = b.continued and not lost and _straight(before, a, b, after)
        if not smooth and not joined(solver, a, b):
            found.append((solved[k], solved[k + 1]))
    return np.array(found, np.int64).reshape(-1, 2)


def joined(solver: PointSolver, a: Solution, b: Solution) -> bool:
    """Whether the path of solutions leads from one to the other and nowhere turns back."""
    weight = 1 / scales(solver.family.at(a.omega).linear)
    for start, end in ((a, b), (b, a)):
        arc = follow(
            solver.family, start, end.omega, solver.tolerance, POINTS, effort=EFFORT, away=0.0
        )
        if arc.solution is None or arc.folds:
            continue
        apart = np.abs((arc.solution.u - end.u) * weight).max(initial=0.0)
        return bool(apart <= SAME * _size(weight, arc.solution, end))
    return False


def _straight(before: Solution | None, a: Solution, b: Solution, after: Solution | None) -> bool:
    """Whether two neighbours are close, or one lies on the line through the other's side."""
    one = np.ones(1)
    allowed = STRAIGHT * _size(one, a, b)
    if np.abs(b.u - a.u)[..., 1:].max(initial=0.0) <= allowed:
        return True
    for first, second, third in ((before, a, b), (after, b, a)):
        if first is None or first.omega == second.omega:
            continue
        share = (third.omega - second.omega) / (second.omega - first.omega)
        line = second.u + share * (second.u - first.u)
        if np.abs(third.u - line)[..., 1:].max(initial=0.0) <= allowed:
            return True
    return False


def _size(weight: NDArray[np.float64], *states: Solution) -> float:
    """The largest vibration of a contact in some states."""
    return max(float(np.abs(each.u * weight)[..., 1:].max(initial=0.0)) for each in states)
