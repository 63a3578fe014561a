"""Percentiles of the peaks of keys that scatter, and which key the scatter comes from.

Percentiles are interpolated between the samples, median-unbiased (Hyndman and Fan, Am. Stat. 50
(1996) 361, type 8). Their confidence limits are order statistics, by the binomial distribution of
how many samples lie below (Conover, Practical Nonparametric Statistics, 3.2): of any distribution
of the peaks, and for samples drawn independently; those of a Latin hypercube scatter less. A key's
part is measured by Spearman's rank correlation, whose limits are Fisher's with Bonett and Wright's
variance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock import render, report
from vanelock.analyses.analysis import Analysis
from vanelock.common.arrays import Booleans, Floats
from vanelock.common.product import Product
from vanelock.common.tables import Column, Table, counted

if TYPE_CHECKING:
    from vanelock.analyses.analysis import RunResult, Summary
    from vanelock.input.cases.sweep import Case

TITLE = "Scatter of the peaks"
PERCENT = (5.0, 25.0, 50.0, 75.0, 95.0)
CONFIDENCE = 0.95
FEWEST = 10
"""Samples below which nothing is reported."""
COARSE = 0.2
"""Of the spread from the 5th to the 95th percentile, the resolution that is noted."""


@dataclass(frozen=True)
class Scattered(Product):
    """Peaks of n samples of k keys, p percentiles of them.

    Attributes
    ----------
    case : tuple of n str
        Names of the samples.
    keys : tuple of k str
        What scatters.
    value : (n, k) float
        The samples, SI.
    amplitude, frequency : (n,) float
        Peaks; NaN where a case failed or no point converged.
    percent : (p,) float
        Which percentiles.
    amplitude_percentile, frequency_percentile : (p, 3) float
        Percentile and its confidence limits; NaN where the samples are too few to say.
    amplitude_correlation, frequency_correlation : (k, 3) float
        Rank correlation with each key and its confidence limits.
    confidence : float
        Of the limits.
    spacing : float
        Of the frequencies at the peaks where the study gives them, the median, Hz; else 0.
    """

    case: tuple[str, ...]
    keys: tuple[str, ...]
    value: Floats
    amplitude: Floats = field(metadata={"unit": "m"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    percent: Floats
    amplitude_percentile: Floats = field(metadata={"unit": "m"})
    frequency_percentile: Floats = field(metadata={"unit": "Hz"})
    amplitude_correlation: Floats
    frequency_correlation: Floats
    confidence: float
    spacing: float = field(metadata={"unit": "Hz"})

    @property
    def known(self) -> Booleans:
        """(n,) samples with a peak."""
        return np.isfinite(self.amplitude)


def scattered(
    every: "Sequence[Case]", summaries: "Sequence[Summary]", spacings: Sequence[float] = ()
) -> Scattered | None:
    """Percentiles over all cases of a study; None where too few have a peak."""
    keys = tuple(every[0].values)
    peaks = {each.case: each.peak for each in summaries if each.peak is not None}
    if len(peaks) < FEWEST:
        return None
    both = [peaks.get(case.name) for case in every]
    amplitude = np.array([np.nan if peak is None else peak.amplitude for peak in both])
    frequency = np.array([np.nan if peak is None else peak.frequency for peak in both])
    value = np.array([[float(case.values[key]) for key in keys] for case in every])
    some = np.isfinite(amplitude)
    return Scattered(
        case=tuple(case.name for case in every),
        keys=keys,
        value=value,
        amplitude=amplitude,
        frequency=frequency,
        percent=np.array(PERCENT),
        amplitude_percentile=_percentiles(amplitude[some]),
        frequency_percentile=_percentiles(frequency[some]),
        amplitude_correlation=_correlations(value[some], amplitude[some]),
        frequency_correlation=_correlations(value[some], frequency[some]),
        confidence=CONFIDENCE,
        spacing=float(np.median(spacings)) if len(spacings) else 0.0,
    )


def spacing(frequency: Floats, index: int) -> float:
    """Distance from a frequency to the farther of its neighbours, Hz; 0 of one alone."""
    apart = np.diff(np.sort(frequency))
    place = int((frequency < frequency[index]).sum())
    return float(apart[max(place - 1, 0) : place + 1].max(initial=0.0))


def _percentiles(sample: Floats) -> Floats:
    """(p, 3) percentiles of a sample with their confidence limits, NaN where there are none."""
    from scipy.stats import quantile_test

    rows = []
    for p in np.array(PERCENT) / 100:
        value = float(np.quantile(sample, p, method="median_unbiased"))
        limits = quantile_test(sample, q=value, p=p).confidence_interval(CONFIDENCE)
        rows.append((value, float(limits.low), float(limits.high)))
    return np.array(rows)


def _correlations(value: Floats, response: Floats) -> Floats:
    """(k, 3) rank correlation of a response with each column, with its confidence limits."""
    from scipy.stats import norm, spearmanr

    rows = []
    for column in value.T:
        if np.ptp(column) == 0 or np.ptp(response) == 0:
            rows.append((np.nan, np.nan, np.nan))
            continue
        r = float(spearmanr(column, response).statistic)
        z = np.arctanh(np.clip(r, -1 + 1e-12, 1 - 1e-12))
        wide = float(norm.ppf(0.5 + CONFIDENCE / 2)) * np.sqrt(
            (1 + r * r / 2) / (len(response) - 3)
        )
        rows.append((r, float(np.tanh(z - wide)), float(np.tanh(z + wide))))
    return np.array(rows)


def _percentile_table(scattered: Scattered, monitor: str) -> Table:
    """Percentiles of amplitude and frequency."""
    columns = (
        Column("percentile", form=".3g", key="percent"),
        Column("peak", "µm", key="peak_um"),
        Column("peak, low", "µm", key="peak_low_um"),
        Column("peak, high", "µm", key="peak_high_um"),
        Column("frequency", "Hz", ".6g", "frequency_hz"),
        Column("frequency, low", "Hz", ".6g", "frequency_low_hz"),
        Column("frequency, high", "Hz", ".6g", "frequency_high_hz"),
    )
    rows = np.column_stack(
        (scattered.percent, scattered.amplitude_percentile, scattered.frequency_percentile)
    )
    known, every = int(scattered.known.sum()), len(scattered.case)
    notes = [
        f"of {known} samples; low, high: {100 * scattered.confidence:g} % confidence, - where that "
        "takes more samples"
    ]
    if known < every:
        notes.append(f"left out: {counted(every - known, 'sample')} without a peak")
    spread = float(scattered.frequency_percentile[-1, 0] - scattered.frequency_percentile[0, 0])
    if scattered.spacing > COARSE * spread:
        notes.append(
            f"frequencies are resolved to {scattered.spacing:.3g} Hz alone, the spacing of points, "
            f"and scatter by {spread:.3g} Hz: without response.points and "
            "response.frequencies each peak is located"
        )
    return Table(f"Scatter of the peaks of {monitor}", columns, rows.tolist(), notes, "percentiles")


def _sensitivity_table(scattered: Scattered) -> Table:
    """Rank correlation of amplitude and frequency with each key."""
    columns = (
        Column("key"),
        Column("with the peak", form="+.2f", key="peak"),
        Column("from", form="+.2f", key="peak_low"),
        Column("to", form="+.2f", key="peak_high"),
        Column("with its frequency", form="+.2f", key="frequency"),
        Column("from", form="+.2f", key="frequency_low"),
        Column("to", form="+.2f", key="frequency_high"),
    )
    correlation = np.hstack((scattered.amplitude_correlation, scattered.frequency_correlation))
    rows = [(key, *own) for key, own in zip(scattered.keys, correlation.tolist(), strict=True)]
    notes = ("rank correlation: 1 rises with the key, -1 falls, 0 has nothing to do with it",)
    return Table("What the scatter comes from", columns, rows, notes, "sensitivity")


def _run_tables(run: "RunResult") -> Iterator[Table]:
    """How far the peaks scatter, and what with, where keys scatter."""
    if run.scattered is not None:
        yield _percentile_table(run.scattered, run.monitor.name)
        yield _sensitivity_table(run.scattered)


def _page(run: "RunResult") -> "list[report.Block]":
    """The same on the page."""
    return [*_run_tables(run), *(e for e in run.pictures if e.section == "scatter")]


def _run_pictures(run: "RunResult") -> "Iterator[report.Picture]":
    """Distribution of the peaks, and the peaks against what scatters."""
    if (found := run.scattered) is None:
        return
    monitor, known = run.monitor.name, found.known
    shows = [[each.key_at("response"), each.name] for each in run.cases.values()]
    shows += [[monitor, run.problem.name, *found.keys], found.value.tolist()]
    keys = [_shown(key, found.value[known, i]) for i, key in enumerate(found.keys)]
    panels = [
        render.ScatterPanel(
            "peak (µm)",
            1e6 * found.amplitude[known],
            1e6 * found.amplitude_percentile,
            found.amplitude_correlation[:, 0],
        ),
        render.ScatterPanel(
            "its frequency (Hz)",
            found.frequency[known],
            found.frequency_percentile,
            found.frequency_correlation[:, 0],
        ),
    ]
    title = f"{run.problem.name}: {TITLE.lower()}"
    path = run.output_files.draw(
        "figures/scatter.png",
        shows,
        lambda path: render.scatter_picture(
            path,
            keys,
            panels,
            found.percent.tolist(),
            title,
            f"{known.sum()} samples; {monitor}; bars: {100 * found.confidence:g} % confidence",
        ),
    )
    notes = [f"{title}, {monitor}: half the peak-to-peak"]
    samples: dict[str, ArrayLike] = {
        "case": list(found.case),
        **{f"{key} (SI)": found.value[:, i] for i, key in enumerate(found.keys)},
        "peak (µm)": 1e6 * found.amplitude,
        "frequency (Hz)": found.frequency,
    }
    data = run.table("figures/scatter.csv", shows, lambda: samples, notes)
    table = run.table(
        "figures/percentiles.csv", shows, _percentile_table(found, monitor).by_head, notes
    )
    caption = (
        "Above: share of the samples whose peak, and its frequency, lies below a value; dots are "
        "percentiles, bars their confidence limits. Below: the same against each key that "
        "scatters; a rank correlation near 1 or -1 says that the scatter comes from there."
    )
    yield report.Picture(path, TITLE, caption, (data, table))


def _shown(key: str, value: Floats) -> tuple[str, Floats]:
    """A key with its unit, and its samples; lengths in µm or mm."""
    from vanelock.input.settings import unit_of

    unit = unit_of(key)
    if unit == "m":
        small = float(np.abs(value).max()) < 1e-3
        value, unit = (1e6 * value, "µm") if small else (1e3 * value, "mm")
    return f"{key} ({unit})" if unit else key, value


SCATTER: Analysis[Any, Scattered] = Analysis(
    key="scatter",
    title="scatter",
    looked_into=True,
    page=_page,
    run_tables=_run_tables,
    run_pictures=_run_pictures,
)
