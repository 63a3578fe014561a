"""What a file of a measured curve says, in SI, before the study's own keys are heard."""

from dataclasses import dataclass

from vanelock.common.arrays import Floats


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
