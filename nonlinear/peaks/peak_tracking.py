"""Following the peak of a resonance along a parameter."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.forced_response.frequency_sweep import StepControl
from vanelock.nonlinear.forced_response.linear_response import check_bound, unbound
from vanelock.nonlinear.forced_response.options import PreparedSystem
from vanelock.nonlinear.forced_response.parameter_response import Parameter
from vanelock.nonlinear.fourier import TURN
from vanelock.nonlinear.newton.newton import Solution
from vanelock.nonlinear.peaks.peak import CONDITION, CurvePoint, Resonance

_NEAR = 2.0  # how many half-widths a peak may lie from where it was expected
_CLOSE = 0.05
"""How much lower, relatively, than the highest solution of a sweep the parabola through another top
may be for it to be refined too."""
LOWER = 1e-4
"""How much lower, relatively, than the solution that it was refined from a peak may be."""
FINEST = 1 / 2000
"""Shortest step, relative to the range of the parameter's coordinate."""
LONGEST = 1 / 25


@dataclass(frozen=True)
class PeakTrack:
    """What finds and follows the peak of one resonance, in a range from where sweeps begin, rad/s.

    `system_at` is the system by value of the parameter; without a `component`, output node and
    direction, it is that of the largest amplitude at the first peak; `span` is of the parameter's
    coordinate.
    """

    system_at: Callable[[float], PreparedSystem]
    varied: Parameter
    range: tuple[float, float]
    component: tuple[int, int] | None
    span: float
    condition: float = CONDITION

    def _peak(self, value: float, omega: float, near: CurvePoint, w: Floats) -> CurvePoint | None:
        """The peak near a frequency, from a guess of w and of its neighbour's curvature."""
        assert self.component is not None
        ready = self.system_at(value)
        family, tolerance = ready.solver.family, ready.options.tolerance
        resonance = Resonance(family, self.component, tolerance, self.condition)
        return resonance.peak(omega, w, near.bend, near.solution.reuse)

    def sweep(self, value: float, loose: float = 1.0) -> list[Solution]:
        """Solutions over the range of frequencies; unless all are, without the unconverged ones."""
        explored = list(self.system_at(value).solver.explore(*self.range, loose))
        return [solution for solution in explored if solution.converged] or explored

    @classmethod
    def along(
        cls,
        ready: PreparedSystem,
        varied: Parameter,
        hertz: Floats,
        component: tuple[int, int] | None,
        span: float = 1.0,
        condition: float = CONDITION,
    ) -> "PeakTrack":
        """What follows a peak along a parameter, from a range of frequencies, Hz."""
        low, high = (TURN * hertz).tolist()
        ends = (high, low) if ready.options.direction == "down" else (low, high)
        return cls(
            lru_cache(4)(partial(varied.at, ready)), varied, ends, component, span, condition
        )

    def begun(self, value: float) -> tuple["PeakTrack", CurvePoint | None]:
        """The highest peak at a value, None where none is, and what follows its output."""
        swept = self.sweep(value)
        track = self.with_component(value, swept)
        return track, track.highest(value, swept)

    def first(self, value: float, where: str) -> tuple["PeakTrack", CurvePoint]:
        """The same, which there must be; `where` that is, in words."""
        structure, what = self.system_at(value).structure, f"was found in it {where}"
        check_bound(structure, self.range, self.component, f"near: no largest amplitude {what}")
        track, peak = self.begun(value)
        if peak is None:
            raise InputError(f"near: no peak {what}")
        if not np.isfinite(peak.distance):
            ends, what = self.range, f"near: no largest amplitude {what}"
            check_bound(structure, ends, track.component, what, peak.omega)
        return track, peak

    def highest(self, value: float, swept: Sequence[Solution]) -> CurvePoint | None:
        """The highest peak among solutions by frequency; None if no maximum lies within.

        Of several tops all are refined that may be the highest. One that cannot be stands for
        itself, as does the largest solution where nothing bounds one.
        """
        if not self.bounded(value):
            return self.unresolved(value, swept)
        refined = self.tops(value, swept)
        if not refined:
            return None
        return max(refined, key=lambda peak: peak.amplitude).led_to_by(refined, swept)

    def bounded(self, value: float) -> bool:
        """Whether no resonance at a value is proved to be one that nothing bounds."""
        return unbound(self.system_at(value).structure, self.range, self.component) is None

    def tops(
        self, value: float, swept: Sequence[Solution], close: float = _CLOSE
    ) -> list[CurvePoint]:
        """The peaks among solutions by frequency that are as high as 1 - `close` of the highest."""
        assert self.component is not None
        size = self.amplitudes(value, swept)[:, *self.component]
        omegas = np.array([solution.omega for solution in swept])
        tops = []
        for top in np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])) + 1:
            beside = slice(top - 1, top + 2)
            a, b, _ = np.polyfit(omegas[beside] - omegas[top], size[beside], 2)
            bend = min(2 * a / size[top], -((self.range[1] - self.range[0]) ** -2.0))
            summit = size[top] - b**2 / (4 * a)
            here = CurvePoint(swept[int(top)], float(size[top]), bend, readings=0)
            tops.append((summit, here))
        enough = (1 - close) * max((here.amplitude for _, here in tops), default=0.0)
        return [self._refined(value, here) for summit, here in tops if summit >= enough]

    def _refined(self, value: float, here: CurvePoint) -> CurvePoint:
        """The peak at a solution, or that solution where it has none as high."""
        found = self._peak(value, here.omega, here, here.solution.w)
        if found is None or found.amplitude < (1 - LOWER) * here.amplitude:
            return replace(here, solution=replace(here.solution, iterations=0))
        return found

    def unresolved(self, value: float, swept: Sequence[Solution]) -> CurvePoint:
        """The largest amplitude among solutions by frequency, where no peak lies within."""
        assert self.component is not None
        size = self.amplitudes(value, swept)[:, *self.component]
        top = int(size.argmax())
        bend = -((self.range[1] - self.range[0]) ** -2.0)
        return CurvePoint(swept[top], float(size[top]), bend, readings=len(swept))

    def amplitudes(self, value: float, swept: Sequence[Solution]) -> Floats:
        """(p, o, 3) amplitude of every output, m."""
        ready = self.system_at(value)
        sizes = [ready.solver.amplitude(each) for each in swept]
        return np.array(sizes).reshape(-1, len(ready.structure.system.output_names), 3)

    def with_component(self, value: float, swept: Sequence[Solution]) -> "PeakTrack":
        """The ridge of the output that peaks highest among solutions by frequency."""
        if self.component is not None:
            return self
        size = self.amplitudes(value, swept)
        peaks = (size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])
        highest = np.where(peaks, size[1:-1], 0.0).max(axis=0, initial=0.0)
        node, direction = np.unravel_index(highest.argmax(), highest.shape)
        return replace(self, component=(int(node), int(direction)))

    def follow(self, peaks: Sequence[CurvePoint], value: float) -> list[CurvePoint]:
        """Peaks from the last of some to a value, intermediate ones where needed.

        The list is empty where the peak is lost: it vanishes, or moves too fast.
        """
        end = self.varied.coordinate(value)
        found: list[CurvePoint] = []
        ahead = [end]
        while ahead:
            before, here = [*peaks, *found], ahead[-1]
            peak = self.step(before, here, value if here == end else self.value(here))
            if peak is not None:
                found.append(peak)
                ahead.pop()
            elif abs(here - before[-1].coordinate) < 2 * FINEST * self.span:
                return []
            else:
                ahead.append(0.5 * (here + before[-1].coordinate))
        return found

    def placed(self, peak: CurvePoint, value: float) -> CurvePoint:
        """A peak as that at a value."""
        return replace(peak, coordinate=self.varied.coordinate(value), value=value)

    def value(self, coordinate: float) -> float:
        """Value of the parameter at a coordinate."""
        return float(np.exp(coordinate)) if self.varied.logarithmic else coordinate

    def step(
        self, peaks: Sequence[CurvePoint], coordinate: float, value: float
    ) -> CurvePoint | None:
        """The peak at a value, expected from the last ones; None where it is not found there."""
        omega, _, w = _expected(peaks, coordinate)
        last = peaks[-1]
        peak = self._peak(value, omega, last, w)
        if peak is None or abs(peak.omega - omega) > _NEAR * max(peak.width, last.width):
            return None
        return replace(peak, coordinate=coordinate, value=value)

    def explore(self, begin: CurvePoint, end: float) -> Iterator[CurvePoint]:
        """Peaks from the first one to a value at steps that follow the curve.

        Ends early where the peak is lost.
        """
        finest, target = FINEST * self.span, self.varied.coordinate(end)
        steps = StepControl(
            begin.coordinate, target, self.span / 100, finest, LONGEST * self.span, (0.4, 1.7), 4.0
        )
        peaks = [begin]
        while steps.here != target:
            coordinate = steps.ahead
            value = end if coordinate == target else self.value(coordinate)
            peak = self.step(peaks, coordinate, value)
            if peak is None:
                if not steps.shortened(2.5 * finest):
                    return
            elif steps.taken(coordinate, _surprise(peaks, peak)):
                yield peak
                peaks = [*peaks, peak][-3:]


def _expected(peaks: Sequence[CurvePoint], coordinate: float) -> tuple[float, float, Floats]:
    """Frequency, ln of the amplitude and w of a peak, by the parabola or line through the last."""
    last = peaks[-1]
    if len(peaks) == 1:
        return last.omega, float(np.log(last.amplitude)), last.solution.w
    before, ahead = peaks[-2], coordinate - last.coordinate
    share = ahead / (last.coordinate - before.coordinate)
    w = last.solution.w + share * (last.solution.w - before.solution.w)
    peaks = peaks[-3:]
    x = np.array([peak.coordinate for peak in peaks]) - last.coordinate
    both = np.array([[peak.omega, np.log(peak.amplitude)] for peak in peaks])
    omega, size = (float(np.polyval(np.polyfit(x, y, len(peaks) - 1), ahead)) for y in both.T)
    return omega, size, w


def _surprise(peaks: Sequence[CurvePoint], peak: CurvePoint) -> float:
    """How far a peak lies from where it was expected, in units of what a drawn curve forgives."""
    omega, size, _ = _expected(peaks, peak.coordinate)
    aside = abs(peak.omega - omega) / (0.5 * peak.width)
    return float(max(aside, abs(np.log(peak.amplitude) - size) / 0.03))


def named_component(names: Sequence[str], output: tuple[str, int] | None) -> tuple[int, int] | None:
    """Place of an output, given by its name and direction, among all outputs."""
    if not names:
        raise InputError("system: it has no output nodes; a peak needs one")
    if output is None:
        return None
    name, direction = output
    if name not in names:
        raise InputError(f"output: given {name!r}: allowed: {', '.join(names)}")
    if direction not in (0, 1, 2):
        raise InputError(f"output: given direction {direction!r}: allowed: 0, 1, 2")
    return list(names).index(name), direction
