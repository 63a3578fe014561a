"""The peak of a resonance along a parameter over decades, with its least."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from vanelock.common.errors import InputError
from vanelock.render import style


@dataclass(frozen=True)
class RidgeLine:
    """Peaks along a parameter.

    Attributes
    ----------
    parameter : (p,) float
        In the unit of the axis.
    amplitude : (p,) float
        m; NaN where it is not known.
    label : str
    best : (float, float) or None
        Parameter and amplitude [m] of the least.
    """

    parameter: ArrayLike
    amplitude: ArrayLike
    label: str
    best: tuple[float, float] | None = None


@dataclass(frozen=True)
class RidgePanel:
    """Axes of one parameter.

    Attributes
    ----------
    xlabel : str
    lines : sequence of RidgeLine
    limits : sequence of (str, float)
        Amplitudes [m] of the linear limits, and what they are called.
    marked : float or None
        The study's own value.
    """

    xlabel: str
    lines: Sequence[RidgeLine]
    limits: Sequence[tuple[str, float]] = ()
    marked: float | None = None


def ridge_picture(
    path: style.PathLike, panels: Sequence[RidgePanel], title: str, monitor: str = ""
) -> Path:
    """Draw peaks along one or two parameters, amplitudes and parameters on logarithmic axes.

    Parameters
    ----------
    path : path
        PNG file to write.
    panels : sequence of RidgePanel
        One or two.
    title : str
    monitor : str
        What is monitored.

    Raises
    ------
    InputError
        If there are no or more than two panels, or the file cannot be written.
    """
    if not 1 <= len(panels) <= 2:
        raise InputError(f"ridges: given {len(panels)} panels: allowed are 1 and 2")
    with style.applied():
        figure = style.figure(6.2, title, f"Monitored: {monitor}" if monitor else "")
        width = 10.6 / len(panels) - 0.45
        for i, panel in enumerate(panels):
            axes = style.axes(figure, 0.95 + i * (width + 0.75), 0.8, width, 3.7)
            _panel(axes, panel)
            axes.set_ylabel("peak amplitude (µm)" if i == 0 else "")
        return style.write(figure, path)


def _panel(axes: Axes, panel: RidgePanel) -> None:
    axes.set(xscale="log", yscale="log", xlabel=panel.xlabel)
    for line, colour in zip(panel.lines, style.series(len(panel.lines)), strict=True):
        x, y = np.asarray(line.parameter, float), 1e6 * np.asarray(line.amplitude, float)
        label = line.label
        if line.best is not None:
            label += f": least {style.number(1e6 * line.best[1])} µm at {line.best[0]:.3g}"
        axes.plot(x, y, color=colour, lw=2.2, label=label)
        if line.best is not None:
            axes.plot(line.best[0], 1e6 * line.best[1], "o", ms=8, mfc="white", mec=colour, mew=1.8)
    for (name, amplitude), dashes in zip(panel.limits, ("--", ":"), strict=False):
        axes.axhline(1e6 * amplitude, color=style.GREY, lw=1.4, ls=dashes, label=name)
    if panel.marked is not None:
        axes.axvline(panel.marked, color=style.GREY, lw=1, ls=(0, (1, 3)), label="this study")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1.02), fontsize=9.5, ncols=2, borderpad=0)
