"""Peaks by the places of the sliders, and the search for the least and the largest of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.following.parameters import Parameter
from vanelock.nonlinear.following.peak import CONDITION, PeakPoint, Resonance
from vanelock.nonlinear.following.peak_gradient import slider_gradient
from vanelock.nonlinear.following.peak_tracking import Mark, PeakTrack
from vanelock.nonlinear.following.rest_states import RestStates
from vanelock.nonlinear.forced_response.options import PreparedSystem

Floats = NDArray[np.float64]
Progress: TypeAlias = Callable[[int, float], None]

PLACES = (0.125, 0.25, 0.5, 0.75, 1.0)
"""Shares of a way at which peaks are solved."""
STEPS = 6
"""Most linear programmes along the gradient, from each start."""
ROUGH = 1e-2
"""Distance of peaks on the way from the exact ones, in half-widths: their amplitudes are off by
less than half its square."""
HIGHER = 1e-3
"""How much higher, relatively, another peak must be to count as one."""
CHECKS = 4
"""Places at each end of which a whole curve is solved."""


@dataclass(frozen=True)
class PlacedPeak:
    """The peak with sliders assembled somewhere.

    Attributes
    ----------
    slider : (c, 2) float
        Where, m.
    peak : PeakPoint
    found_by : str
    """

    slider: Floats
    peak: PeakPoint
    found_by: str

    def settled(self) -> "PlacedPeak":
        """The same, sliders that slid once and stick for good where they stick."""
        solution = self.peak.solution
        sticks = (solution.deviation.state == STUCK)[:, None]
        slid = np.where(sticks, solution.w[:, 1:, 0], 0.0)
        return replace(self, slider=self.slider + slid)


@dataclass(frozen=True)
class Search:
    """Peaks by the places of the sliders.

    Attributes
    ----------
    ready : PreparedSystem
        Sliders at zero.
    states : RestStates
        What places there are.
    range : (float, float)
        Range of frequencies, rad/s, in the order of a sweep.
    component : (int, int)
        Output node and direction.
    progress : callable, optional
    solved : list of int
        Frequencies solved for each peak so far.
    """

    ready: PreparedSystem
    states: RestStates
    range: tuple[float, float]
    component: tuple[int, int] | None
    progress: Progress | None
    solved: list[int] = field(default_factory=list)

    def _way(self, begin: Floats, end: Floats, condition: float = ROUGH) -> PeakTrack:
        """What follows a peak from one place of the sliders, 0, to another, 1."""
        contacts = self.ready.structure.system.contacts
        varied = Parameter("slider", contacts.mu > 0, False, np.array([begin, end]))
        at = lru_cache(4)(partial(varied.at, self.ready))
        return PeakTrack(at, varied, self.range, self.component, 1.0, condition)

    def at(self, slider: Floats) -> PreparedSystem:
        """The system with sliders assembled at (c, 2), m."""
        return self._way(slider, slider).at(0.0)

    def _counted(self, peak: PeakPoint) -> PeakPoint:
        self.solved.append(peak.readings)
        if self.progress is not None:
            self.progress(sum(self.solved), peak.amplitude)
        return peak

    def exact(self, place: PlacedPeak) -> PlacedPeak:
        """The same peak to the last digits, or a higher one with the same sliders."""
        track = self._way(place.slider, place.slider, CONDITION)
        peaks = [place.peak, *(mark.peak for mark in track.follow([Mark(0, 0, place.peak)], 1.0))]
        peaks.append(track.highest(0.0, track.sweep(0.0)) or peaks[-1])
        best = peaks[-1]
        if best.amplitude < (1 + HIGHER) * peaks[-2].amplitude:
            best = peaks[-2]
        return replace(place, peak=self._counted(best))

    def along(
        self, begin: PlacedPeak, end: Floats, found_by: str, sign: float | None = None
    ) -> list[PlacedPeak]:
        """Peaks on the way to another place; where one is lost, the highest there is goes on.

        With a sign, as far as they rise (1) or fall (-1), and the summit of a parabola there.
        """
        track = self._way(begin.slider, end)
        passed: list[Mark] = []
        marks = [Mark(0.0, 0.0, begin.peak)]
        for share in PLACES:
            found = track.follow(marks[-3:], share)
            if not found:
                peak = track.highest(share, track.sweep(share))
                if peak is None:
                    break
                found, marks = [Mark(share, share, peak)], []
            marks, passed = [*marks, *found], [*passed, *found]
            if sign is not None and len(marks) > len(found):
                before = marks[-1 - len(found)].peak
                if sign * found[-1].peak.amplitude < sign * before.amplitude:
                    summit = _summit(marks[-3:])
                    between = track.step(marks[-2:-1], summit, summit)
                    passed += [] if between is None else [between]
                    break
        places = []
        for mark in passed:
            slider = (1 - mark.place) * begin.slider + mark.place * end
            places.append(PlacedPeak(slider, self._counted(mark.peak), found_by))
        return places

    def climbed(
        self, begin: PlacedPeak, sign: float, tolerance: float
    ) -> tuple[list[PlacedPeak], bool]:
        """Higher peaks (with -1 lower ones) along the gradient; whether it leads no further."""
        places = [begin]
        for _ in range(STEPS):
            here = max(places, key=lambda each: sign * each.peak.amplitude).settled()
            family = self.at(here.slider).solver.family
            assert self.component is not None
            resonance = Resonance(family, self.component, self.ready.options.tolerance)
            gradient = sign * slider_gradient(resonance, here.peak.solution)
            closed = self.states.closed_at(here.slider)
            uphill = partial(self.states.extreme, -gradient.reshape(-1), closed=closed)
            end = _found(uphill)
            if end is None:
                break
            enough = tolerance * here.peak.amplitude
            if float(np.vdot(gradient[:, 1:], end - here.slider)) < enough:
                return places, True
            places += self.along(here, end, "gradient", sign)
            best = max(sign * each.peak.amplitude for each in places)
            if best - sign * here.peak.amplitude < enough:
                break
        return places, False

    def starts(
        self, begin: PlacedPeak, count: int, random: np.random.Generator
    ) -> list[list[PlacedPeak]]:
        """Ways to where the slipping joints press most and least, and to random places.

        Every second random place is a vertex, the others lie between two of them.
        """
        contacts = self.ready.structure.system.contacts
        slips = begin.peak.solution.deviation.state != STUCK
        ways = []
        for joint in dict.fromkeys(contacts.joints):
            mask = np.array([each == joint for each in contacts.joints])
            if (slips & mask).any():
                most = partial(self.states.least_load, mask, -1.0)
                for end in (_found(most), _found(partial(self.states.widest, mask))):
                    if end is not None:
                        ways.append(self.along(begin, end, "load"))
        for i in range(count):
            drawn = [
                self.states.extreme(each) for each in random.normal(size=(2, 3 * contacts.count))
            ]
            share = 1.0 if i % 2 == 0 else random.uniform()
            if drawn[0] is not None and drawn[1] is not None:
                end = share * drawn[0] + (1 - share) * drawn[1]
                ways.append(self.along(begin, end, "random"))
        return ways

    def extremes(self, count: int, tolerance: float, random: np.random.Generator) -> "Ends":
        """The least and the largest peak, from so many random starts."""
        zero = self.states.zero
        track = self._way(zero, zero)
        swept = track.sweep(0.0)
        track = track.with_component(0.0, swept)
        peak = track.highest(0.0, swept)
        if peak is None:
            raise InputError("near: no peak was found in it with sliders assembled at zero")
        search = replace(self, component=track.component)
        nominal = search.exact(PlacedPeak(zero, peak, "assembled at zero"))
        known = nominal, True
        if not self.states.share.any() or not self.states.system.contacts.mu.any():
            return Ends(search, (known, known, known), [])
        ways = [way for way in search.starts(nominal, count, random) if way]
        drawn = [way[-1].peak.amplitude for way in ways if way[-1].found_by == "random"]
        low, high = (search.end(nominal, ways, sign, tolerance) for sign in (-1.0, 1.0))
        return Ends(search, (low, known, high), drawn)

    def end(
        self, nominal: PlacedPeak, ways: Sequence[list[PlacedPeak]], sign: float, tolerance: float
    ) -> tuple[PlacedPeak, bool]:
        """The least (-1) or largest (1) peak, and whether the gradient leads no further from it."""

        def key(place: PlacedPeak) -> float:
            return sign * place.peak.amplitude

        known = [nominal, *(place for way in ways for place in way)]
        drawn = [way for way in ways if way[0].found_by == "random"]
        begins = [max(known, key=key), *(max(way, key=key) for way in drawn)]
        still: set[int] = set()
        for begin in {id(each): each for each in begins}.values():
            places, stationary = self.climbed(begin, sign, tolerance)
            known += places
            if stationary:
                still.add(id(max(places, key=key)))
        known.sort(key=key, reverse=True)
        checked: list[tuple[PlacedPeak, bool]] = []
        while known and len(checked) < CHECKS:
            place = known.pop(0)
            if checked and key(place) <= max(key(each) for each, _ in checked):
                break
            exact = self.exact(place)
            same = abs(exact.peak.amplitude / place.peak.amplitude - 1) < HIGHER
            checked.append((exact, same and id(place) in still))
        return max(checked, key=lambda each: key(each[0]))


@dataclass(frozen=True)
class Ends:
    """What a search found.

    Attributes
    ----------
    search : Search
        With the output whose peak it is.
    places : ((PlacedPeak, bool), (PlacedPeak, bool), (PlacedPeak, bool))
        The least peak, that with sliders at zero and the largest; whether the gradient leads no
        further from each.
    drawn : list of float
        Peaks at random places, m.
    """

    search: Search
    places: tuple[tuple[PlacedPeak, bool], tuple[PlacedPeak, bool], tuple[PlacedPeak, bool]]
    drawn: list[float]


def _found(end: Callable[[], Floats | None]) -> Floats | None:
    """Sliders at an end; None where there is none, or the programme failed."""
    try:
        return end()
    except InputError:
        return None


def _summit(marks: Sequence[Mark]) -> float:
    """Where the parabola through three amplitudes has its extreme; of two, a quarter of the way."""
    place, size = np.array([(mark.place, mark.peak.amplitude) for mark in marks]).T
    if len(marks) < 3:
        return float(0.75 * place[0] + 0.25 * place[-1])
    bend, slope = np.polyder(np.polyfit(place - place[1], size, 2))
    summit = place[1] - slope / bend if bend else place[1]
    return float(np.clip(summit, 0.75 * place[0] + 0.25 * place[1], place[2]))
