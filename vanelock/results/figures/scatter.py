"""Peaks of keys that scatter, as pictures and as CSV."""

import numpy as np
from numpy.typing import NDArray

from vanelock import render
from vanelock.input.settings import unit_of
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.scatter import Scattered, percentile_table, sample_columns
from vanelock.report import Picture

TITLE = "Scatter of the peaks"


def scatters(run: RunResult, found: Scattered) -> Picture:
    """Distribution of the peaks, and the peaks against what scatters."""
    monitor, known = run.monitor.name, found.known
    shows = [[each.response.key, each.case.name] for each in run.planned]
    shows += [[monitor, run.given.name, *found.keys], found.value.tolist()]
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
    title = f"{run.given.name}: {TITLE.lower()}"
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
    data = run.table("figures/scatter.csv", shows, lambda: sample_columns(found), notes)
    table = run.table(
        "figures/percentiles.csv", shows, percentile_table(found, monitor).by_head, notes
    )
    caption = (
        "Above: share of the samples whose peak, and its frequency, lies below a value; dots are "
        "percentiles, bars their confidence limits. Below: the same against each key that "
        "scatters; a rank correlation near 1 or -1 says that the scatter comes from there."
    )
    return Picture(path, TITLE, caption, (data, table))


def _shown(key: str, value: NDArray[np.float64]) -> tuple[str, NDArray[np.float64]]:
    """A key with its unit, and its samples; lengths in µm or mm."""
    unit = unit_of(key)
    if unit == "m":
        small = float(np.abs(value).max()) < 1e-3
        value, unit = (1e6 * value, "µm") if small else (1e3 * value, "mm")
    return f"{key} ({unit})" if unit else key, value
