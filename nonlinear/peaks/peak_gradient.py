"""How a peak moves with all that the system is made of: its amplitude, and its frequency.

At a peak the amplitude is stationary in frequency, so that its gradient at the frequency held is
the peak's. With A' = dA/dω = 0 there, the frequency follows a parameter p by

    dω/dp = -(d/dω dA/dp) / A'',

both derivatives by differences between solutions to either side.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.forced_response.options import Options, PreparedSystem, checked_range
from vanelock.nonlinear.forced_response.parameter_response import Parameter
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.peaks.amplitude_gradient import (
    AmplitudeGradient,
    amplitude_gradient,
    prepared_again,
    solution_at,
)
from vanelock.nonlinear.peaks.peak import CONDITION, CurvePoint, Resonance
from vanelock.nonlinear.peaks.peak_tracking import LOWER, PeakTrack, named_component
from vanelock.rom.system.system import System

_Change = TypeVar("_Change", float, Floats)

_ASIDE = 2e-4
"""How far from the peak, in its half-widths, slopes are taken for the frequency's gradient."""
_EVEN = 1e-3
"""How unlike slopes to either side may be there, relatively, for differences to be exact; where
they are more unlike the differences are taken that much closer to the peak."""


@dataclass(frozen=True)
class PeakGradient:
    """A peak, and what moves it.

    Attributes
    ----------
    peak : CurvePoint
        Where it is sharp, its amplitude follows what its contacts do there, not the gradient.
    output : (str, int)
        Name of the output node and direction.
    at_peak : AmplitudeGradient
        What moves the amplitude.
    beside : tuple of AmplitudeGradient
        At frequencies close below and above; none where `why` says why.
    bend : float
        A'', m s²/rad².
    why : str
        What is in the way of the frequency's gradient.
    """

    peak: CurvePoint
    output: tuple[str, int]
    at_peak: AmplitudeGradient
    beside: tuple[AmplitudeGradient, ...] = ()
    bend: float = np.nan
    why: str = ""

    @property
    def amplitude(self) -> float:
        """A, half the peak-to-peak of the output, m."""
        return self.peak.amplitude

    @property
    def frequency(self) -> float:
        """Of the peak, Hz."""
        return self.peak.solution.omega / TURN

    def of_frequency(self, by: Callable[[AmplitudeGradient], _Change]) -> _Change:
        """What moves the peak's frequency, Hz, by what an amplitude's gradient has.

        Parameters
        ----------
        by : callable
            As `AmplitudeGradient.by_force`: a gradient's share of one or more parameters.

        Raises
        ------
        InputError
            If no gradients beside the peak are known.
        """
        if not self.beside:
            raise InputError(f"of_frequency: {self.why}")
        below, above = self.beside
        return -(by(above) - by(below)) / ((above.omega - below.omega) * self.bend * TURN)


@one_thread
def peak_gradient(
    system: System,
    near: tuple[float, float],
    options: Options = Options(),
    output: tuple[str, int] | None = None,
    frequency: bool = False,
) -> PeakGradient:
    """The highest peak of a range, and what moves it.

    Parameters
    ----------
    system : System
    near : (float, float)
        Range of frequencies in which the peak is looked for, Hz.
    options : Options
        With one harmonic at least.
    output : (str, int), optional
        Name of the output node and direction, 0 to 2; by default those of the largest amplitude.
    frequency : bool
        Whether what moves its frequency is asked for, too: two more solutions.

    Raises
    ------
    InputError
        As of `frequency_response`, or if no peak lies in the range, or the solutions fold there.
    """
    hertz = checked_range(near, "near")
    if options.harmonics == 0:
        raise InputError("harmonics: given 0: a peak needs at least 1")
    ready = options.prepare(system, hertz, 1000)
    low, high = TURN * hertz
    component = named_component(system.output_names, output)
    unvaried = Parameter("force", np.zeros(system.contacts.count, bool), False)
    track = PeakTrack(lambda _: ready, unvaried, (low, high), component, 1.0)
    track, peak = track.begun(1.0)
    if peak is None or track.component is None:
        raise InputError("near: no peak was found in it")
    found = _gradient_of_peak(ready, track.component, peak, frequency)
    if found is None:
        raise InputError("near: the solutions fold at the peak that was found in it")
    return found


@one_thread
def peak_gradient_of(
    system: System,
    response: Response,
    point: int,
    output: tuple[str, int],
    width: float,
    modes: Mapping[int, StuckModes] | None = None,
) -> PeakGradient:
    """The peak at a point of a response, and what moves its amplitude and frequency.

    Parameters
    ----------
    system : System
        The one that was solved.
    response : Response
        Its own coefficients of friction count.
    point : int
        Close to the peak.
    output : (str, int)
        Name of the output node and direction, 0 to 2.
    width : float
        About the half-width of the peak, Hz.
    modes : dict of int to StuckModes, optional
        As of `frequency_response`.

    Raises
    ------
    InputError
        As of `frequency_response`, or if no peak is there, or the solutions fold.
    """
    if not (-response.points <= point < response.points and width > 0):
        range_of = f"needs one of {response.points} points and a width above 0 Hz"
        raise InputError(f"point, width: given {point}, {width:g}: {range_of}")
    ready = prepared_again(system, response.at([point]), modes)
    component = named_component(system.output_names, output)
    assert component is not None
    solution = solution_at(ready, response, point)
    resonance = Resonance(ready.solver.family, component, ready.options.tolerance)
    bend = -((TURN * width) ** -2.0)
    peak = resonance.peak(solution.omega, solution.w, bend) if solution.converged else None
    at_point = float(response.amplitude[point, *component])
    if peak is None or peak.amplitude < (1 - LOWER) * at_point:
        raise InputError(f"point: given {point}: no peak was found there")
    found = _gradient_of_peak(ready, component, peak, frequency=True)
    if found is None:
        raise InputError(f"point: given {point}: the solutions fold at the peak there")
    return found


def _gradient_of_peak(
    ready: PreparedSystem, component: tuple[int, int], peak: CurvePoint, frequency: bool = False
) -> PeakGradient | None:
    """What moves a known peak; None where the solutions fold there."""
    at_peak = amplitude_gradient(ready, peak.solution, component)
    if at_peak is None:
        return None
    output = ready.structure.system.output_names[component[0]], component[1]
    found = PeakGradient(peak, output, at_peak)
    for met, why in (
        (not frequency, "the peak's frequency was not asked for"),
        (peak.sharp, "the peak is sharp: a contact changes its state there"),
        (not peak.distance < CONDITION, "the peak is not exact: its extremum was not solved"),
    ):
        if met:
            return replace(found, why=why)
    found_beside = _beside(ready, component, peak, _ASIDE * peak.width)
    if found_beside is not None and (uneven := found_beside[2]) > _EVEN:
        found_beside = _beside(ready, component, peak, _ASIDE * peak.width * _EVEN / uneven)
    if found_beside is None:
        return replace(found, why="close beside the peak the path turns back or was lost")
    beside, bend, _ = found_beside
    return replace(found, beside=beside, bend=bend)


def _beside(
    ready: PreparedSystem, component: tuple[int, int], peak: CurvePoint, aside: float
) -> tuple[tuple[AmplitudeGradient, AmplitudeGradient], float, float] | None:
    """Gradients so far, rad/s, to either side of a peak, A'' between them, how unlike slopes are.

    None where they are not found.
    """
    resonance = Resonance(ready.solver.family, component, ready.options.tolerance)
    start, found, slopes = peak.solution, [], []
    for sign in (-1, 1):
        reading = resonance.read(start.omega + sign * aside, start.w, start.reuse)
        if reading is None:
            return None
        gradient = amplitude_gradient(ready, reading.solution, component)
        if gradient is None:
            return None
        found.append(gradient)
        slopes.append(reading.slope)
    below, above = found
    change = slopes[1] - slopes[0]
    uneven = abs(slopes[1] + slopes[0]) / abs(change) if change else np.inf
    return (below, above), change / (above.omega - below.omega), uneven
