"""The largest peak that undetermined static friction allows, made the smallest.

With J(x) = max_s A(x, s), s the places of sliders that stick for good, each peak A(x, s) of places
that bounds have led to is at most J, and equal to it where they were found. So the largest of
those known is made the smallest, the bound J is looked for there, and where it is higher its places
are added (outer approximation; B. C. Eaves and W. I. Zangwill, SIAM J. Control 9 (1971) 529), until
no place of sliders is found with a peak that none of the known ones has.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from vanelock.analyses.bounds import HIGH
from vanelock.commands.fit.parameters import FitParameter
from vanelock.commands.optimise.peaks import Functions, Peaks
from vanelock.commands.optimise.search import TRIALS, Optimum, Progress, on_bounds, searched
from vanelock.common.arrays import Floats
from vanelock.nonlinear import PeakBounds
from vanelock.pipeline.progress import Listener, silent

AGREE = 1e-2
"""Relative difference between bound and known peaks that ends the search; bounds are that exact."""
ADDED = 8
"""Places of sliders, at most."""
BOUND = "upper bound"


class _WorstPeaks:
    """The peaks of several places of sliders at once.

    Attributes
    ----------
    every : list of Peaks
        Of each place of sliders.
    """

    def __init__(self, every: list[Peaks]) -> None:
        """Begin with some."""
        self.every = every

    @property
    def parameters(self) -> Sequence[FitParameter]:
        """What varies."""
        return self.every[0].parameters

    def __call__(self, x: Floats) -> Functions | None:
        """All that are followed to x."""
        return _together([each(x) for each in self.every])

    def afresh(self, x: Floats) -> Functions | None:
        """All that the whole range has."""
        return _together([each.afresh(x) for each in self.every])


def _together(found: Sequence[Functions | None]) -> Functions | None:
    """All functions; None if one is missing."""
    known = [each for each in found if each is not None]
    if len(known) < len(found):
        return None
    value, gradient = (
        np.concatenate([getattr(each, name) for each in known]) for name in ("value", "gradient")
    )
    return Functions(value, gradient)


def least_bound(
    peaks: Peaks,
    begun: Optimum,
    bounds: Callable[[Floats], PeakBounds],
    listener: Listener = silent,
) -> Optimum:
    """Where the upper bound of the peak is smallest."""
    x = np.array([p.inner(v) for p, v in zip(peaks.parameters, begun.value, strict=True)])
    own = np.array([each.inner(each.start) for each in peaks.parameters])
    first = bounds(own)
    before, solved = float(first.amplitude[HIGH]), first.solved
    worst, largest = _WorstPeaks([peaks]), begun.after
    progress = Progress(listener, TRIALS, BOUND)
    best, settled = None, False
    for _ in range(ADDED):
        there = bounds(x)
        solved += there.solved
        if best is None or there.amplitude[HIGH] < best[1].amplitude[HIGH]:
            best = x, there
        if there.amplitude[HIGH] < (1 + AGREE) * largest:
            settled = True
            break
        worst.every.append(peaks.assembled_at(there.slider[HIGH]))
        found = searched(worst, x, progress)
        if found is None:
            break
        x, largest = found.x, found.functions.largest
    assert best is not None
    x, there = best
    return replace(
        begun,
        value=np.array(list(peaks.values(x).values())),
        before=before,
        after=float(there.amplitude[HIGH]),
        frequencies=there.frequency[HIGH:],
        amplitudes=there.amplitude[HIGH:],
        trials=begun.trials + progress.trials,
        solved=solved + sum(each.solved for each in worst.every),
        settled=settled,
        held=tuple(on_bounds(peaks.parameters, x)),
        of=BOUND,
    )
