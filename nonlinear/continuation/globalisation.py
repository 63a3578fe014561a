"""Ways to a solution where no neighbouring one is known."""

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import Loads, fixed
from vanelock.nonlinear.continuation.hardening import Hardening
from vanelock.nonlinear.continuation.release import release
from vanelock.nonlinear.fourier.trigonometric import resized
from vanelock.nonlinear.newton.newton import TOLERANCE, Family, Solution, solve

Floats = NDArray[np.float64]

EFFORT = 3000
"""Newton steps by default that a solution may take where no neighbouring one is known."""
EFFORTS = (300, 3000)  # of them on a path: every one for a while before any for long
SOFTEST = (1e-2, 1e-4)  # shares of the contacts' stiffness to begin with
SHORTEST = 1e-6
"""Shortest step on a path, relative to all of it: where sticking ends, vibrating parts may be small
beside the mean, and a path may turn back at once."""


@dataclass
class Effort:
    """Newton steps that are left for a solution, and who hears of each attempt."""

    left: int = EFFORT
    attempted: Callable[[], None] = lambda: None

    def spent(self, found: Solution) -> Solution:
        """The solution, its steps taken off."""
        self.left -= found.iterations
        return found


def from_nothing(
    balance: Balance,
    law: Callable[[int], Law],
    tolerance: float = TOLERANCE,
    effort: Effort | None = None,
) -> Solution:
    """Solve a balance without a start, by what works, the cheapest first."""
    spent = 0
    best: Solution | None = None
    for attempt in _attempts(balance, law, tolerance, effort or Effort()):
        spent += attempt.iterations
        if best is None or attempt.converged or not best.residual <= attempt.residual:
            best = attempt
        if attempt.converged:
            break
    assert best is not None
    return replace(best, iterations=spent, parameter=balance.omega)


def at_once(balance: Balance, law: Callable[[int], Law], tolerance: float = TOLERANCE) -> Solution:
    """Solve a balance without a start by Newton's iteration, or by raising H, but no more."""
    still = np.zeros_like(balance.linear)
    top = law((balance.linear.shape[2] - 1) // 2)
    found = solve(fixed(balance, top), still, 0.0, tolerance=tolerance)
    if not found.converged:
        found = next(_raise_harmonics(balance, law, tolerance, Effort()))
    return found


def _attempts(
    balance: Balance, law: Callable[[int], Law], tolerance: float, effort: Effort
) -> Iterator[Solution]:
    harmonics = (balance.linear.shape[2] - 1) // 2
    top = law(harmonics)
    still = np.zeros_like(balance.linear)
    yield effort.spent(solve(fixed(balance, top), still, 0.0, tolerance=tolerance))
    raised = yield from _raise_harmonics(balance, law, tolerance, effort)
    ways = [_harden(balance, top), _raise_force(balance, top, raised), _release(balance, top)]
    for most in EFFORTS:
        for starts in ways:
            if effort.left <= 0:
                return
            effort.attempted()
            for way in starts:
                begun = effort.spent(
                    solve(way.family, way.start, way.begin, tolerance=tolerance, limit=way.limit)
                )
                if begun.converged:
                    yield from _followed(way, begun, tolerance, effort, most)
                    break


def _raise_harmonics(
    balance: Balance, law: Callable[[int], Law], tolerance: float, effort: Effort
) -> Generator[Solution, None, Floats | None]:
    """Solve with 0, 1, ... H harmonics, each from the last; returns the static deviation."""
    harmonics = (balance.linear.shape[2] - 1) // 2
    w: Floats = np.zeros((*balance.linear.shape[:2], 1))
    static: Floats | None = None
    for h in range(harmonics + 1):
        cut = balance.with_harmonics(h)
        begin = resized(w, h)
        found = effort.spent(solve(fixed(cut, law(h)), begin, 0.0, tolerance=tolerance, limit=25))
        if h == harmonics:
            yield found
        if found.converged or h > 0:
            w = found.w
        if h == 0 and found.converged:
            static = found.w
    return static


@dataclass(frozen=True)
class _Way:
    """A family that leads to the problem at `target`, and where it begins, with a guess of w there.

    `limit` is of Newton steps at the beginning, `shortest` of steps on the way.
    """

    family: Family
    start: Floats
    begin: float
    target: float
    limit: int = 15
    shortest: float = SHORTEST


def _harden(balance: Balance, law: Law) -> list[_Way]:
    """From soft contacts to the true ones, those tried first that are the least soft."""
    start = np.zeros_like(balance.linear)
    families = (Hardening(balance, law, softest) for softest in SOFTEST)
    return [_Way(family, start, 0.0, 1.0, limit=40, shortest=1e-5) for family in families]


def _raise_force(balance: Balance, law: Law, static: Floats | None) -> list[_Way]:
    """From the static state, raise all that vibrates from nothing to its full amplitude."""
    if static is None or balance.linear.shape[2] == 1:
        return []
    direction = balance.linear.copy()
    direction[:, :, 0] = 0.0
    still = replace(balance, linear=balance.linear - direction)
    start = np.zeros_like(balance.linear)
    start[:, :, 0] = static[:, :, 0]
    return [_Way(Loads(still, direction, law), start, 0.0, 1.0)]


def _release(balance: Balance, law: Law) -> list[_Way]:
    """From contacts held down and held back by force to the true ones."""
    return [_Way(release(balance, law), np.zeros_like(balance.linear), 1.0, 0.0)]


def _followed(
    way: _Way, begun: Solution, tolerance: float, effort: Effort, most: int
) -> Iterator[Solution]:
    arc = follow(
        way.family,
        begun,
        way.target,
        tolerance,
        limit=600,
        effort=min(most, effort.left),
        shortest=way.shortest,
    )
    effort.left -= arc.iterations
    if arc.solution is not None:
        yield arc.solution
