"""A response curve between its points: cubic through amplitudes and slopes, and how far it is off.

Leaving out a point i and interpolating across it shows an error e_i. The curve between neighbouring
points, on half of that length, is sixteen times closer if it is smooth; where a contact changes its
state it is four times closer, which is what is counted on. Unequal lengths count by their square.

At the peak, where A' = 0, a change δA of the curve changes the largest amplitude by δA itself, to
first order, and moves the peak by -δA'/A''.
"""

from dataclasses import dataclass

import numpy as np

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.nonlinear.forced_response.response import Response

_CLOSER = 4.0
_NEAR = 0.2  # of its share, how much higher than every point the curve may be
SIMILAR = 0.9
"""Of the largest value, above which every maximum is located."""
HIGH = 0.7
"""Of the largest value, above which a curve is high."""
_FINE = 32  # places looked at between two points for the highest


@dataclass(frozen=True)
class Interpolant:
    """Amplitudes and slopes at p ascending places, dy/dx NaN where it is not known."""

    x: Floats
    y: Floats
    slope: Floats

    def at(self, x: Floats) -> Floats:
        """The curve at places; beyond its ends, its first and last pieces go on."""
        return self._across(np.arange(len(self.x)), x)

    def _across(self, chosen: Integers, x: Floats) -> Floats:
        """The curve through some of the points, at places."""
        slope = self.slope
        if not np.all(np.isfinite(slope)):
            known = np.gradient(self.y, self.x) if len(self.x) > 1 else np.zeros(len(self.x))
            slope = np.where(np.isfinite(slope), slope, known)
        X, y, slope = self.x[chosen], self.y[chosen], slope[chosen]
        if len(X) == 1:
            return np.asarray(y[0] + slope[0] * (x - X[0]))
        i = np.clip(np.searchsorted(X, x, side="right") - 1, 0, len(X) - 2)
        length = X[i + 1] - X[i]
        t = (x - X[i]) / length
        rise = y[i + 1] - y[i]
        before, after = slope[i] * length - rise, rise - slope[i + 1] * length
        return np.asarray(y[i] + t * rise + t * (1 - t) * ((1 - t) * before + t * after))

    def uncertainty(self) -> Floats:
        """(p - 1,) error of the curve between neighbouring points."""
        p = len(self.x)
        missed = np.zeros(p)
        every = np.arange(p)
        for first in (0, 1):  # every other point at once; the curve is local
            kept = (every % 2 == first) | (every == 0) | (every == p - 1)
            across = self._across(every[kept], self.x[~kept])
            missed[~kept] = self.y[~kept] - across
        lengths = np.diff(self.x)
        error = np.zeros(p - 1)
        for i in range(1, p - 1):
            both = lengths[i - 1] + lengths[i]
            for j in (i - 1, i):
                estimate = abs(missed[i]) / _CLOSER * (2 * lengths[j] / both) ** 2
                error[j] = max(error[j], estimate)
        return error

    def tops(self) -> tuple[Floats, Floats]:
        """(p - 1,) the highest place of each piece, and (p - 1,) its value there."""
        share = np.linspace(0, 1, _FINE + 1)
        fine = self.x[:-1, None] + np.diff(self.x)[:, None] * share
        y = self.at(fine.reshape(-1)).reshape(fine.shape)
        i = np.argmax(y, axis=1)[:, None]
        return np.take_along_axis(fine, i, 1)[:, 0], np.take_along_axis(y, i, 1)[:, 0]

    def maxima(self, share: float) -> tuple[Floats, Booleans]:
        """(p - 1,) the highest place of each piece; whether it is a maximum that no point has."""
        places, values = self.tops()
        higher = values - np.maximum(self.y[:-1], self.y[1:]) > _NEAR * share * values
        return places, higher & (values > SIMILAR * self.y.max(initial=0.0))

    def wanted(self, share: float, closest: float, widest: float = np.inf) -> Floats:
        """Places where one more point is needed, ascending.

        The curve may be off by `share` of its largest value; none is put between neighbours that
        are `closest`; where it is high, another peak may be hidden between those `widest` apart.
        """
        if len(self.x) < 3:
            return np.empty(0)
        highest = float(self.y.max())
        uncertain = self.uncertainty() > share * highest
        high = np.maximum(self.y[:-1], self.y[1:]) > HIGH * highest
        uncertain |= high & (np.diff(self.x) > widest)
        uncertain &= np.diff(self.x) > closest
        places, maxima = self.maxima(share)
        middles = 0.5 * (self.x[:-1] + self.x[1:])
        return np.asarray(np.where(maxima, places, middles)[maxima | uncertain])


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


def _branches(response: Response, order: Integers) -> Integers:
    """(p,) on which branch, counted from the first, each of some points lies, in their order."""
    begins = np.zeros(len(order), np.int64)
    if response.jump is not None and len(response.jump):
        place = np.zeros(response.points, np.int64)
        place[order] = np.arange(len(order))
        begins[place[response.jump].max(axis=1)] = 1
    return np.cumsum(begins)
