"""Distributions of peaks over keys that scatter; curves of segments that are not alike."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from vanelock.common.arrays import Floats
from vanelock.render import style

_SHOWN: Final = 6  # keys that a figure has room for
_ROW: Final = 2.2  # inches
_GAP: Final = 0.95


@dataclass(frozen=True)
class ScatterPanel:
    """What scatters, or responds.

    Attributes
    ----------
    label : str
        With its unit.
    value : (n,) float
        By sample.
    percentile : (p, 3) float
        Of a response: percentiles with their limits.
    correlation : (k,) float
        Of a response: rank correlation with each key.
    """

    label: str
    value: Floats
    percentile: Floats
    correlation: Floats


def scatter_picture(
    path: style.PathLike,
    keys: Sequence[tuple[str, Floats]],
    responses: Sequence[ScatterPanel],
    percent: Sequence[float],
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw responses' distributions, and each against each key, and return the path.

    Parameters
    ----------
    path : path
        PNG file to write.
    keys : sequence of (str, (n,) float)
        What scatters, with its unit.
    responses : sequence of ScatterPanel
        Two of them: columns of the figure.
    percent : sequence of p float
        Which percentiles.
    title, subtitle : str
        Heading.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    shown = _most(keys, responses)
    rows = 1 + len(shown)
    height = 1.1 + (_ROW + _GAP) * rows
    with style.applied():
        made = style.figure(height, title, subtitle)
        for column, each in enumerate(responses):
            left = 1.0 + 5.7 * column
            bottom = 0.75 + (_ROW + _GAP) * (rows - 1)
            _distribution(style.axes(made, left, bottom, 4.6, _ROW), each, percent)
            for row, i in enumerate(shown):
                bottom = 0.75 + (_ROW + _GAP) * (rows - 2 - row)
                axes = style.axes(made, left, bottom, 4.6, _ROW)
                name, value = keys[i]
                axes.plot(value, each.value, "o", color=style.BLUE, markersize=3.5, alpha=0.6)
                axes.set(xlabel=name, ylabel=each.label)
                axes.margins(0.04)
                text = f"rank correlation {each.correlation[i]:+.2f}"
                axes.set_title(text, fontsize=11, color=style.GREY, loc="right")
        return style.write(made, path)


def _most(keys: Sequence[tuple[str, Floats]], responses: Sequence[ScatterPanel]) -> list[int]:
    """The most influential keys, in their order."""
    strength = np.max([np.abs(np.nan_to_num(each.correlation)) for each in responses], axis=0)
    return sorted(np.argsort(-strength, kind="stable")[:_SHOWN].tolist())


def _distribution(axes: Axes, panel: ScatterPanel, percent: Sequence[float]) -> None:
    """Share of the samples below each value, and the percentiles with their limits."""
    value = np.sort(panel.value)
    share = 100 * (np.arange(len(value)) + 0.5) / len(value)
    axes.plot(value, share, color=style.BLUE, linewidth=1.8)
    for p, (middle, low, high) in zip(percent, panel.percentile, strict=True):
        axes.plot([low, high], [p, p], color=style.VERMILION, linewidth=1.6)
        axes.plot([middle], [p], "o", color=style.VERMILION, markersize=5)
    axes.set(xlabel=panel.label, ylabel="samples below (%)", ylim=(0, 100))
    axes.set_yticks(percent)
    axes.margins(x=0.04)


def segments_picture(
    path: style.PathLike,
    frequency: ArrayLike,
    amplitude: ArrayLike,
    alike: tuple[ArrayLike, ArrayLike],
    amplification: ArrayLike,
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw the curves of all segments, and bars of their largest amplitudes, and return the path.

    Parameters
    ----------
    path : path
        PNG file to write.
    frequency : (p,) float
        Hz.
    amplitude : (p, N) float
        Of every segment, m; NaN where unknown.
    alike : (q,) float, (q,) float
        Frequency and amplitude, Hz and m, were all segments alike.
    amplification : (N,) float
        Largest amplitude of each segment over that of alike ones.
    title, subtitle : str
        Heading and the line under it.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    hertz, moved, ratio = (np.asarray(a, float) for a in (frequency, amplitude, amplification))
    worst = int(np.argmax(np.nan_to_num(ratio)))
    with style.applied():
        figure = style.figure(7.2, title, subtitle)
        upper = style.axes(figure, 1.0, 3.45, 10.4, 2.75)
        upper.plot(hertz, 1e6 * moved, color=style.SKY, linewidth=0.9)
        upper.plot([], [], color=style.SKY, linewidth=0.9, label="segments")
        own = f"segment {worst + 1}, the worst"
        upper.plot(hertz, 1e6 * moved[:, worst], color=style.VERMILION, linewidth=1.8, label=own)
        base = np.asarray(alike[0], float), 1e6 * np.asarray(alike[1], float)
        upper.plot(*base, color=style.BLACK, linewidth=1.4, linestyle="--", label="alike segments")
        upper.set(xlabel="excitation frequency (Hz)", ylabel="amplitude (µm)", ylim=(0, None))
        upper.set_xlim(hertz.min(), hertz.max())
        upper.legend(loc="best")
        lower = style.axes(figure, 1.0, 0.75, 10.4, 1.75)
        colours = [style.VERMILION if i == worst else style.BLUE for i in range(len(ratio))]
        lower.bar(np.arange(len(ratio)) + 1, ratio - 1, bottom=1.0, color=colours, width=0.7)
        lower.axhline(1.0, color=style.BLACK, linewidth=1.0)
        lower.xaxis.set_major_locator(MaxNLocator(16, integer=True))
        lower.set(xlabel="segment", ylabel="amplification (–)", xlim=(0.4, len(ratio) + 0.6))
        lower.grid(False, axis="x")
        return style.write(figure, path)
