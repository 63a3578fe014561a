"""Forced response curves to look into, in the colours and dashes of their pictures."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from vanelock.render import style
from vanelock.render.plots.curve import (
    AXES,
    MICROMETRES,
    Band,
    Curve,
    CurveLook,
    Dash,
    converged,
    looks,
)
from vanelock.report.blocks import Mode, Plot, Trace

_VERDICTS: Final[dict[int, tuple[Dash, str]]] = {
    0: ("solid", ""),
    1: ("dash", ""),
    2: ("solid", style.GREY),
}


def curve_plot(
    curves: Sequence[Curve],
    title: str,
    caption: str,
    band: Band | None = None,
    data: Sequence[Path] = (),
) -> Plot:
    """The curves of a picture, see `render.response_curves`."""
    traces = [] if band is None else list(_shaded(band))
    for curve, look in looks(curves):
        traces += _traces(curve, look)
    return Plot(traces, *AXES, title, caption, data=data)


def _traces(curve: Curve, look: CurveLook) -> Iterator[Trace]:
    """A curve, and its points that did not converge."""
    frequency, amplitude = curve.frequency, MICROMETRES * curve.amplitude
    solved, order = converged(curve), np.argsort(frequency, kind="stable")
    joined: Mode = "lines" if curve.joined else "lines+markers"
    if (around := curve.envelope) is not None:
        across = np.append(around.frequency, around.frequency[::-1])
        ends = MICROMETRES * np.append(around.low, around.high[::-1])
        name = f"{curve.label}: bounds"
        yield Trace(across, ends, name, group=name, colour=look.colour, fill=0.14)
        for x, y in around.outlines:
            yield Trace(x, MICROMETRES * y, name, group=name, colour=look.colour, width=1.0)
    shown, pieces = np.where(solved, amplitude, np.nan), curve.pieces
    for verdict, run in pieces:
        points = np.arange(len(frequency))[run] if len(pieces) > 1 else order
        dash, colour = _VERDICTS.get(verdict, (look.dash, look.colour))
        yield Trace(
            frequency[points],
            shown[points],
            curve.label,
            group=curve.label if len(pieces) > 1 else "",
            mode="markers" if curve.kind == "measured" else joined,
            dash=dash,
            width=look.width,
            colour=colour or look.colour,
        )
    if not solved.all():
        name = f"{curve.label}: did not converge"
        lost = frequency[~solved], amplitude[~solved]
        yield Trace(*lost, name, mode="markers", colour=style.VERMILION)


def _shaded(band: Band) -> Iterator[Trace]:
    """Percentiles of many curves: two bands, the wider one below, and the median."""
    levels = MICROMETRES * band.levels
    around = np.append(band.frequency, band.frequency[::-1])
    for i, (low, high, opacity) in enumerate(((5, 95, 0.15), (25, 75, 0.3))):
        outline = np.append(levels[i], levels[-1 - i][::-1])
        name = f"{low} to {high} % of {band.label}"
        yield Trace(around, outline, name, colour=style.BLUE, fill=opacity)
    name = f"median of {band.label}"
    yield Trace(band.frequency, levels[2], name, width=3.0, colour=style.BLACK)
