"""Curves in panels below each other that share what they are drawn over."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.ticker import StrMethodFormatter
from numpy.typing import ArrayLike

from vanelock.render import style

_HEIGHT: Final = 2.1  # inches
_GAP: Final = 0.3


@dataclass(frozen=True)
class PanelCurve:
    """A line of a panel; those of one name share a colour, in all panels.

    Attributes
    ----------
    name : str
        In the legend.
    x, y : (p,) array_like
        In the units of the axes' labels.
    circles : sequence of (float, float, bool)
        Points x, y to be marked, and whether each circle is filled.
    """

    name: str
    x: ArrayLike
    y: ArrayLike
    circles: Sequence[tuple[float, float, bool]] = ()


@dataclass(frozen=True)
class CurvePanel:
    """One of the panels.

    Attributes
    ----------
    label : str
        What it shows, with its unit.
    curves : sequence of PanelCurve
    from_zero : bool
        Whether its axis begins at zero.
    """

    label: str
    curves: Sequence[PanelCurve]
    from_zero: bool = False


def panels_picture(
    path: style.PathLike,
    panels: Sequence[CurvePanel],
    xlabel: str,
    title: str,
    subtitle: str,
    logarithmic: bool = False,
    marks: Sequence[float] = (),
) -> Path:
    """Draw panels of curves, and return the path.

    Parameters
    ----------
    path : path
        PNG file to write.
    panels : sequence of CurvePanel
        From above.
    xlabel : str
        What all are drawn over, with its unit.
    title, subtitle : str
        Heading and the line under it.
    logarithmic : bool
        Whether that axis is.
    marks : sequence of float
        Places on it that a thin line marks.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    names = list(dict.fromkeys(each.name for panel in panels for each in panel.curves))
    colour = dict(zip(names, style.series(len(names)), strict=True))
    count = len(panels)
    with style.applied():
        height = count * _HEIGHT + (count - 1) * _GAP + 1.95
        figure = style.figure(height, title, subtitle)
        for i, panel in enumerate(panels):
            bottom = 0.75 + (count - 1 - i) * (_HEIGHT + _GAP)
            axes = style.axes(figure, 1.1, bottom, 8.6, _HEIGHT)
            for each in panel.curves:
                own = colour[each.name]
                x, y = np.asarray(each.x, float), np.asarray(each.y, float)
                axes.plot(x, y, color=own, label=each.name)
                axes.plot(x[-1:], y[-1:], "o", color=own, markersize=4)
                for across, up, full in each.circles:
                    inside = own if full else "white"
                    axes.plot(
                        across, up, "o", color=own, markerfacecolor=inside, markersize=8, zorder=3
                    )
            for place in marks:
                axes.axvline(place, color=style.GREY, linewidth=0.9, linestyle=":")
            if logarithmic:
                axes.set_xscale("log")
            else:
                axes.ticklabel_format(axis="x", useMathText=True)
            axes.set_ylabel(panel.label)
            if panel.from_zero:
                axes.axhline(0.0, color=style.GREY, linewidth=0.9)
                axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
            axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            named = [each.name for each in panel.curves]
            if len(named) > 1 and not (i and named == [each.name for each in panels[i - 1].curves]):
                axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.02))
            if i + 1 < count:
                axes.tick_params(labelbottom=False)
            else:
                axes.set_xlabel(xlabel)
        return style.write(figure, path)
