"""Strain of the gauges on the vane: at the peaks, and over frequency."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vanelock import report
from vanelock.analyses.analysis import Analysis
from vanelock.common.tables import Column, Table, heads
from vanelock.input.cases.names import words

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, RunResult

MOST = 6
"""Gauges whose curves are on the page."""


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """Strain of each gauge at the peak of each case."""
    columns = (
        *heads("case", "gauge"),
        Column("amplitude", "µm/m"),
        Column("mean", "µm/m"),
        Column("at", "Hz", ".6g", "frequency_hz"),
    )
    rows = []
    for name, case in cases.items():
        strain, peak = case.strain, case.peak
        if strain is None or peak is None:
            continue
        mean = strain.harmonics[peak.point, 0].real
        for row in zip(strain.gauges.names, strain.amplitude[peak.point], mean, strict=True):
            rows.append((name, *row, peak.frequency))
    if rows:
        notes = ("at the peak of the monitored displacement; amplitude: half the peak-to-peak",)
        yield Table("Strain gauges", columns, rows, notes, "gauges")


def _page(run: "RunResult") -> "list[report.Block]":
    """Strain over frequency of every gauge in the cases that are looked into."""
    traces, many = [], len(run.looked_into) > 1
    names: tuple[str, ...] = ()
    for case, found in run.looked_into.items():
        if (strain := found.strain) is None:
            continue
        response, names = found.response, strain.gauges.names[:MOST]
        order = np.argsort(response.frequency, kind="stable")
        amplitude = np.where(response.converged[:, None], 1e6 * strain.amplitude, np.nan)
        for i, name in enumerate(names):
            label = f"gauge {i + 1}" + (f", {words(case)}" if many else "")
            curve = response.frequency[order], amplitude[order, i]
            traces.append(report.Trace(*curve, label, hover=name))
    if not traces:
        return []
    where = "; ".join(f"gauge {i + 1}: {text}" for i, text in enumerate(names))
    caption = f"Half the peak-to-peak of the strain that the gauges read. {where}."
    return [report.Plot(traces, "frequency (Hz)", "strain (µm/m)", "Strain gauges", caption)]


GAUGES: Analysis[Any, Any] = Analysis(
    key="gauges", title="strain gauges", looked_into=True, open=False, page=_page, tables=_tables
)
