"""Forced response curves of several cases in one figure."""

import re
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogFormatter

from vanelock.common.errors import InputError
from vanelock.render import style
from vanelock.render.plots.curve import (
    AXES,
    MICROMETRES,
    Band,
    Curve,
    CurveLook,
    converged,
    looks,
    peak,
)

_DASHES: Final = {"solid": "-", "dash": "--", "dot": ":", "dashdot": "-."}
_VERDICTS: Final[dict[int, dict[str, Any]]] = {
    0: {"ls": "-"},
    1: {"ls": (0, (3, 1.5))},
    2: {"ls": "-", "color": style.GREY},
}
_LIMITS: Final = {"free": (0, (6, 2)), "stuck": (0, (1, 1))}
_WIDE: Final = 100  # frequencies further apart, highest over lowest, get a logarithmic axis
_LISTED: Final = 28  # more lines than that do not fit beside the curves


def response_figure(
    curves: Sequence[Curve],
    title: str = "Forced response",
    monitor: str = "",
    logarithmic: bool = False,
    engine_order: int | None = None,
    band: Band | None = None,
) -> Figure:
    """Forced response curves with their peaks.

    Colours tell the groups apart, line styles the harmonics; thin lines are the linear limits. A
    marker sits at each peak, with its value in the legend. A line is broken where a point did not
    converge, and a cross marks that point, at the foot of the figure where it has no amplitude.

    Parameters
    ----------
    curves : sequence of Curve
        The cases and limits, in the order of the legend.
    title : str
        Heading.
    monitor : str
        What is monitored, such as "tip 1, radial".
    logarithmic : bool
        Logarithmic amplitudes.
    engine_order : int, optional
        With it, a second axis gives the rotor's speed 60 f/EO in rpm.
    band : Band, optional
        Percentiles of many curves, of which `curves` are a few.

    Raises
    ------
    InputError
        If there is no curve.
    """
    if not curves:
        raise InputError("curves: none given: at least one is needed")
    with style.applied():
        made = style.figure(6.75, title, f"Monitored: {monitor}" if monitor else "")
        axes = style.axes(made, 0.95, 0.75, 7.3, 4.75)
        looked = looks(curves)
        shades = [] if band is None else _shade(axes, band)
        handles = [_draw(axes, curve, look) for curve, look in looked]
        axes.set(xlabel=AXES[0], ylabel=AXES[1])
        every = np.concatenate([curve.frequency for curve in curves])
        low, high = float(every.min()), float(every.max())
        if low > 0 and high > _WIDE * low:
            axes.set_xscale("log")
        if low < high:
            axes.set_xlim(low, high)
        if logarithmic:
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter(LogFormatter(labelOnlyBase=False))
        else:
            axes.set_ylim(bottom=0)
        lost = sum(_flag(axes, curve, look) for curve, look in looked)
        handles += [*shades, *([_flag_handle(lost)] if lost else [])]
        if engine_order:
            _speed_axis(axes, abs(engine_order))
        _legend(made, handles)
        made.draw_without_rendering()  # ticks are made by it, and take the style of that moment
        return made


def response_curves(
    path: style.PathLike, curves: Sequence[Curve], *shown: Any, **options: Any
) -> Path:
    """Write the figure of `response_figure`, with its arguments, as PNG, and return the path.

    Raises
    ------
    InputError
        If there is no curve, or the file cannot be written.
    """
    with style.applied():
        return style.write(response_figure(curves, *shown, **options), path)


def _draw(axes: Axes, curve: Curve, look: CurveLook) -> Line2D:
    """Draw a curve and its peak; return what the legend shows."""
    if curve.kind == "measured":
        return _draw_measured(axes, curve, look)
    if (around := curve.envelope) is not None:
        ends = MICROMETRES * around.low, MICROMETRES * around.high
        axes.fill_between(around.frequency, *ends, color=look.colour, alpha=0.14, linewidth=0)
        for across, up in around.outlines:
            axes.plot(across, MICROMETRES * up, color=look.colour, lw=0.9)
    frequency = curve.frequency
    shown = np.where(converged(curve), MICROMETRES * curve.amplitude, np.nan)
    dashes = _LIMITS.get(curve.kind, _DASHES[look.dash]) if curve.joined else ""
    drawn: dict[str, Any] = {"color": look.colour, "ls": dashes, "lw": look.width}
    # A lone converged point between two lost ones has no line: give it a dot.
    known = np.isfinite(shown)
    alone = known & ~np.append(known[1:], False) & ~np.append(False, known[:-1])
    if curve.joined:
        for verdict, run in curve.pieces:
            looked = {**drawn, **_VERDICTS.get(verdict, {})}
            axes.plot(frequency[run], shown[run], **looked)
    else:
        alone = known
    axes.plot(frequency[alone], shown[alone], ".", color=look.colour)
    top = peak(curve)
    text = _wrapped(curve.label) + "\n"
    if top is None:
        text += "no converged point"
    else:
        axes.plot(
            top.frequency,
            MICROMETRES * top.amplitude,
            look.marker,
            ms=8,
            mfc="white",
            mec=look.colour,
            mew=1.8,
            zorder=4,
        )
        end = ", end of range" if top.at_edge else ""
        text += top.place + end + (f", {curve.outcome}" if curve.outcome else "")
    return Line2D([], [], **drawn, marker=look.marker, ms=8, mfc="white", mew=1.8, label=text)


def _shade(axes: Axes, band: Band) -> list[Any]:
    """Percentiles of many curves: two shades and the median."""
    levels = MICROMETRES * band.levels
    look: dict[str, Any] = {"color": style.BLUE, "linewidth": 0, "zorder": 1.5}
    outer = axes.fill_between(band.frequency, levels[0], levels[4], alpha=0.15, **look)
    inner = axes.fill_between(band.frequency, levels[1], levels[3], alpha=0.3, **look)
    (middle,) = axes.plot(band.frequency, levels[2], color=style.BLACK, linewidth=2.2, zorder=3)
    outer.set_label(f"5 to 95 % of {band.label}")
    inner.set_label("25 to 75 %")
    middle.set_label("their median")
    return [outer, inner, middle]


def _draw_measured(axes: Axes, curve: Curve, look: CurveLook) -> Line2D:
    """Draw a measured curve as dots; return what the legend shows."""
    dots: dict[str, Any] = {"color": look.colour, "ls": "", "marker": look.marker, "ms": 4.5}
    shown = MICROMETRES * curve.amplitude
    axes.plot(curve.frequency, shown, **dots, mfc="white", mew=1.1, zorder=4.5)
    top = peak(replace(curve, joined=False))
    text = _wrapped(curve.label) + ("" if top is None else f"\n{top.place}")
    return Line2D([], [], **dots, mfc="white", mew=1.1, label=text)


def _wrapped(label: str) -> str:
    """A label in lines of the legend's width, broken between quantities, never inside one."""
    kept = re.sub(r" ?= ?", "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}", label)
    return textwrap.fill(kept, 33, break_long_words=False, break_on_hyphens=False)


def _flag(axes: Axes, curve: Curve, look: CurveLook) -> int:
    """Cross out the points that did not converge, and count them."""
    lost = ~converged(curve)
    frequency = curve.frequency[lost]
    shown = MICROMETRES * curve.amplitude[lost]
    low, high = axes.get_ylim()
    placed = np.isfinite(shown) & (shown >= low) & (shown <= 1.5 * high)
    cross: dict[str, Any] = {
        "color": look.colour,
        "ls": "",
        "marker": "x",
        "ms": 9,
        "mew": 2.2,
        "zorder": 5,
    }
    axes.plot(frequency[placed], shown[placed], **cross)
    foot = np.full(np.count_nonzero(~placed), 0.025)
    axes.plot(frequency[~placed], foot, transform=axes.get_xaxis_transform(), **cross)
    if np.any(placed):
        axes.set_ylim(top=max(high, 1.05 * float(shown[placed].max())))
    return int(np.count_nonzero(lost))


def _flag_handle(lost: int) -> Line2D:
    points = "point" if lost == 1 else "points"
    label = f"{lost} {points} not converged\n(at the foot: no amplitude)"
    return Line2D([], [], color=style.BLACK, ls="", marker="x", ms=9, mew=2.2, label=label)


def _speed_axis(axes: Axes, engine_order: int) -> None:
    def speed(frequency: Any) -> Any:
        return 60 / engine_order * frequency

    def back(rpm: Any) -> Any:
        return engine_order / 60 * rpm

    above = axes.secondary_xaxis("top", functions=(speed, back))
    if axes.get_xscale() == "log":
        above.set_xscale("log")
    above.set_xlabel(f"rotor speed at EO {engine_order} (rpm)", fontsize=11)
    above.tick_params(labelsize=11)
    above.spines["top"].set_visible(True)


def _legend(figure: Figure, handles: Sequence[Line2D]) -> None:
    """Legend to the right of the axes: in one line a curve where there are many."""
    across, up = figure.get_size_inches()
    size = 11.0 if len(handles) <= 9 else max(7.5, 11.0 * 9 / len(handles))
    if len(handles) > 13:
        for handle in handles:
            handle.set_label(": ".join(str(handle.get_label()).rsplit("\n", 1)))
    if len(handles) > _LISTED:
        more = len(handles) - _LISTED + 1
        rest = Line2D([], [], ls="", label=f"and {more} more")
        handles = [*handles[: _LISTED - 2], rest, handles[-1]]
    figure.legend(
        handles=handles,
        title="Cases and their peaks",
        title_fontsize=12.5,
        alignment="left",
        loc="upper left",
        bbox_to_anchor=(8.45 / across, 5.6 / up),
        borderaxespad=0,
        handlelength=3.2,
        labelspacing=0.7,
        fontsize=size,
    )
