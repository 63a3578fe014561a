"""The peak against friction and against interference over decades, and where it is lowest.

The peak itself is followed along the parameter (`nonlinear.peak_response`), as densely as its curve
needs; the least of it is the vertex of the parabola through the lowest three points, over the
logarithm of the parameter.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear import Journal, System

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Ridge(Product):
    """Peaks along a parameter of the interlock.

    Attributes
    ----------
    name : str
        "mu" or "interference".
    harmonics : int
    parameter : (p,) float
        Ascending; interference in m.
    amplitude, frequency : (p,) float
        Of the peak, m and Hz.
    converged : (p,) bool
    second_peak : (p,) float
        A second, lower peak, m; NaN where none was met.
    message : str
        Why there are no peaks, or "".
    """

    name: str
    harmonics: int
    parameter: Floats
    amplitude: Floats = field(metadata={"unit": "m"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    converged: NDArray[np.bool_]
    second_peak: Floats = field(metadata={"unit": "m"})
    message: str = ""

    @property
    def best(self) -> tuple[float, float, bool] | None:
        """Parameter and amplitude of the lowest peak, and whether it lies at an end."""
        known = np.flatnonzero(self.converged)
        if len(known) < 3:
            return None
        x, a = np.log(self.parameter[known]), self.amplitude[known]
        low = int(a.argmin())
        if low in (0, len(known) - 1):
            return float(np.exp(x[low])), float(a[low]), True
        near = slice(low - 1, low + 2)
        bend, rise, level = np.polyfit(x[near] - x[low], a[near], 2)
        if not bend > 0:
            return float(np.exp(x[low])), float(a[low]), False
        move = float(np.clip(-rise / (2 * bend), x[low - 1] - x[low], x[low + 1] - x[low]))
        least = level + rise * move + bend * move**2
        if not 0 < least <= a[low]:
            move, least = 0.0, a[low]
        return float(np.exp(x[low] + move)), float(least), False


def ridge(
    system: System,
    name: str,
    ends: tuple[float, float],
    range: tuple[float, float],
    output: tuple[str, int],
    harmonics: int,
    points: int = 25,
    journal: Journal | None = None,
) -> Ridge:
    """Follow the peak over a parameter of the interlock, in equal ratios.

    Parameters
    ----------
    system : System
    name : {"mu", "interference"}
    ends : (float, float)
        First and last value.
    range : (float, float)
        Where sweeps look for the peak, Hz.
    output : (str, int)
        Output node and direction.
    harmonics : int
    points : int
        Values of the parameter.
    journal : Journal, optional
        As of `nonlinear.frequency_response`.
    """
    values = np.geomspace(*ends, points)
    try:
        found = nonlinear.peak_response(
            system,
            name,
            values,
            range,
            nonlinear.Options(harmonics),
            output=output,
            joint="interlock",
            journal=journal,
        )
    except InputError as error:  # no peak within the range at the first value
        none = np.full(points, np.nan)
        no = np.zeros(points, bool)
        return Ridge(name, harmonics, values, none, none, no, none, str(error))
    return Ridge(
        name=name,
        harmonics=harmonics,
        parameter=found.parameter,
        amplitude=found.amplitude,
        frequency=found.frequency,
        converged=found.converged,
        second_peak=found.second_peak,
    )
