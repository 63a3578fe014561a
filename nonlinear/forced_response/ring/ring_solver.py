"""Ways to a point of a ring of unlike sectors."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.continuation.families import Frequencies, fixed
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver, counted
from vanelock.nonlinear.newton.newton import Solution, solve

Floats = NDArray[np.float64]

SMALLEST = 1 / 64
"""Of the deviations: the smallest step from the alike ring to the unlike one."""


@dataclass(frozen=True, kw_only=True)
class RingSolver(PointSolver):
    """What solves one point of a ring after another.

    Attributes
    ----------
    parts : callable
        Problems by circular frequency whose deviations are a part, 0 to 1, of those given.
    alike : sequence of Solution
        Converged ones of one sector of the alike ring, by which a point may begin.
    """

    parts: Callable[[float], Frequencies]
    alike: Sequence[Solution] = field(default_factory=list)

    def sweep(self, omegas: Floats) -> Iterator[Solution]:
        """Solve at each frequency; what the next ones start from goes when they are done."""
        return (replace(each, kept=None) for each in super().sweep(omegas))

    def explore(self, begin: float, end: float, loose: float = 1.0) -> Iterator[Solution]:
        """Solve from `begin` to `end`; what the next points start from goes when they are done."""
        return (replace(each, kept=None) for each in super().explore(begin, end, loose))

    def _point(self, omega: float, history: list[Solution]) -> Solution:
        tried = self._newton(omega, history) if history else []
        if tried and tried[-1].converged:
            return counted(tried, omega)
        if tried:
            self.searching(omega)
        tried += self._from_alike(omega)
        if tried and tried[-1].converged:
            return replace(counted(tried, omega), continued=not history)
        last = super()._point(omega, history)
        return counted([*tried, last], omega)

    def _from_alike(self, omega: float) -> Iterator[Solution]:
        """From the alike ring, at once or by parts of the deviations."""
        if not self.alike:
            return
        nearest = min(self.alike, key=lambda each: abs(each.omega - omega))
        ahead = self.family.at(omega).linear
        sectors = self.family.structure.system.sectors
        w = np.zeros((sectors, len(ahead) // sectors, *ahead.shape[1:]))
        w[:, : len(nearest.w)] = nearest.w  # modes have rows behind the contacts
        w = w.reshape(ahead.shape)
        found = self._solved(omega, 1.0, w)
        yield found
        if found.converged:
            return
        begun = self._solved(omega, 0.0, w)
        part, step, last = 0.0, 0.25, begun
        while begun.converged and part < 1.0 and step >= SMALLEST:
            following = self._solved(omega, min(part + step, 1.0), last.w, last)
            if not following.converged:
                step *= 0.5
                continue
            part, last = min(part + step, 1.0), following
            step *= 2.0 if following.iterations < 5 else 1.0
        if part == 1.0:
            yield last

    def _solved(
        self, omega: float, part: float, start: Floats, last: Solution | None = None
    ) -> Solution:
        family = self.parts(part)
        kept = None if last is None else last.kept
        problem = fixed(family.at(omega), family.friction)
        found = solve(problem, start, 0.0, tolerance=self.tolerance, kept=kept)
        return replace(found, parameter=omega)
