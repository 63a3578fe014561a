"""A mode followed from small to large amplitudes.

Each point is held along the shape of the one before, at an amplitude some percent larger, from
where the secant through the last two points leads. A step that fails, or whose motion is another's,
is halved.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from vanelock.nonlinear.balance.held_vibration import Array, Floats
from vanelock.nonlinear.following.modes.mode_point import ModePoint, ModeSolver, exact

LONGEST = 0.2
"""Longest step, of the logarithm of the amplitude."""
SHORTEST = 1e-5
SURE = 0.95
"""Of the amplitude, what lies along the shape of the point before at least."""
BEND = 0.02
"""Change of frequency, relatively, and of damping ratio, of the largest so far, beside the secant's
at which steps become shorter."""


@dataclass
class ModePath:
    """Points of a mode, one after another.

    Attributes
    ----------
    solver : ModeSolver
    points : list of ModePoint
        The last two that were found.
    step : float
        Of the logarithm of the amplitude, next.
    spent : int
        Attempts that failed.
    """

    solver: ModeSolver
    points: list[ModePoint]
    step: float = LONGEST
    spent: int = 0

    @property
    def last(self) -> ModePoint:
        """Where the path is."""
        return self.points[-1]

    def onward(self, end: float) -> Iterator[ModePoint]:
        """Points up to an amplitude, kg^½ m, which the last one has exactly; fewer if it is lost."""
        while self.last.amplitude < end * (1 - 1e-12):
            left = float(np.log(end / self.last.amplitude))
            lands = self.step >= 0.999 * left
            step = left if lands else min(self.step, 0.6 * left if self.step > 0.6 * left else left)
            found = self._at(self.last.amplitude * float(np.exp(step)))
            if found is not None and lands:
                found = exact(self.solver, found, end)
            if found is None:
                self.spent += 1
                self.step = step / 2
                if self.step < SHORTEST:
                    return
                continue
            surprise = self._surprise(found)
            if surprise > 4 and step > 0.01 * LONGEST:
                self.spent += 1
                self.step = step / 2
                continue
            self.points = [self.last, found]
            growth = float(np.clip(0.9 / np.sqrt(max(surprise, 1e-12)), 0.5, 2.0))
            self.step = min(max(self.step if lands else step, step) * growth, LONGEST)
            yield found

    def _guess(self, amplitude: float) -> tuple[float, float, Floats, Array]:
        """ω, ξ, w expected at an amplitude, and the shape to hold."""
        last = self.last
        if len(self.points) < 2:
            return last.omega, last.xi, last.solution.w, last.shape
        before = self.points[-2]
        ratio = np.log(amplitude / last.amplitude) / np.log(last.amplitude / before.amplitude)
        omega = last.omega + ratio * (last.omega - before.omega)
        xi = last.xi + ratio * (last.xi - before.xi)
        share = (amplitude - last.amplitude) / (last.amplitude - before.amplitude)
        w = last.solution.w + share * (last.solution.w - self._turned(before))
        return float(omega), float(xi), w, last.shape

    def _turned(self, before: ModePoint) -> Floats:
        """W of the point before; it was held in the phase of its own predecessor, as the last is in
        its: their phases differ by second order only."""
        return before.solution.w

    def _at(self, amplitude: float) -> ModePoint | None:
        last = self.last
        omega, xi, w, shape = self._guess(amplitude)
        starts = [(omega, xi, w), (last.omega, last.xi, last.solution.w)]
        for omega, xi, w in starts[: len(self.points)]:
            held = self.solver.held(shape, amplitude, omega, xi)
            found = self.solver.point(held, w, last.solution.kept)
            if found is not None and found.amplitude * SURE < amplitude:
                return found
        return None

    def _surprise(self, found: ModePoint) -> float:
        """How far a point lies from where the secant led, in units of `BEND`."""
        omega, xi, *_ = self._guess(found.amplitude)
        ratios = [abs(each.xi / each.omega) for each in (*self.points, found)]
        aside = abs(found.xi / found.omega - xi / omega) / max(ratios)
        return float(max(abs(found.omega / omega - 1), 0.2 * aside) / BEND)


def begun(solver: ModeSolver, point: ModePoint) -> ModePath:
    """A path from its first point."""
    return ModePath(solver, [replace(point)])
