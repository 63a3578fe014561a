"""A curve of forced vibration that was drawn from a damped mode, and parts of it."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SynthesisedCurve:
    """Vibration at k points, drawn from one mode.

    Attributes
    ----------
    frequency : (k,) float
        Of the load, Hz.
    amplitude : (k,) float
        Modal amplitude of the mode, kg^½ m.
    output : (k, o, 3) complex
        Displacement of the output nodes in the fundamental, m.
    others : (k,) float
        Vibration of the contacts that comes with the other modes, of the mode's own; at most 1.
    curve : (k,) int
        Which curve each point is of, from 0: those of one number are joined, up the lower side of a
        peak and down the upper one. A second one is a resonance apart from the first.
    """

    frequency: Floats
    amplitude: Floats
    output: NDArray[np.complex128]
    others: Floats
    curve: NDArray[np.int64]


def small_parts(curve: SynthesisedCurve) -> list[SynthesisedCurve]:
    """Stretches that have a frequency, where other modes move the contacts less than the mode."""
    sound = (curve.others <= 1) & np.isfinite(curve.frequency)
    small = np.concatenate([[False], sound, [False]])
    begin, end = (np.flatnonzero(np.diff(small.astype(int)) == sign) for sign in (1, -1))
    return [taken(curve, slice(*each)) for each in zip(begin, end, strict=True)]


def taken(curve: SynthesisedCurve, points: slice) -> SynthesisedCurve:
    """Some of the points."""
    chosen = {each.name: getattr(curve, each.name)[points] for each in fields(curve)}
    return SynthesisedCurve(**chosen)


def joined_curves(curves: Sequence[SynthesisedCurve], number: bool = False) -> SynthesisedCurve:
    """Curves one after another, numbered or taken for one."""
    joined = {
        each.name: np.concatenate([getattr(curve, each.name) for curve in curves])
        for each in fields(SynthesisedCurve)
    }
    if number:
        joined["curve"] = np.repeat(np.arange(len(curves)), [len(each.curve) for each in curves])
    return SynthesisedCurve(**joined)
