"""Sweeps of many cases: a band of percentiles and a few named cases instead of every one."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from vanelock.input.cases.sweep import SAMPLE
from vanelock.quantities.run_result import RunResult
from vanelock.render import Band
from vanelock.stages.plan import Planned
from vanelock.stages.response.summary import Peak

Floats = NDArray[np.float64]
MANY = 24
"""More cases than that are drawn as a band; each has a line of its own otherwise."""
DETAILED = 8
"""More cases than that have no pictures of their own but for a few."""
PERCENT = (5, 25, 50, 75, 95)
POINTS = 400
"""Frequencies of a band, where the cases' own differ."""
SHARE = 0.5
"""Of the cases, how many a band needs at a frequency."""


def lowest_first(peaks: Mapping[str, Peak]) -> list[str]:
    """Cases by the height of their peaks; of equal ones the last case counts as the highest."""
    return sorted(peaks, key=lambda name: peaks[name].amplitude)


def named(run: RunResult) -> list[Planned]:
    """Cases with a peak that have pictures of their own, in their order.

    All if they are few; of samples those of the lowest, the middle and the largest peak, of other
    sweeps the first and the last.
    """
    peaks = run.peaks
    cases = [each for each in run.planned if each.case.name in peaks]
    if len(cases) <= DETAILED:
        return cases
    if not sampled(run):
        return [cases[0], cases[-1]]
    order = lowest_first(peaks)
    chosen = order[0], order[len(order) // 2], order[-1]
    return [each for each in cases if each.case.name in chosen]


def sampled(run: RunResult) -> bool:
    """Whether the cases are samples of keys that scatter."""
    return next(iter(run.cases)).startswith(f"{SAMPLE}=")


def in_words(run: RunResult) -> str:
    """Which cases are named, in words."""
    if sampled(run):
        return "the lowest, the middle and the largest peak"
    return "the first and the last case"


def drawn_alone(run: RunResult) -> list[Planned]:
    """Cases with a curve of their own."""
    return list(run.planned) if len(run.planned) <= MANY else named(run)


def band(run: RunResult) -> Band | None:
    """Percentiles of the curves of many cases; None where each has its own."""
    if len(run.planned) <= MANY:
        return None
    curves = []
    for frequency, amplitude, converged in (case.drawn for case in run.cases.values()):
        order = np.argsort(frequency, kind="stable")
        solved = order[converged[order]]
        curves.append((frequency[solved], amplitude[solved]))
    curves = [each for each in curves if len(each[0])]
    if not curves:
        return None
    first = curves[0][0]
    if all(np.array_equal(f, first) for f, _ in curves):
        at = first
    else:
        at = np.linspace(min(f[0] for f, _ in curves), max(f[-1] for f, _ in curves), POINTS)
    table = np.array([np.interp(at, f, a, left=np.nan, right=np.nan) for f, a in curves])
    enough = np.isfinite(table).sum(axis=0) >= SHARE * len(run.planned)
    at, table = at[enough], table[:, enough]
    if not len(at):
        return None
    kind = "samples" if sampled(run) else "cases"
    return Band(at, np.nanpercentile(table, PERCENT, axis=0), f"{len(run.planned)} {kind}")
