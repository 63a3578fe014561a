"""The smallest largest peak over some parameters: where to start, and the search from there.

The largest peak has many minima, and jumps where a peak vanishes. So places all over the bounds are
tried with one harmonic, which takes a tenth of the time; the lowest of them with all harmonics; and
the search follows the peaks of the lowest of these.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from vanelock.commands.fit.parameters import (
    FitParameter,
    Progress,
    bounds_of,
    on_bounds,
    starts_of,
    values_of,
)
from vanelock.commands.optimise.objective import Functions, Minimax, Peaks, minimax
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.pipeline.progress import Listener, silent

LOWEST = 3
"""Of the starts, that are tried with all harmonics."""
TOLERANCE = 3e-4
"""Relative fall of the largest peak that is not worth a step; no mesh is that exact."""
ROUNDS = 4
"""Searches, each after a peak that none had followed was met."""
HIGHER = 1e-3
"""How much higher, relatively, a peak must be to be another one."""
ON_BOUND = 1e-3
"""Of the range: closer to a bound a value lies on it."""
EQUAL = 1e-3
"""Relative difference of two peaks that are equally high."""
_Objective = Callable[..., Functions | None]
"""Functions of x, of peaks that are followed there or, `afresh`, of all; None where none is."""
TRIALS = 10
"""Of a search, before any is known."""


class FrontPoint(NamedTuple):
    """Values (p,) of which neither peak nor wear becomes less without the other becoming more.

    The largest peak, m, and the most worn at one that counts, m³/s; whether no step promised less.
    """

    value: Floats
    peak: float
    wear: float
    settled: bool


@dataclass(frozen=True)
class Optimum:
    """Where the largest peak is smallest.

    Attributes
    ----------
    parameters : tuple of FitParameter
    value : (p,) float
    before, after : float
        What is smallest with the study's values and with these, m.
    frequencies : (j,) float
        Of the peaks that count there, Hz.
    amplitudes : (j,) float
        Theirs, m.
    trials : int
        Places that were tried.
    solved : int
        Frequencies solved with all harmonics.
    screened : int
        With one harmonic, to find where to start.
    settled : bool
        Whether no step promised a lower peak.
    of : str
        What is smallest: "largest peak", or "upper bound" of it over static friction.
    front : tuple of FrontPoint
        Of largest peak against wear, where it was asked for.
    """

    parameters: tuple[FitParameter, ...]
    value: Floats
    before: float
    after: float
    frequencies: Floats
    amplitudes: Floats
    trials: int
    solved: int
    screened: int
    settled: bool
    of: str = "largest peak"
    front: tuple[FrontPoint, ...] = ()

    @property
    def held(self) -> tuple[bool, ...]:
        """Whether each parameter lies on a bound."""
        return on_bounds(self.parameters, self.value, ON_BOUND)


def optimum(peaks: Peaks, starts: int = 0, listener: Listener = silent) -> Optimum:
    """The smallest largest peak: from the parameters' own values, or the lowest of other starts."""
    parameters = peaks.parameters
    low, high = bounds_of(parameters)
    own = starts_of(parameters)
    single, progress = peaks.with_one_harmonic(), Progress(listener, starts)
    begins = [(_swept(progress, single, x), x, single.followed) for x in spread(low, high, starts)]
    progress = Progress(listener, 1 + LOWEST * bool(starts) + TRIALS)
    trials = [(_swept(progress, peaks, own), own, peaks.followed)]
    for _, x, known in sorted(begins, key=lambda trial: trial[0])[:LOWEST]:
        peaks.led_by(known, x)
        trials.append((tried(progress, peaks(x)), x, peaks.followed))
    _, begin, peaks.followed = min(trials, key=lambda trial: trial[0])
    peaks.followed_x = begin
    chosen = searched(peaks, parameters, begin, progress)
    if chosen is None:
        raise InputError("optimise: no peak lies in the range of frequencies at any start")
    if not chosen.settled:
        peaks.followed = []
    there = peaks(chosen.x) or chosen.functions
    top = there.largest
    order = [each for each in peaks.followed if each.amplitude > (1 - EQUAL) * top]
    ends = [each.low for each in parameters], [each.high for each in parameters]
    return Optimum(
        parameters=tuple(parameters),
        value=np.clip(values_of(parameters, chosen.x), *ends),
        before=trials[0][0],
        after=top,
        frequencies=np.array([each.solution.omega for each in order]) / (2 * np.pi),
        amplitudes=np.array([each.amplitude for each in order]),
        trials=progress.trials,
        solved=peaks.solved,
        screened=single.solved,
        settled=chosen.settled,
    )


def searched(
    objective: _Objective,
    parameters: Sequence[FitParameter],
    begin: Floats,
    progress: Progress,
) -> Minimax | None:
    """The search from a place, whose peaks are known; None where it has none."""
    x, bounds = begin, bounds_of(parameters)

    def followed(x: Floats) -> Functions | None:
        functions = objective(x)
        tried(progress, functions)
        return functions

    for _ in range(ROUNDS):
        found = minimax(followed, x, bounds, TOLERANCE)
        if found is None:
            return None
        swept = objective(found.x, afresh=True)
        if swept is None or swept.largest < (1 + HIGHER) * found.functions.largest:
            return found
        x = found.x
    # A higher peak was met each time: of the start and the last place, the lower one.
    again = [(place, objective(place, afresh=True)) for place in (begin, x)]
    ends = [Minimax(place, there, False) for place, there in again if there is not None]
    return min(ends, key=lambda end: end.functions.largest, default=None)


def _swept(progress: Progress, peaks: Peaks, x: Floats) -> float:
    """The largest peak at a place, m, of the whole range; infinite where there is none."""
    peaks.followed = []
    return tried(progress, peaks(x))


def tried(progress: Progress, functions: Functions | None) -> float:
    """The largest function of a place, infinite where there is none, which is reported."""
    size = np.inf if functions is None else functions.largest
    progress.tried(size)
    return size


def spread(low: Floats, high: Floats, count: int) -> Floats:
    """(count, p) places within bounds, of a Sobol sequence behind its corner and its middle."""
    sequence = qmc.Sobol(len(low), scramble=False)
    sequence.fast_forward(2)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The balance properties", UserWarning)
        return np.asarray(low + (high - low) * sequence.random(count))
