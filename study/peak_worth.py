"""By how much the largest response moves when the estimated errors of its points are made good."""

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear import Response
from vanelock.nonlinear.hermite import Curve

FIRST_ORDER = 0.3
"""Of the amplitude: larger changes are beyond an estimate of first order, and not told."""


def peak_by_source(response: Response) -> dict[str, tuple[float, float]]:
    """Relative errors of the peak's amplitude and frequency by source; NaN where unknown.

    The curve with the changes that a source amounts to is searched for its highest place as the
    curve itself is. The source "frequencies" is the curve's interpolation error beside that place.
    """
    told, order = response.estimates, np.argsort(response.frequency, kind="stable")
    assert told is not None
    known = order[response.converged[order] & np.isfinite(told.amplitude[order])]
    f, a = response.frequency[known], told.amplitude[known]
    if len(f) < 3:
        return {}
    curve = Curve(f, a, told.slope[known])
    place, height = curve.top()
    top = int(a.argmax())
    found = {}
    for name, change in zip(told.sources, told.change[known].T, strict=True):
        if not abs(change[top]) < FIRST_ORDER * a[top]:
            found[name] = (float("nan"), float("nan"))
            continue
        small = np.clip(np.nan_to_num(change), -FIRST_ORDER * a, FIRST_ORDER * a)
        better = Curve(f, a + small, curve.slope + np.gradient(small, f))
        moved, raised = better.top()
        found[name] = (abs(raised / height - 1), abs(moved / place - 1))
    found["frequencies"] = _between(curve, place, height)
    return found


def _between(curve: Curve, place: float, height: float) -> tuple[float, float]:
    """What the interpolation beside the highest place may be off by."""
    uncertain, lengths = curve.uncertainty(), np.diff(curve.x)
    i = int(np.clip(np.searchsorted(curve.x, place) - 1, 0, len(lengths) - 1))
    beside = slice(max(i - 1, 0), i + 2)
    error, length = float(uncertain[beside].max()), float(lengths[beside].min())
    step = length / 4
    three: NDArray[np.float64] = curve.at(place + step * np.array([-1.0, 0.0, 1.0]))
    bend = abs(three[0] - 2 * three[1] + three[2]) / step**2
    moved = 2 * error / length / bend if bend > 0 else float("inf")
    return error / height, min(moved, length) / place
