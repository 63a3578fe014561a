"""Curves as one table: a row for each point of each curve, one value in a column."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from vanelock import render
from vanelock.quantities.selection import PERCENT

NOTE = (
    "a row for each point of each curve; case: its name in tables, empty where a curve is of none "
    "or of several; converged: 1, or 0 where the point is not to be trusted; stability: where known"
)
STABILITY = ("stable", "unstable", "undecided", None)
"""By the verdict on a point; the last one is that of -1."""

Row = tuple[str, str, float, float, int | None, str | None]


def columns(
    curves: Sequence[render.Curve], band: render.Band | None = None
) -> Mapping[str, ArrayLike]:
    """Columns of some curves, with their bounds, and of percentiles of many."""
    rows = [row for curve in curves for row in _rows(curve)]
    if band is not None:
        for percent, level in zip(PERCENT, band.levels, strict=True):
            rows += _points(f"{band.label}, {percent} %", "", band.frequency, level)
    heads = "curve", "case", "frequency (Hz)", "amplitude (µm)", "converged", "stability"
    kinds = str, str, float, float, object, object
    cells = list(zip(*rows, strict=True)) or [()] * len(heads)
    return {
        head: np.array(column, kind) for head, kind, column in zip(heads, kinds, cells, strict=True)
    }


def _rows(curve: render.Curve) -> Iterator[Row]:
    frequency = np.asarray(curve.frequency, float)
    converged: Sequence[int | None] = [None] * len(frequency)
    if curve.converged is not None:
        converged = np.asarray(curve.converged).astype(int).tolist()
    verdict = [-1] * len(frequency) if curve.verdict is None else np.asarray(curve.verdict)
    points = _points(curve.label, curve.case, frequency, curve.amplitude)
    for point, solved, code in zip(points, converged, verdict, strict=True):
        yield (*point[:4], solved, STABILITY[code])
    if (around := curve.envelope) is not None:
        for end, level in (("lower bound", around.low), ("upper bound", around.high)):
            yield from _points(f"{curve.label}, {end}", curve.case, around.frequency, level)


def _points(label: str, case: str, frequency: ArrayLike, amplitude: ArrayLike) -> list[Row]:
    hertz = np.asarray(frequency, float).tolist()
    micrometres = (1e6 * np.asarray(amplitude, float)).tolist()
    return [(label, case, f, a, None, None) for f, a in zip(hertz, micrometres, strict=True)]
