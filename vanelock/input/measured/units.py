"""What files of measured curves say, in SI, before the study's own keys are heard; their units."""

from dataclasses import dataclass

import numpy as np

from vanelock.common.arrays import Floats

DISPLACEMENT, STRAIN = "displacement", "strain"
TURN = 2 * np.pi
UNITS = {
    "frequency": {"Hz": 1.0, "kHz": 1e3, "1/s": 1.0, "rad/s": 1 / TURN},
    "speed": {
        "rpm": 1.0, "1/min": 1.0, "min-1": 1.0, "rev/min": 1.0, "krpm": 1e3,
        "1/s": 60.0, "rev/s": 60.0, "Hz": 60.0, "rad/s": 60 / TURN,
    },
}  # fmt: skip
"""In Hz and rpm. Not by a library of units, to which a revolution is 2π."""
STRAINS = {"ustrain": 1e-6, "microstrain": 1e-6, "µε": 1e-6, "με": 1e-6, "1": 1.0, "-": 1.0}


@dataclass(frozen=True)
class Points:
    """Points of a measured curve, in the file's order.

    Attributes
    ----------
    frequency, amplitude : (p,) float
        Hz, and half the peak-to-peak, m or strain; NaN where the file has nothing.
    quantity : str
        "displacement" or "strain".
    factor : (p,) float
        What one unit of the file's own amplitudes is there, in which the study gives a `sigma`.
    sigma : (p,) float or None
        Standard deviation of each amplitude, where the file has it.
    """

    frequency: Floats
    amplitude: Floats
    quantity: str
    factor: Floats
    sigma: Floats | None = None
