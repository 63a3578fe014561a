"""Haigh diagram: alternating over mean stress of many places, and how far the Goodman line is."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vanelock.common.arrays import Booleans, Floats
from vanelock.render import style

MPA: Final = 1e-6
FACTORS: Final = (1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""Lines of constant reserve that are drawn where there is room."""


@dataclass(frozen=True)
class Named:
    """A place that is marked: its name, mean and alternating stress, Pa, and whether a gauge."""

    name: str
    mean: float
    amplitude: float
    gauge: bool


def haigh_picture(
    path: style.PathLike,
    mean: Floats,
    amplitude: Floats,
    doubtful: Booleans,
    limit: float,
    tensile: float,
    named: Sequence[Named],
    title: str,
    subtitle: str,
) -> Path:
    """Draw a Haigh diagram, and return the path.

    Left: up to the material's strength; right: the same places, enlarged, with lines of constant
    reserve.

    Parameters
    ----------
    path : path
        PNG file to write.
    mean, amplitude : (n,) float
        Equivalent mean and alternating stress of each place, Pa.
    doubtful : (n,) bool
        Places whose stress has no limit as a mesh is refined.
    limit, tensile : float
        Fatigue limit at no mean stress, and tensile strength, Pa.
    named : sequence of Named
        Locations that are marked and listed in the legend.
    title, subtitle : str
        Heading, and a line under it.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    with style.applied():
        figure = style.figure(7.1, title, subtitle)
        whole = style.axes(figure, 0.9, 1.75, 4.6, 4.2)
        near = style.axes(figure, 6.6, 1.75, 5.0, 4.2)
        for axes in (whole, near):
            _places(axes, mean, amplitude, doubtful, named)
            axes.set_xlabel("mean stress (MPa)")
        whole.set_ylabel("alternating stress (MPa)")
        low = min(0.0, float(MPA * mean.min(initial=0.0)))
        whole.set_xlim(min(1.3 * low, -0.04 * MPA * tensile), 1.05 * MPA * tensile)
        whole.set_ylim(0, 1.15 * max(MPA * limit, float(MPA * amplitude.max(initial=0.0))))
        whole.set_title("Up to the material's strength")
        _line(whole, limit, tensile, 1.0)
        _enlarge(near, mean, amplitude, limit, tensile)
        _legend(figure, named, bool(doubtful.any()))
        return style.write(figure, path)


def _places(
    axes: Axes, mean: Floats, amplitude: Floats, doubtful: Booleans, named: Sequence[Named]
) -> None:
    for chosen, colour, size in ((doubtful, style.LIGHT, 5), (~doubtful, style.SKY, 5)):
        x, y = MPA * mean[chosen], MPA * amplitude[chosen]
        axes.scatter(x, y, s=size, c=colour, linewidths=0, rasterized=True)
    for each, (colour, marker) in zip(named, _marks(named), strict=True):
        axes.plot(
            MPA * each.mean, MPA * each.amplitude, marker, c=colour, ms=8, mec="white", mew=0.8
        )


def _marks(named: Sequence[Named]) -> list[tuple[str, str]]:
    """Colour and marker of each: coloured features, black gauges."""
    colours = (style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE, style.BLUE)
    features, gauges = cycle(zip(colours, "osDv^", strict=True)), cycle("PX*")
    return [(style.BLACK, next(gauges)) if each.gauge else next(features) for each in named]


def _line(axes: Axes, limit: float, tensile: float, n: float) -> None:
    """Goodman's line of a safety factor n, flat in compression."""
    low = axes.get_xlim()[0]
    x, y = [low, 0, MPA * tensile / n], [MPA * limit / n, MPA * limit / n, 0]
    axes.plot(x, y, color=style.BLACK if n == 1 else style.GREY, lw=1.6 if n == 1 else 0.9)


def _enlarge(axes: Axes, mean: Floats, amplitude: Floats, limit: float, tensile: float) -> None:
    x, y = MPA * mean, MPA * amplitude
    low, high = float(x.min(initial=0.0)), float(x.max(initial=1.0))
    room = 0.08 * max(high - low, 1.0)
    axes.set_xlim(low - room, high + room)
    top = 1.25 * max(float(y.max(initial=0.0)), 1.0)
    axes.set_ylim(0, top)
    axes.set_title("These locations, with lines of constant safety factor n")
    for n in FACTORS:
        height = MPA * limit / n
        if not 0.1 * top < height * (1 - max(low - room, 0) * n / (MPA * tensile)) < 1.6 * top:
            continue
        _line(axes, limit, tensile, n)
        axes.set_xlim(low - room, high + room)
        left = low - room
        at = left + 0.02 * (high - low + 2 * room)
        level = height - max(at, 0) * limit / tensile
        if level < 0.97 * top:
            axes.text(at, level, f"n = {n:g}", color=style.GREY, va="bottom", fontsize=10.5)


def _legend(figure: Figure, named: Sequence[Named], doubtful: bool) -> None:
    handles = [
        Line2D([], [], ls="", marker=marker, color=colour, ms=8, mec="white", label=each.name)
        for each, (colour, marker) in zip(named, _marks(named), strict=True)
    ]
    handles.append(
        Line2D([], [], ls="", marker="o", color=style.SKY, ms=5, mec="none", label="all nodes")
    )
    if doubtful:
        label = "at sharp corners and point forces"
        handles.append(
            Line2D([], [], ls="", marker="o", color=style.LIGHT, ms=5, mec="none", label=label)
        )
    handles.append(Line2D([], [], color=style.BLACK, lw=1.6, label="Goodman line, n = 1"))
    height = figure.get_size_inches()[1]
    figure.legend(handles=handles, ncols=4, loc="upper left", bbox_to_anchor=(0.06, 1.2 / height))
