"""Points of a response, each with as many harmonics as its own error asks for."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vanelock.common.arguments import OfKind
from vanelock.common.arrays import Floats
from vanelock.nonlinear.adaptive.error_estimates import BEYOND, SOURCES, Estimate, Estimator, half
from vanelock.nonlinear.adaptive.harmonic_levels import HarmonicLevels
from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.continuation.families import Frequencies, fixed
from vanelock.nonlinear.forced_response.frequency_response import joined
from vanelock.nonlinear.forced_response.frequency_sweep import once
from vanelock.nonlinear.fourier import resized
from vanelock.nonlinear.newton.newton import Solution, solve

_MOST = 31  # harmonics beyond which none is tried
_SLIPPING = 3
"""Fewest harmonics where a contact slides or opens: from one, a step towards more says little."""
_FEWER = 1 / 30  # of its share, the error below which a neighbour is tried with fewer harmonics
_LOW = 0.3  # of the largest amplitude, what a smaller one's error is referred to
_SHIFT = 0.03  # of the allowed relative error, what a shift in frequency may take
_FURTHER = 4  # harmonics beyond those of a maximum with which it is compared
_RESONANT = 0.015
"""Largest relative change of a peak seen by a harmonic further ahead that meets a resonance."""
_FURTHEST = 6  # harmonics beyond, if less than that is asked for: each at its own nodal diameter
_TAIL = 1.3  # what is left out by these, and beyond them, relative to the former
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Shares(OfKind):
    """Relative errors at the peak by neglected harmonics and by interpolating between points."""

    harmonics: float
    frequencies: float


@dataclass(frozen=True)
class Point:
    """A frequency solved with H harmonics; `estimate` is None where that did not converge.

    A neighbour should `begin_with` so many harmonics; the error by neglected ones is `measured`, or
    estimated only.
    """

    solution: Solution
    harmonics: int
    estimate: Estimate | None
    begin_with: int
    measured: bool = False

    @property
    def omega(self) -> float:
        """rad/s."""
        return self.solution.omega

    @property
    def amplitude(self) -> float:
        """Of the monitored output, m; 0 where the solution did not converge."""
        return 0.0 if self.estimate is None else self.estimate.amplitude

    @property
    def slope(self) -> float:
        """Its derivative to ω, m s/rad; NaN where it is not known."""
        return np.nan if self.estimate is None else self.estimate.slope


@dataclass
class Pointwise:
    """Solves one point after another, with `least` harmonics or more where it chooses them."""

    estimator: Estimator
    shares: Shares
    least: int
    chooses_harmonics: bool
    _largest: float = 0.0

    @property
    def levels(self) -> HarmonicLevels:
        """The solvers."""
        return self.estimator.levels

    def with_harmonics(self, harmonics: int) -> "Pointwise":
        """The same with so many harmonics at each point, or as many as all of them need."""
        return replace(self, least=max(harmonics, self.least), chooses_harmonics=False)

    def easily(self, omega: float, neighbours: Sequence[Point]) -> Solution | None:
        """The solution at a frequency if Newton's iteration finds it at once."""
        if not neighbours:
            return None
        H = neighbours[-1].begin_with
        return self.levels.solver(H).easily(omega, self._lifted(neighbours, H))

    def point(
        self,
        omega: float,
        neighbours: Sequence[Point],
        solution: Solution | None = None,
        least: int = 0,
    ) -> Point:
        """Solve at a frequency, rad/s, with as many harmonics as it takes, `least` or more.

        From up to two neighbours that converged, the nearest last, perhaps at the frequency itself;
        `solution` is the solution with the harmonics that the nearest one wants.
        """
        begin = time.process_time()
        H = max(neighbours[-1].begin_with if neighbours else self.least, least)
        fewer = next((point for point in neighbours if point.omega == omega), None)
        beside = [point for point in neighbours if point is not fewer]
        while True:
            if solution is None and fewer is not None:
                solution = self._raised(fewer, H)
            if solution is None:
                solution = self.levels.solver(H).point(omega, self._lifted(beside, H))
            point = Point(solution, H, None, H)
            if not solution.converged:
                break
            self.levels.keep(H, solution.reuse)
            estimate = self.estimator.estimate(solution, H)
            self._largest = max(self._largest, estimate.amplitude)
            point = replace(
                point, estimate=estimate, begin_with=self._wanted(solution, estimate, H)
            )
            if not self._needs_harmonics(solution, estimate, H):
                break
            H = min(H + BEYOND, _MOST)
            fewer, solution = point, None
        spent = time.process_time() - begin
        return replace(point, solution=replace(point.solution, seconds=spent))

    def with_measured_error(self, point: Point) -> Point:
        """A point whose error by neglected harmonics is measured: by solving with more of them.

        It gets as many harmonics as keep that error within its share. Where more of them are not
        reached from it, that is no good sign: it gets more, too.
        """
        while point.estimate is not None and not point.measured:
            measured = self._measured(point)
            if measured is not None:
                change = point.estimate.change.copy()
                change[SOURCES.index("harmonics")] = measured
                estimate = replace(point.estimate, change=change)
                point = replace(point, estimate=estimate, measured=True)
                if abs(measured) <= self.shares.harmonics * max(point.amplitude, TINY):
                    return point
            if not self.chooses_harmonics or point.harmonics >= _MOST:
                return point
            more = min(point.harmonics + BEYOND, _MOST)
            raised = self.point(point.omega, [point], None, more)
            if not raised.solution.converged:
                return point
            point = raised
        return point

    def _measured(self, point: Point) -> float | None:
        """Change of the amplitude with more harmonics, and what those beyond them may add, m.

        They may meet a resonance at their own nodal diameters, which those of the next ones always
        are, and those of all if little error is asked for.
        """
        assert point.estimate is not None
        if np.all(point.solution.deviation.state == STUCK):
            return 0.0
        sure = self.chooses_harmonics and self.shares.harmonics < _RESONANT
        H = point.harmonics + (_FURTHEST if sure else _FURTHER)
        self.levels.structure(H if sure else point.harmonics + BEYOND)
        family = self.levels.guessing(H)
        found = self._again(point, family, self.shares.harmonics * 1e-2)
        if not found.converged:
            return None
        q = self.estimator.output(family.structure, point.omega, found.w)
        return _TAIL * (half(q) - point.amplitude)

    def joined(self, a: Point, b: Point) -> bool:
        """Whether the path of solutions leads from one to the other, as many harmonics in both."""
        H = max(a.harmonics, b.harmonics)
        found = self._lifted([a, b], H)
        return len(found) == 2 and joined(self.levels.solver(H), *found)

    def _needs_harmonics(self, solution: Solution, estimate: Estimate, H: int) -> bool:
        if not self.chooses_harmonics or H >= _MOST:
            return False
        if H < _SLIPPING and np.any(solution.deviation.state != STUCK):
            return True
        return self._truncation(estimate, solution.omega) > self.shares.harmonics

    def _wanted(self, solution: Solution, estimate: Estimate, H: int) -> int:
        """The number of harmonics that a neighbour should begin with."""
        few = self._truncation(estimate, solution.omega) < _FEWER * self.shares.harmonics
        if not self.chooses_harmonics or not few:
            return H
        slips = np.any(solution.deviation.state != STUCK)
        return min(H, max(H - BEYOND, self.least, _SLIPPING if slips else 1))

    def _truncation(self, estimate: Estimate, omega: float) -> float:
        """Error by neglected harmonics, what a small shift in frequency changes forgiven."""
        steep = abs(estimate.slope) if np.isfinite(estimate.slope) else 0.0
        forgiven = 1 + _SHIFT * steep * omega / max(estimate.amplitude, TINY)
        change = float(estimate.change[SOURCES.index("harmonics")])
        if not np.isfinite(change):
            return np.inf
        # Relative to A or, where A is small, a share of the largest so far.
        return abs(change) / max(estimate.amplitude, _LOW * self._largest, TINY) / forgiven

    def _lifted(self, points: Sequence[Point], H: int) -> list[Solution]:
        """Solutions of some points with H harmonics; those that are not found are left out."""
        lifted = (self._raised(point, H) for point in points)
        return [found for found in lifted if found is not None]

    def _raised(self, point: Point, H: int) -> Solution | None:
        """The solution of a point with H harmonics; None where it is not found from that."""
        if point.harmonics == H:
            return point.solution
        found = self._again(point, self.levels.solver(H).family, self.levels.options.tolerance)
        return found if found.converged else None

    def _again(self, point: Point, family: Frequencies, tolerance: float) -> Solution:
        """A point solved in another family, from the best that is known of its harmonics."""
        found, H = point.solution, family.structure.harmonics
        starts = [found.w]
        if H > point.harmonics and point.estimate and point.estimate.better is not None:
            starts.insert(0, point.estimate.better)
        held, reuse = fixed(family.at(found.omega), family.friction), self.levels.kept(H)

        def attempt(*starts: Floats) -> Solution:
            for start in starts:
                w = resized(start, H)
                again = solve(held, w, 0.0, tolerance=tolerance, reuse=reuse)
                if again.converged:
                    break
            return again

        again = once(
            self.levels.store,
            f"again {tolerance:g}",
            H,
            found.omega,
            [found],
            attempt,
            lambda: attempt(*starts),
        )
        self.levels.keep(H, again.reuse)
        return replace(again, parameter=found.omega)
