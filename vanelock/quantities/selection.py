"""Sweeps of many cases: a band of percentiles and a few named cases instead of every one."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vanelock.input.cases.sweep import SAMPLE
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.run_result import RunResult
from vanelock.render import Band
from vanelock.stages.response.summary import Peak

MANY = 24
"""More cases than that are drawn as a band; each has a line of its own otherwise."""
DETAILED = 8
"""More cases than that have no pictures of their own but for a few, nor are looked into."""
PERCENT = (5, 25, 50, 75, 95)
POINTS = 400
"""Frequencies of a band, where the cases' own differ."""
SHARE = 0.5
"""Of the cases, how many a band needs at a frequency."""


def with_details(case: CaseResult) -> CaseResult:
    """A case with all numbers at its peak, and what moves and checks it made."""
    for place in ("audit", "sensitivities"):
        if place in case.products:
            case.products.get(place)
    numbers = {
        **energies(case),
        "bandwidth_ratio": (case.bandwidth, "1"),
        "largest_slip": (float(np.nanmax(case.wear.slip, initial=0.0)), "m"),
    }
    if case.margins is not None:
        for analysis in case.analyses:
            if states := [state.stress.governing for state in case.states(analysis)]:
                numbers[analysis.reserve] = (states[-1].reserve, "1")
        m, gauges = case.margins.governing, case.margins.gauges
        numbers |= {
            "alternating_stress": (m.amplitude, "Pa"),
            "mean_stress": (m.mean, "Pa"),
            "goodman_reserve": (m.reserve, "1"),
            "vibration_may_grow": (m.growth, "1"),
            "place": (f"{m.part}, {m.where}", ""),
        }
        if gauges:
            numbers["gauge_alternating_stress"] = ([each.amplitude for each in gauges], "Pa")
            numbers["gauge_mean_stress"] = ([each.mean for each in gauges], "Pa")
            numbers["gauge_goodman_reserve"] = ([each.reserve for each in gauges], "1")
    return replace(case, numbers=numbers, detailed=True)


def energies(case: CaseResult) -> dict[str, Any]:
    """Where the energy goes at a case's peak."""
    b = case.balance
    return {
        "damping_ratio": (b.damping_ratio, "1"),
        "input_work": (b.input, "J"),
        "friction_work": (b.friction, "J"),
        "stored_energy": (b.stored, "J"),
    }


def _lowest_first(peaks: Mapping[str, Peak]) -> list[str]:
    """Cases by the height of their peaks; of equal ones the last case counts as the highest."""
    return sorted(peaks, key=lambda name: peaks[name].amplitude)


def looked_into_names(run: RunResult) -> list[str]:
    """Names of the cases that are looked into, in order.

    All if they are few; of samples those that have pictures, of other sweeps the first, the last
    and those of the extreme peaks.
    """
    peaks = run.peaks
    names = list(peaks)
    if len(names) <= DETAILED:
        return names
    if _sampled(run):
        return [each.name for each in named(run)]
    order = _lowest_first(peaks)
    chosen = names[0], names[-1], order[0], order[-1]
    return [name for name in names if name in chosen]


def named(run: RunResult) -> list[CaseResult]:
    """Cases with a peak that have pictures of their own, in their order.

    All if they are few; of samples those of the lowest, the middle and the largest peak, of other
    sweeps the first and the last.
    """
    peaks = run.peaks
    cases = [each for name, each in run.cases.items() if name in peaks]
    if len(cases) <= DETAILED:
        return cases
    if not _sampled(run):
        return [cases[0], cases[-1]]
    order = _lowest_first(peaks)
    chosen = order[0], order[len(order) // 2], order[-1]
    return [each for each in cases if each.name in chosen]


def _sampled(run: RunResult) -> bool:
    """Whether the cases are samples of keys that scatter."""
    return next(iter(run.cases)).startswith(f"{SAMPLE}=")


def in_words(run: RunResult) -> str:
    """Which cases are named, in words."""
    if _sampled(run):
        return "the lowest, the middle and the largest peak"
    return "the first and the last case"


def drawn_alone(run: RunResult) -> list[CaseResult]:
    """Cases with a curve of their own."""
    return list(run.cases.values()) if len(run.cases) <= MANY else named(run)


def band(run: RunResult) -> Band | None:
    """Percentiles of the curves of many cases; None where each has its own."""
    if len(run.cases) <= MANY:
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
    enough = np.isfinite(table).sum(axis=0) >= SHARE * len(run.cases)
    at, table = at[enough], table[:, enough]
    if not len(at):
        return None
    kind = "samples" if _sampled(run) else "cases"
    return Band(at, np.nanpercentile(table, PERCENT, axis=0), f"{len(run.cases)} {kind}")
