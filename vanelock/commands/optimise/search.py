"""The smallest largest peak over some parameters: where to start, and the search from there.

The largest peak has many minima, and jumps where a peak vanishes. So places all over the bounds are
tried with one harmonic, which takes a tenth of the time; the lowest of them with all harmonics; and
the search follows the peaks of the lowest of these.
"""

import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import qmc

from vanelock.commands.fit.parameters import (
    FitParameter,
    bounds_of,
    on_bounds,
    starts_of,
    values_of,
)
from vanelock.commands.optimise.objective import Functions, Minimax, Peaks, minimax
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.pipeline.progress import Listener, Trial, silent

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
_Follow = Callable[[Floats], Functions | None]
"""Functions of x, of peaks; None where there is none."""
TRIALS = 10
"""Of a search, before any is known."""


@dataclass(frozen=True)
class FrontPoint:
    """Values of which neither peak nor wear becomes less without the other becoming more.

    Attributes
    ----------
    value : (p,) float
    peak : float
        The largest, m.
    wear : float
        The most worn at one of the peaks that count, m³/s.
    settled : bool
        Whether no step promised less.
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
    held : tuple of bool
        Whether each parameter lies on a bound.
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
    held: tuple[bool, ...]
    of: str = "largest peak"
    front: tuple[FrontPoint, ...] = ()


@dataclass
class Progress:
    """Counts the places that are tried and reports them to a listener.

    Attributes
    ----------
    listener : callable
    likely : int
        How many places there will be, as far as is known.
    name, unit, scale : str, str, float
        What is to be small, the unit it is reported in, how many of which one of the functions is.
    trials : int
        Those so far.
    least : float
        Smallest largest function so far.
    """

    listener: Listener
    likely: int
    name: str = "largest peak"
    unit: str = "um"
    scale: float = 1e6
    trials: int = 0
    least: float = np.inf

    def __post_init__(self) -> None:
        """Begin to measure time."""
        self._began = time.perf_counter()

    def __call__(self, peaks: _Follow, x: Floats) -> Functions | None:
        """Try a place."""
        found = peaks(x)
        size = np.inf if found is None else found.largest
        self.trials, self.least = self.trials + 1, min(self.least, size)
        total = max(self.trials, self.likely)
        left = (time.perf_counter() - self._began) / self.trials * (total - self.trials)
        sizes = self.scale * size, self.scale * self.least
        self.listener(Trial(self.trials, *sizes, self.unit, total, left, self.name))
        return found


def optimum(peaks: Peaks, starts: int = 0, listener: Listener = silent) -> Optimum:
    """The smallest largest peak: from the parameters' own values, or the lowest of other starts."""
    parameters = peaks.parameters
    low, high = bounds_of(parameters)
    own = starts_of(parameters)
    single, progress = peaks.with_one_harmonic(), Progress(listener, starts)
    places = spread(low, high, starts) if starts else np.zeros((0, len(own)))
    begins = [(_swept(progress, single, x), x, single.known) for x in places]
    progress = Progress(listener, 1 + LOWEST * bool(starts) + TRIALS)
    tried = [(_swept(progress, peaks, own), own, peaks.known)]
    for _, x, known in sorted(begins, key=lambda trial: trial[0])[:LOWEST]:
        peaks.led_by(known, x)
        found = progress(peaks, x)
        tried.append((np.inf if found is None else found.largest, x, peaks.known))
    _, begin, peaks.known = min(tried, key=lambda trial: trial[0])
    peaks.place = begin
    chosen = searched(peaks, peaks.afresh, parameters, begin, progress)
    if chosen is None:
        raise InputError("optimise: no peak lies in the range of frequencies at any start")
    if not chosen.settled:
        peaks.known = []
    there = peaks(chosen.x) or chosen.functions
    top = there.largest
    order = [each for each in peaks.known if each.amplitude > (1 - EQUAL) * top]
    ends = [each.low for each in parameters], [each.high for each in parameters]
    return Optimum(
        parameters=tuple(parameters),
        value=np.clip(values_of(parameters, chosen.x), *ends),
        before=tried[0][0],
        after=top,
        frequencies=np.array([each.solution.omega for each in order]) / (2 * np.pi),
        amplitudes=np.array([each.amplitude for each in order]),
        trials=progress.trials,
        solved=peaks.solved,
        screened=single.solved,
        settled=chosen.settled,
        held=on_bounds(parameters, chosen.x, ON_BOUND),
    )


def searched(
    followed: _Follow,
    afresh: _Follow,
    parameters: Sequence[FitParameter],
    begin: Floats,
    progress: Progress,
) -> Minimax | None:
    """The search from a place, whose peaks are known; None where it has none.

    Peaks are followed from the place before, and afresh those of the whole range.
    """
    x, bounds = begin, bounds_of(parameters)
    for _ in range(ROUNDS):
        found = minimax(lambda values: progress(followed, values), x, bounds, TOLERANCE)
        if found is None:
            return None
        swept = afresh(found.x)
        if swept is None or swept.largest < (1 + HIGHER) * found.functions.largest:
            return found
        x = found.x
    # A higher peak was met each time: of the start and the last place, the lower one.
    ends = [(place, there) for place in (begin, x) if (there := afresh(place)) is not None]
    if not ends:
        return None
    place, there = min(ends, key=lambda trial: trial[1].largest)
    return Minimax(place, there, False)


def _swept(progress: Progress, peaks: Peaks, x: Floats) -> float:
    """The largest peak at a place, m, of the whole range; infinite where there is none."""
    peaks.known = []
    found = progress(peaks, x)
    return np.inf if found is None else found.largest


def spread(low: Floats, high: Floats, count: int) -> Floats:
    """(count, p) places within bounds, of a Sobol sequence behind its corner and its middle."""
    sequence = qmc.Sobol(len(low), scramble=False)
    sequence.fast_forward(2)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The balance properties", UserWarning)
        return np.asarray(low + (high - low) * sequence.random(count))
