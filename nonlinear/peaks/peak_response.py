"""Backbone-like curves: the peak of a resonance against force, friction or interference."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.forced_response.frequency_sweep import Progress
from vanelock.nonlinear.forced_response.options import Options, checked_range
from vanelock.nonlinear.forced_response.parameter_response import (
    Joint,
    checked_parameter,
    joined,
)
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.peaks.peak import CurvePoint
from vanelock.nonlinear.peaks.peak_tracking import FINEST, LONGEST, PeakTrack, named_component
from vanelock.rom.system.system import System

_Track: TypeAlias = dict[float, CurvePoint]
_Report: TypeAlias = Callable[[CurvePoint], None]

_HIGHER = 1e-3  # how much higher, relatively, another peak must be to count as one


@dataclass(frozen=True)
class PeakResponse(Product):
    """The highest peak of a resonance at p values of a parameter.

    Attributes
    ----------
    name : str
        "force", "mu" or "interference".
    parameter : (p,) float
        Factor of the excitation, coefficient of friction, or interference in m.
    output : str
        Name of the output node whose peak it is.
    direction : int
        Its direction, 0, 1 or 2.
    frequency : (p,) float
        Of the peak, Hz.
    amplitude : (p,) float
        Half the peak-to-peak of the output at the peak, m.
    width : (p,) float
        Half-width of the peak, (-A/A'')^½, Hz: half the half-power bandwidth of a linear one.
    distance : (p,) float
        What is left of the extremum condition: the distance from the peak in its half-widths.
    converged : (p,) bool
        Whether the balance is solved, and the extremum condition too or the peak is sharp.
    sharp : (p,) bool
        The slope of the curve jumps over zero there, where a contact changes its state.
    second_peak : (p,) float
        Amplitude of a second, lower peak of the same output, m; nan where none was met.
    readings : (p,) int
        Frequencies solved, intermediate values of the parameter included.
    response : Response
        The whole state at each peak, a point for each value; its `mu` is the given system's.
    mu : (p, c) float
        Friction coefficients of each point.
    """

    name: str
    parameter: Floats
    output: str
    direction: int
    frequency: Floats = field(metadata={"unit": "Hz"})
    amplitude: Floats = field(metadata={"unit": "m"})
    width: Floats = field(metadata={"unit": "Hz"})
    distance: Floats
    converged: Booleans
    sharp: Booleans
    second_peak: Floats = field(metadata={"unit": "m"})
    readings: Integers
    response: Response
    mu: Floats

    @property
    def dissipation(self) -> Floats:
        """(p,) friction work of all contacts in a period, J."""
        return np.asarray(self.response.dissipation.sum(axis=1))

    @property
    def states(self) -> Integers:
        """(p, 4) numbers of contacts that are STUCK, SLIP, OPEN and SLIP_OPEN."""
        return np.stack([(self.response.state == each).sum(axis=1) for each in range(4)], axis=1)

    def at(self, point: int) -> Response:
        """One peak as a response of its own, with its own friction coefficients."""
        return replace(self.response.at([point]), mu=self.mu[point])


@one_thread
def peak_response(
    system: System,
    parameter: str,
    values: ArrayLike | tuple[float, float],
    near: tuple[float, float],
    options: Options = Options(),
    output: tuple[str, int] | None = None,
    joint: Joint = None,
    progress: Progress | None = None,
) -> PeakResponse:
    """Frequency and amplitude of a resonance's peak against a parameter.

    A sweep of frequencies finds the peak at the first value; from there on the peak itself is
    followed, by its extremum condition dA/dω = 0, as long as it exists. Where it ends, and at the
    last value, another sweep looks for a higher one, which is then followed backwards; the higher
    one is reported, the other one is its `second_peak`. One that is higher in between alone goes
    unnoticed. A value at which no peak lies in the range, or nothing bounds it, gives its largest
    amplitude, not converged; a range of values has its last one beyond that.

    Samples of the contact law leave kinks in the curve, and peaks that are sharp: they are as exact
    as the law is.

    Parameters
    ----------
    system : System
    parameter : {"force", "mu", "interference"}
        "force": factor of the excitation of all harmonics h >= 1, the static load stays; "mu":
        coefficient of friction; "interference": v0, m.
    values : (p,) array_like or (float, float)
        Values of the parameter in the order in which they are passed. A tuple (first, last): a
        range, sampled as the curve needs it.
    near : (float, float)
        Range of frequencies in which sweeps look for the peak, Hz.
    options : Options
        With one harmonic at least; their direction is that in which sweeps pass frequencies.
    output : (str, int), optional
        Name of the output node and direction, 0 to 2; by default those of the largest amplitude at
        the first value.
    joint : str, sequence of str or (c,) bool, optional
        The joints or contacts whose friction or interference varies; all by default.
    progress : callable, optional
        Called after each peak with (peaks done, peaks in all, estimated for a range; value;
        amplitude, m).

    Returns
    -------
    PeakResponse
        `converged` says for each point whether it is to be trusted.

    Raises
    ------
    InputError
        As of `frequency_response`, or if an argument is not possible, or at the first value no peak
        lies in the range, or none is found and nothing but friction damps.
    """
    varied, given = checked_parameter(parameter, system, values, joint)
    is_range = isinstance(values, tuple)
    if is_range and (len(given) != 2 or given[0] == given[1]):
        raise InputError(f"values: given {tuple(given)}: a range is (first, last)")
    if len(np.unique(given)) < len(given):
        raise InputError("values: given one of them twice: needs different ones")
    hertz = checked_range(near, "near")
    if options.harmonics == 0:
        raise InputError("harmonics: given 0: a peak needs at least 1")
    component = named_component(system.output_names, output)
    ready = options.prepare(system, hertz, 1000)
    span = max(np.ptp([varied.coordinate(value) for value in given]), 1e-12)
    ridge = PeakTrack.along(ready, varied, hertz, component, span)
    tracks, ridge = _traced(ridge, given.tolist(), is_range, progress)
    best, second = _chosen(tracks)
    assert ridge.component is not None
    each = [ridge.system_at(peak.value).response([peak.solution]) for peak in best]
    response, mu = joined(each, system.contacts.mu)
    node, direction = ridge.component
    return PeakResponse(
        name=ridge.varied.name,
        parameter=np.array([peak.value for peak in best]),
        output=system.output_names[node],
        direction=direction,
        frequency=response.frequency,
        amplitude=np.array([peak.amplitude for peak in best]),
        width=np.array([peak.width for peak in best]) / TURN,
        distance=np.array([peak.distance for peak in best]),
        converged=response.converged & np.array([peak.exact for peak in best]),
        sharp=np.array([peak.sharp for peak in best], bool),
        second_peak=np.array(second),
        readings=np.array([peak.readings for peak in best], np.int64),
        response=response,
        mu=mu,
    )


def _traced(
    ridge: PeakTrack, values: list[float], is_range: bool, progress: Progress | None
) -> tuple[list[_Track], PeakTrack]:
    """Tracks of peaks by value, and the ridge with its component chosen."""
    ridge, begun = ridge.first(values[0], f"at {ridge.varied.name} = {values[0]:g}")
    first = ridge.placed(begun, values[0])
    tracks = [{values[0]: first}]
    done = count(1)

    def report(peak: CurvePoint) -> None:
        """Count one more peak."""
        number, expected = next(done), len(values)
        if is_range:
            expected = number if peak.value == values[-1] else max(number + 1, 50)
        if progress is not None:
            progress(number, expected, peak.value, peak.amplitude)

    report(first)
    if is_range:
        _over_range(ridge, tracks, values[-1], report)
    else:
        _through(ridge, tracks, values[1:], report)
    *before, last = _passed(tracks)
    again = ridge.begun(last)[1]
    if again is not None and again.amplitude > (1 + _HIGHER) * tracks[-1][last].amplitude:
        tracks.append({last: ridge.placed(again, last)})
        _backward(ridge, tracks[-1], before[::-1])
    return tracks, ridge


def _passed(tracks: Sequence[_Track]) -> list[float]:
    """Values in the order in which they were passed."""
    return list(dict.fromkeys(value for track in tracks for value in track))


def _over_range(ridge: PeakTrack, tracks: list[_Track], end: float, report: _Report) -> None:
    """Follow the peak to the end of a range; where it is lost, on from the highest beyond."""
    begun: CurvePoint | None
    (begun,) = tracks[0].values()
    place, last, step = begun.coordinate, ridge.varied.coordinate(end), FINEST
    while place != last:
        for peak in ridge.explore(begun, end) if begun else ():
            tracks[-1][peak.value] = peak
            report(peak)
            place, step = peak.coordinate, FINEST
        if place == last:
            return
        step = min(2 * step, LONGEST)
        left = last - place
        place += float(np.copysign(min(step * ridge.span, abs(left)), left))
        value = end if abs(last - place) < 1e-12 * ridge.span else ridge.value(place)
        value = value if ridge.bounded(value) else end  # what nothing bounds here, nothing does on
        place = ridge.varied.coordinate(value)
        begun = _restarted(ridge, tracks, value, report)


def _through(
    ridge: PeakTrack, tracks: list[_Track], values: Sequence[float], report: _Report
) -> None:
    """Follow the peak through values; where it is lost, the highest one there is."""
    known = list(tracks[-1].values())
    for value in values:
        found = ridge.follow(known[-3:], value) if known and ridge.bounded(value) else []
        if found:
            tracks[-1][value] = found[-1].led_to_by(found)
            known.extend(found)
            report(tracks[-1][value])
        else:
            begun = _restarted(ridge, tracks, value, report)
            known = [begun] if begun else []


def _restarted(
    ridge: PeakTrack, tracks: list[_Track], value: float, report: _Report
) -> CurvePoint | None:
    """The highest peak at a value, followed backwards.

    None if no peak lies in the range or is found; the largest amplitude stands for it.
    """
    swept, before = ridge.sweep(value), _passed(tracks)
    peak = ridge.highest(value, swept)
    peak = ridge.placed(peak or ridge.unresolved(value, swept), value)
    tracks.append({value: peak})
    report(peak)
    if not np.isfinite(peak.distance):  # no peak to follow
        return None
    _backward(ridge, tracks[-1], before[::-1])
    return peak


def _backward(ridge: PeakTrack, track: _Track, values: Sequence[float]) -> None:
    """Follow a track to further values as long as it exists."""
    known = list(track.values())
    for value in values:
        found = ridge.follow(known[-3:], value)
        if not found:
            return
        track[value] = found[-1].led_to_by(found)
        known.extend(found)


def _chosen(tracks: Sequence[_Track]) -> tuple[list[CurvePoint], list[float]]:
    """The highest peak at each value, and the amplitude of the next one or nan."""
    best, second = [], []
    for value in _passed(tracks):
        here = [track[value] for track in tracks if value in track]
        here.sort(key=lambda peak: -peak.amplitude)
        best.append(here[0])
        others = [
            peak.amplitude
            for peak in here[1:]
            if abs(peak.omega - here[0].omega) > 1e-3 * here[0].width
        ]
        second.append(max(others, default=np.nan))
    return best, second
