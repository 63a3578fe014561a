"""Estimated errors of a response's peak: of its amplitude, and of its frequency.

At the peak, where A' = 0, a change δA of the curve changes the largest amplitude by δA itself, to
first order, and moves the peak by -δA'/A''.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear.adaptive.interpolant import Interpolant
from vanelock.nonlinear.forced_response.response import Response

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PeakErrors:
    """What the highest point of a response is worth.

    Attributes
    ----------
    point : int
        Its place in the response.
    frequency : float
        Hz.
    amplitude : float
        m.
    sources : tuple of str
        The sources of the response's estimates, and "frequencies": interpolating between points.
    amplitude_error, frequency_error : dict of str to float
        Relative errors by source; NaN where unknown, as that of the frequency is at the end of a
        range. Where the curve jumps beside its highest point, "frequencies" alone is known of both.
    """

    point: int
    frequency: float
    amplitude: float
    sources: tuple[str, ...]
    amplitude_error: dict[str, float]
    frequency_error: dict[str, float]

    @property
    def total(self) -> float:
        """Sum of the amplitude's errors that are known."""
        return float(np.nansum(list(self.amplitude_error.values())))

    @property
    def total_frequency(self) -> float:
        """Sum of the frequency's errors that are known."""
        return float(np.nansum(list(self.frequency_error.values())))


def peak_errors(response: Response) -> PeakErrors:
    """Estimated errors of the largest amplitude of the monitored output.

    Parameters
    ----------
    response : Response
        With estimates, as by `adaptive_response`.

    Raises
    ------
    InputError
        If the response has no estimates, or no point of it converged.
    """
    known = response.estimates
    if known is None:
        raise InputError("peak_errors: the response has no error estimates")
    good = np.flatnonzero(response.converged)
    if not len(good):
        raise InputError("peak_errors: no point of the response converged")
    order = good[np.argsort(response.frequency[good], kind="stable")]
    f, A, slope = (each[order] for each in (response.frequency, known.amplitude, known.slope))
    top = int(np.argmax(A))
    amplitude = dict(zip(known.sources, (np.abs(known.change[order[top]]) / A[top]), strict=True))
    frequency = dict.fromkeys(known.sources, np.nan)
    frequency["frequencies"] = amplitude["frequencies"] = np.nan
    branch = _branches(response, order)
    own = np.flatnonzero(branch == branch[top])
    if own[0] < top < own[-1]:
        curve, at = Interpolant(f[own], A[own], slope[own]), top - int(own[0])
        missed = float(curve.uncertainty()[at - 1 : at + 1].max())
        amplitude["frequencies"] = max(missed, curve.tops()[1].max() - A[top]) / A[top]
        across = f[top + 1] - f[top - 1]
        bend = (slope[top + 1] - slope[top - 1]) / across
        if np.isfinite(bend) and bend < 0:
            tilt = (known.change[order[top + 1]] - known.change[order[top - 1]]) / across
            moved = np.abs(tilt / bend) / f[top]
            frequency |= dict(zip(known.sources, moved.tolist(), strict=True))
            frequency["frequencies"] = abs(float(slope[top] / bend)) / f[top]
    elif 0 < top < len(f) - 1:
        gaps = np.abs(f[[top - 1, top + 1]] - f[top])[branch[[top - 1, top + 1]] != branch[top]]
        frequency["frequencies"] = gaps.max() / f[top]
        amplitude["frequencies"] = abs(slope[top]) * gaps.max() / A[top]
    return PeakErrors(
        point=int(order[top]),
        frequency=float(f[top]),
        amplitude=float(A[top]),
        sources=(*known.sources, "frequencies"),
        amplitude_error={name: float(value) for name, value in amplitude.items()},
        frequency_error={name: float(value) for name, value in frequency.items()},
    )


def _branches(response: Response, order: NDArray[np.int64]) -> NDArray[np.int64]:
    """(p,) on which branch, counted from the first, each of some points lies, in their order."""
    begins = np.zeros(len(order), np.int64)
    if response.jump is not None and len(response.jump):
        place = np.zeros(response.points, np.int64)
        place[order] = np.arange(len(order))
        begins[place[response.jump].max(axis=1)] = 1
    return np.cumsum(begins)
