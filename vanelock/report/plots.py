"""Curves as plotly.js draws them; the page's own legend stands below each plot.

Arrays travel as base64 of 32-bit floats, which plotly.js reads as they are.
"""

from base64 import b64encode
from typing import Any, Final

import numpy as np
from markupsafe import escape

from vanelock.common.errors import InputError
from vanelock.render import style
from vanelock.report.blocks import Plot, Trace
from vanelock.report.wording import quantity

FONT: Final = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif"
_MARKER: Final = 7.0  # pixels


def figure(plot: Plot) -> dict[str, Any]:
    """`data` and `layout` for plotly.js."""
    colours = _colours(plot)
    return {
        "data": [_trace(plot, *pair) for pair in zip(plot.traces, colours, strict=True)],
        "layout": _layout(plot),
        "zoom": plot.zoom,
    }


def legend(plot: Plot) -> list[dict[str, Any]]:
    """Entries in the order of the traces, one for each group and each trace without a group."""
    members: dict[str, list[int]] = {}
    for i, trace in enumerate(plot.traces):
        members.setdefault(trace.group or f"\0{i}", []).append(i)
    colours = _colours(plot)
    entries = []
    for traces in members.values():
        top = plot.traces[traces[0]]
        drawn = {"lines": "lines" in top.mode, "markers": "markers" in top.mode, "traces": traces}
        looks = {"colour": colours[traces[0]], "dash": top.dash, "fill": top.fill}
        entries.append({"name": top.name, **looks, **drawn})
    return entries


def _colours(plot: Plot) -> list[str]:
    """Each trace's own colour, or the next of the house's series; a group shares one."""
    keys = [trace.group or f"\0{i}" for i, trace in enumerate(plot.traces)]
    wanting = list(dict.fromkeys(k for k, t in zip(keys, plot.traces, strict=True) if not t.colour))
    named = dict(zip(wanting, style.series(len(wanting)), strict=True))
    return [t.colour or named[k] for k, t in zip(keys, plot.traces, strict=True)]


def _trace(plot: Plot, trace: Trace, colour: str) -> dict[str, Any]:
    x, y = np.asarray(trace.x, float), np.asarray(trace.y, float)
    if x.ndim != 1 or x.shape != y.shape:
        raise InputError(f"{plot.title}: {trace.name}: x {x.shape} and y {y.shape} must be alike")
    drawn: dict[str, Any] = {
        "type": "scatter",
        "mode": trace.mode,
        "name": trace.name,
        "x": _packed(x),
        "y": _packed(y),
        "connectgaps": False,
        "hovertemplate": _hover(plot, trace),
        "hoverlabel": {"namelength": -1},
    }
    if "lines" in trace.mode:
        drawn["line"] = {"color": colour, "width": trace.width, "dash": trace.dash}
    if trace.fill:
        drawn["line"]["width"] = 0
        drawn |= {"fill": "toself", "fillcolor": _sheer(colour, trace.fill), "hoverinfo": "skip"}
        del drawn["hovertemplate"]
    if "markers" in trace.mode:
        drawn["marker"] = {"color": colour, "size": _MARKER}
    return drawn


def _sheer(colour: str, opacity: float) -> str:
    """A colour "#rrggbb" that lets others through."""
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({','.join(map(str, parts))},{opacity:g})"


def _packed(values: np.ndarray[Any, Any]) -> dict[str, str]:
    """An array of numbers as plotly.js's `{dtype, bdata}`."""
    return {"dtype": "f4", "bdata": b64encode(values.astype("<f4").tobytes()).decode("ascii")}


def _hover(plot: Plot, trace: Trace) -> str:
    lines = [f"<b>{_literal(trace.name)}</b>"]
    for letter, label, digits in (("x", plot.xlabel, 6), ("y", plot.ylabel, 5)):
        name, unit = quantity(label)
        value = f"%{{{letter}:.{digits}~g}}"
        lines.append(f"{_literal(name)}: {value} {_literal(unit)}".rstrip())
    if trace.hover:
        lines.append(_literal(trace.hover))
    return "<br>".join(lines) + "<extra></extra>"


def _literal(text: str) -> str:
    """Text for a template, in which plotly.js fills in what it names as %{...}."""
    return str(escape(text)).replace("%{", "&#37;{")


def _layout(plot: Plot) -> dict[str, Any]:
    negative = any(np.any(np.asarray(trace.y) < 0) for trace in plot.traces)
    to_zero = plot.y_from_zero and not plot.log_y and not negative
    return {
        "xaxis": _axis(plot.xlabel, plot.log_x) | _room(plot),
        "yaxis": _axis(plot.ylabel, plot.log_y) | {"rangemode": "tozero" if to_zero else "normal"},
        "font": {"family": FONT, "size": 13, "color": style.BLACK},
        "margin": {"l": 68, "r": 18, "t": 14, "b": 52, "pad": 0},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "#ffffff",
        "showlegend": False,
        "hovermode": "closest",
        "hoverdistance": 40,
        "hoverlabel": {"bgcolor": "#ffffff", "font": {"size": 13, "color": style.BLACK}},
        "dragmode": "zoom",
        "modebar": {
            "bgcolor": "rgba(255,255,255,0.85)",
            "color": style.GREY,
            "activecolor": style.BLACK,
        },
    }


def _room(plot: Plot) -> dict[str, Any]:
    """A little room at both ends, where plotly.js lets lines end on the frame."""
    every = np.concatenate([np.zeros(0), *(np.asarray(t.x, float) for t in plot.traces)])
    every = every[np.isfinite(every) & ((every > 0) | (not plot.log_x))]
    if not len(every) or every.min() == every.max():
        return {}
    places = np.log10(every) if plot.log_x else every
    ends = np.array([places.min(), places.max()]) + np.array([-0.015, 0.015]) * np.ptp(places)
    return {"autorangeoptions": {"include": (10**ends if plot.log_x else ends).tolist()}}


def _axis(label: str, log: bool) -> dict[str, Any]:
    # On a logarithmic axis every label is written in full, and few of them.
    scale = {"type": "log", "tickformat": ".6~g", "nticks": 6} if log else {"type": "linear"}
    return scale | {
        "title": {"text": str(escape(label)), "standoff": 10},
        "gridcolor": style.LIGHT,
        "griddash": "solid",
        "zeroline": False,
        "showline": True,
        "linecolor": style.GREY,
        "ticks": "outside",
        "tickcolor": style.GREY,
        "ticklen": 5,
        "automargin": True,
        "exponentformat": "power",
        "minor": {"ticks": "outside", "ticklen": 3} if log else {},
    }
