"""Error against cost of every setting of a study: a panel for each."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from vanelock.common.errors import InputError
from vanelock.render import style

_COLUMNS: Final = 3
_PANEL: Final = (2.95, 2.15)  # inches
_GAP: Final = (0.95, 1.05)
_LEAST: Final = 1e-7  # errors below it are drawn there


@dataclass(frozen=True)
class MeasuredValue:
    """A value of a setting.

    Attributes
    ----------
    value : str
        In words.
    cost : float
        What it takes, relative to the whole study; > 0.
    amplitude_error, frequency_error : float
        Relative; NaN where not known.
    chosen : bool
        Whether the study has this value.
    joined : bool
        Whether a line joins it with the others, as one of a sequence.
    """

    value: str
    cost: float
    amplitude_error: float
    frequency_error: float
    chosen: bool
    joined: bool = True


@dataclass(frozen=True)
class Panel:
    """A setting: its title and its values from rough to fine."""

    title: str
    values: tuple[MeasuredValue, ...]


def convergence_picture(path: style.PathLike, panels: Sequence[Panel], title: str) -> Path:
    """Draw errors of peak amplitude and frequency against cost, and return the path.

    A filled marker is the value of the study. A value whose error is not known, such as the finest,
    which the others are compared with, is a vertical line at its cost.

    Raises
    ------
    InputError
        If there is no panel, or the file cannot be written.
    """
    if not panels:
        raise InputError("panels: none given: at least one is needed")
    rows = -(-len(panels) // _COLUMNS)
    height = 1.35 + rows * (_PANEL[1] + _GAP[1])
    with style.applied():
        words = "each setting raised alone; errors below 1e-7 are drawn there"
        made = style.figure(height, title, words)
        for i, panel in enumerate(panels):
            row, column = divmod(i, _COLUMNS)
            left = 0.85 + column * (_PANEL[0] + _GAP[0])
            bottom = height - 1.3 - _PANEL[1] - row * (_PANEL[1] + _GAP[1])
            _draw(style.axes(made, left, bottom, *_PANEL), panel)
        _legend(made)
        return style.write(made, path)


def _draw(axes: Axes, panel: Panel) -> None:
    """One setting."""
    axes.set_title(panel.title, fontsize=11.5)
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel("cost", fontsize=10.5)
    axes.set_ylabel("relative error", fontsize=10.5)
    axes.tick_params(labelsize=9.5)
    for colour, marker, name in _KINDS:
        known = [v for v in panel.values if np.isfinite(getattr(v, name)) and v.cost > 0]
        cost = [v.cost for v in known]
        error = [max(getattr(v, name), _LEAST) for v in known]
        axes.plot(cost, error, marker, color=colour, ms=5, mfc="white", zorder=3)
        line = [i for i, v in enumerate(known) if v.joined]
        axes.plot([cost[i] for i in line], [error[i] for i in line], color=colour, lw=1.4)
        own = [i for i, v in enumerate(known) if v.chosen]
        axes.plot(
            [cost[i] for i in own], [error[i] for i in own], marker, color=colour, ms=8, zorder=4
        )
    unknown = [v for v in panel.values if not np.isfinite(v.amplitude_error) and v.cost > 0]
    for value in unknown:
        axes.axvline(value.cost, color=style.GREY, lw=1.0, ls=":")
    axes.margins(x=0.12, y=0.22)
    _scale(axes, [v.cost for v in panel.values if v.cost > 0])
    _label(axes, panel)


def _scale(axes: Axes, costs: Sequence[float]) -> None:
    """Decades and few numbers on both axes; at least a decade of errors."""
    low, high = axes.get_ylim()
    if high < 10 * low:
        axes.set_ylim(low / 3, high * 3)
    if costs and max(costs) < 2 * min(costs):
        axes.set_xlim(min(costs) / 1.6, max(costs) * 1.6)
    left, right = axes.get_xlim()
    few = (1.0, 2.0, 5.0) if right < 30 * left else (1.0,)
    axes.xaxis.set_major_locator(LogLocator(subs=few))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())


def _label(axes: Axes, panel: Panel) -> None:
    """Each value above the highest of its points."""
    for i, value in enumerate(panel.values):
        if value.cost <= 0:
            continue
        errors = [e for e in (value.amplitude_error, value.frequency_error) if np.isfinite(e)]
        if errors:
            place, transform = max(max(errors), _LEAST), axes.transData
        else:
            place, transform = 0.04, axes.get_xaxis_transform()
        axes.annotate(
            value.value,
            (value.cost, place),
            xycoords=transform,
            xytext=(3, 7 if i % 2 == 0 or len(panel.values) < 5 else 17),
            textcoords="offset points",
            fontsize=8.5,
            color=style.BLACK,
            fontweight="bold" if value.chosen else "normal",
            rotation=0 if errors else 90,
        )


_KINDS: Final = (
    (style.BLUE, "o", "amplitude_error"),
    (style.VERMILION, "s", "frequency_error"),
)


def _legend(figure: Figure) -> None:
    """Above the panels, to the right of the title."""
    across, up = figure.get_size_inches()
    handles = [
        Line2D([], [], color=style.BLUE, marker="o", ms=5, mfc="white", label="peak amplitude"),
        Line2D(
            [], [], color=style.VERMILION, marker="s", ms=5, mfc="white", label="peak frequency"
        ),
        Line2D([], [], color=style.GREY, marker="o", ls="", ms=8, label="the study's value"),
        Line2D([], [], color=style.GREY, ls=":", label="finest: the reference"),
    ]
    figure.legend(
        handles=handles,
        ncols=2,
        loc="upper right",
        bbox_to_anchor=(1 - 0.35 / across, 1 - 0.15 / up),
        borderaxespad=0,
        fontsize=10,
    )
