"""Peaks of keys that scatter, and of segments that are not alike, as pictures and as CSV."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock import render
from vanelock.input.cases.names import of_case, slug
from vanelock.input.messages import unit_of
from vanelock.quantities.curves_and_fields import RunData
from vanelock.quantities.scatter import Scattered, percentile_table, sample_columns
from vanelock.report import Picture
from vanelock.stages.assessment.unlike import UnlikeRings
from vanelock.stages.plan import Planned

TITLE = "Scatter of the peaks"
RINGS = "Rings of unlike segments"
"""Title of the pictures of these."""


def scatters(run_data: RunData, found: Scattered) -> Picture:
    """Distribution of the peaks, and the peaks against what scatters."""
    monitor, known = run_data.shown.monitor.name, found.known
    shows = [[each.response.key, each.case.name] for each in run_data.planned]
    shows += [[monitor, run_data.given.name, *found.keys], found.value.tolist()]
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
    title = f"{run_data.given.name}: {TITLE.lower()}"
    path = run_data.output_files.draw(
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
    data = run_data.table("figures/scatter.csv", shows, lambda: sample_columns(found), notes)
    table = run_data.table(
        "figures/percentiles.csv", shows, percentile_table(found, monitor).by_head, notes
    )
    caption = (
        "Above: share of the samples whose peak, and its frequency, lies below a value; dots are "
        "percentiles, bars their confidence limits. Below: the same against each key that "
        "scatters; a rank correlation near 1 or -1 says that the scatter comes from there."
    )
    return Picture(path, TITLE, caption, (data, table))


def unlike_rings(run_data: RunData, each: Planned) -> list[Picture]:
    """The worst of a case's rings of unlike segments, and the numbers of all."""
    name = each.case.name
    if each.unlike is None or (place := run_data.stages.get(each.unlike).place) is None:
        return []
    found, (ring, segment) = run_data.stages.get(each.unlike), place
    curve, worst, drawn = run_data.shown.curve[name], found.worst, len(found.largest)
    title = f"Ring of unlike segments{of_case(name)}"
    which = f"the worst of {drawn} rings; " if drawn > 1 else ""
    subtitle = (
        f"{which}segment {segment + 1} vibrates {found.amplification[place]:.3f} times as much "
        f"as alike segments; {run_data.shown.monitor.name}"
    )
    shows = [each.unlike.key, each.response.key, title, subtitle]
    known = np.where(worst.converged[:, None], worst.amplitude, np.nan)
    path = run_data.output_files.draw(
        f"figures/unlike_{slug(name)}.png",
        shows,
        lambda path: render.segments_picture(
            path, worst.frequency, known, curve[:2], found.amplification[ring], title, subtitle
        ),
    )
    notes = [f"{title}: largest amplitude of every segment; {run_data.shown.monitor.name}"]
    data = run_data.table(
        f"figures/unlike_{slug(name)}.csv", shows, lambda: _ring_columns(found), notes
    )
    caption = (
        f"The ring with the largest vibration{of_case(name)}. Above: response of all its segments, "
        "and what they would do if all were alike. Below: largest amplitude of each segment over "
        "the peak of alike ones. The table has all rings."
    )
    return [Picture(path, RINGS, caption, (data,))]


def _ring_columns(found: UnlikeRings) -> dict[str, ArrayLike]:
    rings, sectors = found.amplitude.shape
    return {
        "ring": np.repeat(np.arange(rings) + 1, sectors),
        "segment": np.tile(np.arange(sectors) + 1, rings),
        "amplitude (µm)": 1e6 * found.amplitude.ravel(),
        "frequency (Hz)": found.frequency.ravel(),
        "amplification (-)": found.amplification.ravel(),
    }


def _shown(key: str, value: NDArray[np.float64]) -> tuple[str, NDArray[np.float64]]:
    """A key with its unit, and its samples; lengths in µm or mm."""
    unit = unit_of(key)
    if unit == "m":
        small = float(np.abs(value).max()) < 1e-3
        value, unit = (1e6 * value, "µm") if small else (1e3 * value, "mm")
    return f"{key} ({unit})" if unit else key, value
