"""All numbers that the statements are judged by, gathered from a finished campaign."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear import Response
from vanelock.published.checks import Difference
from vanelock.published.conditions import PrescribedLoop
from vanelock.published.maps.optimum import Ridge
from vanelock.published.maps.plane import Method, Plane
from vanelock.published.sheets import Plan
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.summary import Peak, Summary

Floats = NDArray[np.float64]

REFERENCE = Method(1)
SAME = 1e-3
"""Relative difference of amplitudes below which two peaks are called equal."""


@dataclass(frozen=True)
class Evidence:
    """What a campaign found.

    Attributes
    ----------
    plan : Plan
        Its cases.
    summaries : dict of str to Summary
        By case.
    limits : Limits
        Linear modes with the interlock free and stuck.
    linear : dict of "free" | "stuck" to Peak
        Linear peaks at the full load.
    monitor : str
    engine_order : int
    small : float
        Factor of the load at which all contacts stick.
    hooks : Difference
        Hooks in friction against the linear response.
    stuck : dict of str to Difference
        Coupled against another coupling at full stick.
    at_mean : dict of str to float
        By coupled case: the constant-load peak where the forces at rest are the mean ones of the
        coupled peak, m.
    conditions : tuple of PrescribedLoop
    planes : dict of str to Plane
        "interference" and "load", of the study's own slant.
    slants : dict of float to Plane
        Of other slants, deg.
    ridges : tuple of Ridge
    tops : dict of str to Response
        The peak of each case alone.
    statics : dict of str to Response
        The state at rest of each case.
    interlock : (c,) bool
        Contacts of the interlock.
    """

    plan: Plan
    summaries: Mapping[str, Summary]
    limits: Limits
    linear: Mapping[str, Peak]
    monitor: str
    engine_order: int
    small: float
    hooks: Difference
    stuck: Mapping[str, Difference]
    at_mean: Mapping[str, float]
    conditions: tuple[PrescribedLoop, ...]
    planes: Mapping[str, Plane]
    slants: Mapping[float, Plane]
    ridges: tuple[Ridge, ...]
    tops: Mapping[str, Response]
    statics: Mapping[str, Response]
    interlock: NDArray[np.bool_] = field(repr=False)

    def amplitude(self, case: str) -> float:
        """Peak of a case, m; NaN where no point converged."""
        peak = self.summaries[case].peak
        return float("nan") if peak is None else peak.amplitude

    def frequency(self, case: str) -> float:
        """Its frequency, Hz."""
        peak = self.summaries[case].peak
        return float("nan") if peak is None else peak.frequency

    def mean_load(self, case: str) -> tuple[float, float]:
        """Mean normal force of the interlock at rest and at the peak, N a pair."""
        static = self.statics[case].force[0, 0, self.interlock, 0].real
        top = self.tops[case].force[0, 0, self.interlock, 0].real
        return float(static.mean()), float(top.mean())


def falls(amplitude: Floats, axis: int) -> NDArray[np.bool_]:
    """Where a peak falls along an axis, by central differences of its logarithm, one-sided at ends.

    Cells whose neighbours are not known are False.
    """
    slope = np.gradient(np.log(amplitude), axis=axis)
    return np.asarray(slope < 0)


def higher_and_lower(plane: Plane, coupling: str) -> NDArray[np.bool_]:
    """Where the peak by another coupling lies at a higher frequency and lower than the coupled."""
    a, f = plane.of(REFERENCE)
    other_a, other_f = plane.of(Method(1, coupling))
    return np.asarray((other_f > f) & (other_a < a))


def slight(plane: Plane, first: int, then: int, bound: float) -> NDArray[np.bool_]:
    """Where going from H = first to H = then changes the peak by less than a relative bound."""
    a, _ = plane.of(Method(first))
    b, _ = plane.of(Method(then))
    return np.asarray(np.abs(b / a - 1) < bound)


def error(plane: Plane, method: Method, best: Method) -> Floats:
    """Relative error of the peak by a method against that by the best one."""
    a, _ = plane.of(method)
    b, _ = plane.of(best)
    return np.asarray(a / b - 1)


def known(plane: Plane) -> NDArray[np.bool_]:
    """(m, v) cells whose peak is known by every method."""
    return np.asarray(np.isfinite(plane.amplitude).all(axis=2))


def share(plane: Plane, holds: NDArray[np.bool_]) -> float:
    """Share of a plane's known cells in which something holds; NaN where none is known."""
    own = holds[known(plane)]
    return float(own.mean()) if own.size else float("nan")
