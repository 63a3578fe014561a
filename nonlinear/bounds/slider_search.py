"""Peaks by the places of the sliders, and the search for the least and the largest of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.bounds.rest_states import RestStates
from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.forced_response.options import PreparedSystem
from vanelock.nonlinear.forced_response.parameter_response import Parameter
from vanelock.nonlinear.peaks.amplitude_gradient import amplitude_gradient
from vanelock.nonlinear.peaks.peak import CONDITION, CurvePoint
from vanelock.nonlinear.peaks.peak_tracking import PeakTrack

Progress: TypeAlias = Callable[[int, float], None]

_PLACES = (0.125, 0.25, 0.5, 0.75, 1.0)  # shares of a way at which peaks are solved
_STEPS = 6  # most cone programmes along the gradient, from each start
_ROUGH = 1e-2
"""Distance of peaks on the way from the exact ones, in half-widths: their amplitudes are off by
less than half its square."""
_HIGHER = 1e-3  # how much higher, relatively, another peak must be to count as one
_ASSEMBLED = "assembled at zero"  # what found the peak with sliders at zero


@dataclass(frozen=True)
class _PlacedPeak:
    """The peak with sliders assembled somewhere, (c, 2) m.

    `swept`: it is exact, and the highest there; `stationary`: the gradient leads no further.
    """

    slider: Floats
    peak: CurvePoint
    found_by: str
    swept: bool = False
    stationary: bool = False


@dataclass
class Search:
    """Peaks of an output's component by the places of the sliders, at zero in `ready`.

    `near` (2,), Hz, is the range of frequencies, of which so many were `solved`; without a
    `component` it is that of the largest amplitude with sliders at zero.
    """

    ready: PreparedSystem
    states: RestStates
    near: Floats
    component: tuple[int, int] | None
    progress: Progress | None = None
    solved: int = 0

    def _counted(self, peak: CurvePoint) -> CurvePoint:
        """A peak, what it took counted and reported."""
        self.solved += peak.readings
        if self.progress is not None:
            self.progress(self.solved, peak.amplitude)
        return peak

    def _way(self, begin: Floats, end: Floats, condition: float = _ROUGH) -> PeakTrack:
        """What follows a peak from one place of the sliders, 0, to another, 1."""
        contacts = self.ready.structure.system.contacts
        varied = Parameter("slider", contacts.mu > 0, False, np.array([begin, end]))
        return PeakTrack.along(self.ready, varied, self.near, self.component, condition=condition)

    def at(self, slider: Floats) -> PreparedSystem:
        """The system with sliders assembled at (c, 2), m."""
        return self._way(slider, slider).system_at(0.0)

    def exact(self, candidate: _PlacedPeak) -> _PlacedPeak:
        """The same peak to the last digits, or a higher one with the same sliders."""
        if candidate.swept:
            return candidate
        track = self._way(candidate.slider, candidate.slider, CONDITION)
        peaks = [candidate.peak, *track.follow([track.placed(candidate.peak, 0.0)], 1.0)]
        peaks.append(track.begun(0.0)[1] or peaks[-1])
        best = peaks[-1]
        if best.amplitude < (1 + _HIGHER) * peaks[-2].amplitude:
            best = peaks[-2]
        return replace(candidate, peak=self._counted(best), swept=True)

    def along(
        self, begin: _PlacedPeak, end: Floats, found_by: str, sign: float | None = None
    ) -> list[_PlacedPeak]:
        """Peaks on the way to another place; where one is lost, the highest there is goes on.

        With a sign, as far as they rise (1) or fall (-1), and the summit of a parabola there.
        """
        track = self._way(begin.slider, end)
        passed: list[CurvePoint] = []
        peaks = [track.placed(begin.peak, 0.0)]
        for share in _PLACES:
            found = track.follow(peaks[-3:], share)
            if not found:
                peak = track.begun(share)[1]
                if peak is None:
                    break
                found, peaks = [track.placed(peak, share)], []
            peaks, passed = [*peaks, *found], [*passed, *found]
            if sign is not None and len(peaks) > len(found):
                before = peaks[-1 - len(found)]
                if sign * found[-1].amplitude < sign * before.amplitude:
                    summit = _summit(peaks[-3:])
                    between = track.step(peaks[-2:-1], summit, summit)
                    passed += [] if between is None else [between]
                    break
        places = []
        for peak in passed:
            slider = (1 - peak.value) * begin.slider + peak.value * end
            places.append(_PlacedPeak(slider, self._counted(peak), found_by))
        return places

    def climbed(self, begin: _PlacedPeak, sign: float, tolerance: float) -> list[_PlacedPeak]:
        """Higher peaks (with -1 lower ones) along the gradient."""
        places = [begin]
        for _ in range(_STEPS):
            top = max(places, key=lambda placed: sign * placed.peak.amplitude)
            # Sliders that slid once and stick for good are placed where they stick.
            solution = top.peak.solution
            sticks = (solution.deviation.state == STUCK)[:, None]
            slid = np.where(sticks, solution.w[:, 1:, 0], 0.0)
            here = replace(top, slider=top.slider + slid)
            ready, component = self.at(here.slider), self.component
            assert component is not None
            found = amplitude_gradient(ready, here.peak.solution, component, held=True)
            if found is None:
                break
            gradient = np.zeros((len(here.slider), 3))
            gradient[:, 1:] = sign * found.by_slider()
            closed = self.states.solved(here.slider).contact[0, 0, :, 0].real > 0
            uphill = partial(self.states.extreme, -gradient.reshape(-1), closed=closed)
            end = _found(uphill)
            if end is None:
                break
            enough = tolerance * here.peak.amplitude
            if float(np.vdot(gradient[:, 1:], end - here.slider)) < enough:
                smooth = not top.peak.sharp and top.peak.distance < CONDITION
                return [*places, replace(top, stationary=smooth)]
            places += self.along(here, end, "gradient", sign)
            best = max(sign * each.peak.amplitude for each in places)
            if best - sign * here.peak.amplitude < enough:
                break
        return places

    def starts(
        self, begin: _PlacedPeak, count: int, random: np.random.Generator
    ) -> list[list[_PlacedPeak]]:
        """Ways to where slipping joints press most and least, and to random places, swept there.

        Every second random place is a vertex, the others lie between two of them.
        """
        contacts = self.ready.structure.system.contacts
        slips = begin.peak.solution.deviation.state != STUCK
        ways = []
        for joint in dict.fromkeys(contacts.joints):
            mask = contacts.of(joint)
            if (slips & mask).any():
                most = partial(self.states.most_load, mask)
                for end in (_found(most), _found(partial(self.states.widest, mask))):
                    if end is not None:
                        ways.append(self.along(begin, end, "load"))
        for i in range(count):
            objectives = random.normal(size=(2, 3 * contacts.count))
            first, second = (_found(partial(self.states.extreme, each)) for each in objectives)
            share = 1.0 if i % 2 == 0 else random.uniform()
            if first is not None and second is not None:
                end = share * first + (1 - share) * second
                ways.append(self.along(begin, end, "random"))
        return [[*way[:-1], self.exact(way[-1])] for way in ways if way]

    def extremes(
        self, count: int, tolerance: float, random: np.random.Generator
    ) -> tuple[list[_PlacedPeak], list[float]]:
        """The least peak, that with sliders at zero and the largest, from so many random starts.

        Also the peaks at random places, m.
        """
        zero = self.states.zero
        track, peak = self._way(zero, zero, CONDITION).first(0.0, "with sliders assembled at zero")
        self.component = track.component
        nominal = _PlacedPeak(zero, self._counted(peak), _ASSEMBLED, swept=True)
        if not self.states.share.any() or not self.states.system.contacts.mu.any():
            known = replace(nominal, stationary=True)
            return [known, known, known], []
        ways = self.starts(nominal, count, random)
        drawn = [way[-1].peak.amplitude for way in ways if way[-1].found_by == "random"]
        lows = self.end([nominal], ways, -1.0, tolerance)
        found = self.end(lows, ways, 1.0, tolerance)  # a higher one may be met in search of it
        low, high = (
            choose(found, key=lambda placed: placed.peak.amplitude) for choose in (min, max)
        )
        return [low, nominal, high], drawn

    def end(
        self,
        begun: Sequence[_PlacedPeak],
        ways: Sequence[list[_PlacedPeak]],
        sign: float,
        tolerance: float,
    ) -> list[_PlacedPeak]:
        """Places that are swept, the least (-1) or largest (1) peak among them."""

        def key(candidate: _PlacedPeak) -> float:
            return sign * candidate.peak.amplitude

        known = [*begun, *(place for way in ways for place in way)]
        others = list[float]()
        best = self._best(known, sign, others)
        drawn = [way for way in ways if way[0].found_by == "random"]
        tops = [max((each for each in way if each.swept or sign > 0), key=key) for way in drawn]
        for each in (top for top in tops if top.peak is not best.peak):
            known += self.climbed(each, sign, tolerance)
        for _ in range(_STEPS):
            known += self.climbed(best, sign, tolerance)
            before, best = best, self._best(known, sign, others)
            if best.peak is before.peak:
                break
        return [each for each in known if each.swept]

    def _best(self, candidates: list[_PlacedPeak], sign: float, others: list[float]) -> _PlacedPeak:
        """The best place, exact; sweeps all that may be better, but where another peak is seen.

        `others` are frequencies, rad/s, at which sweeps saw peaks higher than those followed.
        """

        def key(candidate: _PlacedPeak) -> tuple[float, bool, bool]:
            return sign * candidate.peak.amplitude, candidate.stationary, candidate.swept

        while True:
            candidates.sort(key=key, reverse=True)
            size = candidates[0].peak.amplitude
            enough = sign * size - _ROUGH**2 / 2 * size
            if best := next((p for p in candidates if p.swept and key(p)[0] >= enough), None):
                return best
            place = candidates.pop(0)
            least = min(each.peak.amplitude for each in candidates if each.swept)
            if sign > 0 or not self._seen(place, others, least):
                candidates.append(self.exact(place))
                if candidates[-1].peak.amplitude > (1 + _HIGHER) * size:
                    others.append(candidates[-1].peak.omega)

    def _seen(self, candidate: _PlacedPeak, omegas: Sequence[float], size: float) -> bool:
        """Whether an amplitude larger than that is at one of some frequencies, rad/s."""
        assert self.component is not None
        track = self._way(candidate.slider, candidate.slider)
        for omega in omegas[::-1]:
            self.solved += 1
            swept = track.system_at(0.0).solver.sweep(np.array([omega]))
            solved = [each for each in swept if each.converged]
            if (track.amplitudes(0.0, solved)[:, *self.component] > size).any():
                return True
        return False


def _found(end: Callable[[], Floats | None]) -> Floats | None:
    """Sliders at an end; None where there is none, or the programme failed."""
    try:
        return end()
    except InputError:
        return None


def _summit(peaks: Sequence[CurvePoint]) -> float:
    """Where the parabola through three amplitudes has its extreme; of two, a quarter of the way."""
    place, size = np.array([(peak.value, peak.amplitude) for peak in peaks]).T
    if len(peaks) < 3:
        return float(0.75 * place[0] + 0.25 * place[-1])
    bend, slope = np.polyder(np.polyfit(place - place[1], size, 2))
    summit = place[1] - slope / bend if bend else place[1]
    return float(np.clip(summit, 0.75 * place[0] + 0.25 * place[1], place[2]))
