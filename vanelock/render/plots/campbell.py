"""Campbell diagram: natural frequencies and engine orders against rotor speed, and the response.

The lines of a nodal diameter share a colour: full with the interlock stuck, dashed with it free.
Circles lie on the lines of the engine orders, their areas as the amplitudes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.render import style

FREE: Final = (0, (5, 2.5))
_LARGEST: Final = 900.0  # area of the largest circle, points²
_LEAST: Final = 5.0  # of the smallest one drawn
_ROOM: Final = 1.12  # above the highest line shown
_LABELLED: Final = 14  # crossings of interest with labels


@dataclass(frozen=True)
class LineFamily:
    """Natural frequencies of a nodal diameter, (s, m) Hz at the diagram's speeds."""

    nodal_diameter: int
    free: Floats
    stuck: Floats | None


@dataclass(frozen=True)
class Crossings:
    """Where engine orders meet modes, (c,) arrays; `interest` marks those that matter most."""

    nodal_diameter: Integers
    speed: Floats
    frequency: Floats
    stuck: Booleans
    interest: Booleans


@dataclass(frozen=True)
class Circles:
    """Amplitudes on the lines of engine orders, (b,) arrays, m; `nonlinear` are full."""

    speed: Floats
    frequency: Floats
    amplitude: Floats
    nonlinear: Booleans


@dataclass(frozen=True)
class Dots:
    """A measured curve: rpm, Hz, and amplitudes relative to those of `Circles`, or to its own.

    Attributes
    ----------
    name : str
        In the legend.
    speed, frequency, amplitude : (p,) float
        rpm, Hz, and the amplitude in m, or anything where `own_scale`.
    own_scale : bool
        Whether its largest amplitude has the largest circle.
    """

    name: str
    speed: Floats
    frequency: Floats
    amplitude: Floats
    own_scale: bool = False


def campbell_picture(
    path: style.PathLike,
    speeds: Floats,
    families: Sequence[LineFamily],
    orders: Sequence[int],
    crossings: Crossings,
    circles: Circles | None = None,
    measured: Sequence[Dots] = (),
    title: str = "Campbell diagram",
    subtitle: str = "",
    notes: Sequence[str] = (),
) -> Path:
    """Draw a Campbell diagram, and return the path.

    Parameters
    ----------
    path : path
        PNG file to write.
    speeds : (s,) float
        Rotor speeds of the lines, rpm, ascending.
    families : sequence of LineFamily
        Natural frequencies by nodal diameter.
    orders : sequence of int
        Engine orders.
    crossings : Crossings
        Marked by dots; those of interest by stars with their numbers.
    circles : Circles, optional
        Amplitudes.
    measured : sequence of Dots
        Measured curves, drawn as black circles.
    title, subtitle : str
        Heading, and a line below it.
    notes : sequence of str
        Lines below the legend, such as which circles are linear.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    top = max(_top(each, speeds) for each in families)
    steepest = max(orders) * float(speeds[-1]) / 60
    height = min(_ROOM * top, steepest)
    with style.applied():
        figure = style.figure(7.4, title, subtitle)
        axes = style.axes(figure, 0.95, 0.75, 7.45, 5.55)
        axes.set(xlabel="rotor speed (rpm)", ylabel="frequency (Hz)")
        axes.set_xlim(float(speeds[0]), float(speeds[-1]))
        axes.set_ylim(0, height)
        axes.xaxis.set_major_formatter("{x:,.0f}")
        diameters = (each.nodal_diameter for each in families)
        colours = dict(zip(diameters, style.series(len(families)), strict=True))
        handles = [_family(axes, speeds, each, colours) for each in families]
        if any(each.stuck is not None for each in families):
            handles += [_key("-", "interlock stuck"), _key(FREE, "interlock free")]
        for order in orders:
            _order(axes, order, height)
        if circles is not None and len(circles.speed):
            handles += _circles(axes, circles)
        scale = None if circles is None else float(np.max(circles.amplitude, initial=0.0))
        handles += [_dots(axes, each, scale) for each in measured]
        handles += _crossings(axes, crossings, colours)
        figure.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(8.95 / style.WIDTH, 6.35 / 7.4),
            borderaxespad=0,
            labelspacing=0.75,
            handlelength=2.6,
            fontsize=11,
        )
        figure.text(
            9.0 / style.WIDTH,
            0.75 / 7.4,
            "\n".join(notes),
            fontsize=9.5,
            color=style.GREY,
            va="bottom",
            linespacing=1.35,
        )
        return style.write(figure, path)


def _top(family: LineFamily, speeds: Floats) -> float:
    """Highest frequency of its lines."""
    highest = family.free if family.stuck is None else np.maximum(family.free, family.stuck)
    return float(highest.max())


def _family(axes: Axes, speeds: Floats, family: LineFamily, colours: dict[int, str]) -> Line2D:
    colour = colours[family.nodal_diameter]
    axes.plot(
        speeds, family.free, color=colour, ls=FREE if family.stuck is not None else "-", lw=1.3
    )
    if family.stuck is not None:
        axes.plot(speeds, family.stuck, color=colour, lw=1.5)
    return Line2D([], [], color=colour, lw=2.5, label=f"nodal diameter {family.nodal_diameter}")


def _key(dashes: Any, label: str) -> Line2D:
    return Line2D([], [], color=style.GREY, ls=dashes, lw=1.5, label=label)


def _order(axes: Axes, order: int, height: float) -> None:
    """A line through the origin with its name where it leaves the frame."""
    low, high = axes.get_xlim()
    slope = order / 60
    axes.plot([low, high], [slope * low, slope * high], color=style.GREY, lw=0.9, zorder=1.5)
    side = slope * high <= height
    x, y = (high, slope * high) if side else (height / slope, height)
    axes.annotate(
        f"EO {order}",
        (x, y),
        (4, 0) if side else (0, 4),
        textcoords="offset points",
        ha="left" if side else "center",
        va="center" if side else "bottom",
        fontsize=10.5,
        color=style.BLACK,
        annotation_clip=False,
    )


def _areas(amplitude: Floats, largest: float) -> Floats:
    return np.asarray(_LARGEST * np.abs(amplitude) / max(largest, np.finfo(float).tiny))


def _circles(axes: Axes, circles: Circles) -> list[Line2D]:
    largest = float(circles.amplitude.max())
    areas = _areas(circles.amplitude, largest)
    handles = []
    for nonlinear, colour, label in (
        (True, style.VERMILION, "nonlinear response"),
        (False, style.SKY, "linear response"),
    ):
        own = (circles.nonlinear == nonlinear) & (areas >= _LEAST)
        if not own.any():
            continue
        face = to_rgba(colour, 0.30)
        axes.scatter(
            circles.speed[own],
            circles.frequency[own],
            s=areas[own],
            facecolors=[face],
            edgecolors=colour,
            linewidths=0.8,
            zorder=2,
        )
        top = 1e6 * float(circles.amplitude[own].max())
        size = float(np.sqrt(areas[own].max()))
        text = f"{label}:\nup to {style.number(top)} µm (area)"
        handles.append(_circle(face, colour, min(size, 22.0), text))
    return handles


def _circle(face: Any, edge: str, size: float, label: str) -> Line2D:
    return Line2D([], [], ls="", marker="o", ms=size, mfc=face, mec=edge, mew=0.8, label=label)


def _dots(axes: Axes, dots: Dots, largest: float | None) -> Line2D:
    own = float(np.max(dots.amplitude, initial=0.0))
    scale = own if dots.own_scale or not largest else largest
    areas = np.clip(_areas(dots.amplitude, scale), 4.0, 4 * _LARGEST)
    axes.scatter(
        dots.speed,
        dots.frequency,
        s=areas,
        facecolors="none",
        edgecolors=style.BLACK,
        linewidths=0.9,
        zorder=3,
    )
    return _circle("none", style.BLACK, 9.0, dots.name)


def _crossings(axes: Axes, crossings: Crossings, colours: dict[int, str]) -> list[Line2D]:
    """Dots, full where stuck; stars with their numbers for those of interest."""
    low, high = axes.get_ylim()
    for i in range(len(crossings.speed)):
        if not low <= crossings.frequency[i] <= high:
            continue
        colour = colours[int(crossings.nodal_diameter[i])]
        star = bool(crossings.interest[i])
        axes.plot(
            crossings.speed[i],
            crossings.frequency[i],
            "*" if star else "o",
            ms=17 if star else 4.5,
            mfc=colour if crossings.stuck[i] else "white",
            mec=style.BLACK if star else colour,
            mew=1.1,
            zorder=5 if star else 4,
        )
    of_interest = np.flatnonzero(crossings.interest)[:_LABELLED]
    for i in of_interest:
        text = f"{crossings.speed[i]:,.0f} rpm\n{crossings.frequency[i]:.1f} Hz"
        stuck = bool(crossings.stuck[i])
        label = axes.annotate(
            text,
            (float(crossings.speed[i]), float(crossings.frequency[i])),
            (-12, 10) if stuck else (12, -10),
            textcoords="offset points",
            ha="right" if stuck else "left",
            va="bottom" if stuck else "top",
            fontsize=10.5,
            fontweight="bold",
            zorder=6,
        )
        label.set_path_effects([withStroke(linewidth=3, foreground="white")])
    if not len(of_interest):
        return []
    look: dict[str, Any] = {"ls": "", "marker": "*", "ms": 15, "mfc": "white", "mec": style.BLACK}
    return [Line2D([], [], **look, label="crossing of interest")]
