"""The largest peak that undetermined static friction allows, made the smallest.

With J(x) = max_s A(x, s), s the places of sliders that stick for good, each peak A(x, s) of places
that bounds have led to is at most J, and equal to it where they were found. So the largest of
those known is made the smallest, the bound J is looked for there, and where it is higher its places
are added (outer approximation; B. C. Eaves and W. I. Zangwill, SIAM J. Control 9 (1971) 529), until
no place of sliders is found with a peak that none of the known ones has.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vanelock.analyses.bounds import HIGH
from vanelock.commands.fit.parameters import Progress, starts_of, values_of, x_of
from vanelock.commands.optimise.objective import Functions, Peaks
from vanelock.commands.optimise.search import TRIALS, Optimum, searched
from vanelock.common.arrays import Floats
from vanelock.nonlinear import PeakBounds
from vanelock.pipeline.progress import Listener, silent

AGREE = 1e-2
"""Relative difference between bound and known peaks that ends the search; bounds are that exact."""
ADDED = 8
"""Places of sliders, at most."""
BOUND = "upper bound"


def least_bound(
    peaks: Peaks,
    begun: Optimum,
    bounds: Callable[[Floats], PeakBounds],
    listener: Listener = silent,
) -> Optimum:
    """Where the upper bound of the peak is smallest."""
    x = x_of(peaks.parameters, begun.value)
    first = bounds(starts_of(peaks.parameters))
    before, solved = float(first.amplitude[HIGH]), first.solved
    places, largest = [peaks], begun.after
    progress = Progress(listener, TRIALS, BOUND)
    best, settled = None, False

    def together(x: Floats, afresh: bool = False) -> Functions | None:
        parts = [each(x, afresh) for each in places]
        known = [each for each in parts if each is not None]
        if len(known) < len(parts):
            return None
        return Functions(*map(np.concatenate, zip(*known, strict=True)))

    for _ in range(ADDED):
        there = bounds(x)
        solved += there.solved
        if best is None or there.amplitude[HIGH] < best[1].amplitude[HIGH]:
            best = x, there
        if there.amplitude[HIGH] < (1 + AGREE) * largest:
            settled = True
            break
        places.append(peaks.assembled_at(there.slider[HIGH]))
        found = searched(together, peaks.parameters, x, progress)
        if found is None:
            break
        x, largest = found.x, found.functions.largest
    assert best is not None
    x, there = best
    return replace(
        begun,
        value=values_of(peaks.parameters, x),
        before=before,
        after=float(there.amplitude[HIGH]),
        frequencies=there.frequency[HIGH:],
        amplitudes=there.amplitude[HIGH:],
        trials=begun.trials + progress.trials,
        solved=solved + sum(each.solved for each in places),
        settled=settled,
        of=BOUND,
    )
