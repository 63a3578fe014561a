"""What a structure is asked to do for a number of cycles: a frequency, or the peak of a range."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arrays import as_array
from vanelock.common.errors import InputError
from vanelock.nonlinear.forced_response.frequencies import checked_frequencies, checked_range

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Dwell:
    """Vibration that stays at one frequency, or at the peak of a resonance wherever that moves.

    Attributes
    ----------
    cycles : float
        Periods of the excitation.
    frequency : float, optional
        Hz; or else:
    near : (float, float), optional
        Range of frequencies, Hz, whose highest peak is dwelt at.
    force : float
        Factor of the excitation of all harmonics h >= 1; the static load stays.

    Raises
    ------
    InputError
        If a number is impossible, or not one of frequency and range is given.
    """

    cycles: float
    frequency: float | None = None
    near: tuple[float, float] | None = None
    force: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        for name in ("cycles", "force"):
            object.__setattr__(self, name, positive(getattr(self, name), f"Dwell.{name}"))
        if (self.frequency is None) == (self.near is None):
            given = "none" if self.near is None else "both"
            raise InputError(f"Dwell: given {given} of frequency and near: needs one of them")
        if self.frequency is not None:
            object.__setattr__(self, "frequency", positive(self.frequency, "Dwell.frequency"))
        if self.near is not None:
            ends = as_array(self.near, "Dwell.near")
            if ends.shape != (2,) or not (np.isfinite(ends).all() and 0 < ends[0] < ends[1]):
                raise InputError(
                    f"Dwell.near: given {self.near!r}: a range is (low, high), 0 < low < high, Hz"
                )
            object.__setattr__(self, "near", tuple(ends.tolist()))

    @property
    def at_peak(self) -> bool:
        """Whether it is dwelt at a peak."""
        return self.near is not None

    @property
    def hertz(self) -> Floats:
        """The frequency or the range, Hz."""
        if self.near is not None:
            return checked_range(self.near)
        assert self.frequency is not None
        return checked_frequencies(self.frequency)

    def continues(self, before: "Dwell") -> bool:
        """Whether the vibration goes on as in the dwell before."""
        return (self.frequency, self.near, self.force) == (
            before.frequency,
            before.near,
            before.force,
        )


def positive(given: object, name: str) -> float:
    """A number > 0."""
    found = as_array(given, name)
    if found.shape != () or not (np.isfinite(found) and found > 0):
        raise InputError(f"{name}: given {given!r}: must be one number > 0 and finite")
    return float(found)


def checked_dwells(dwells: Dwell | Sequence[Dwell]) -> tuple[Dwell, ...]:
    """One dwell or several as a tuple."""
    given = (dwells,) if isinstance(dwells, Dwell) else dwells
    if not given:
        raise InputError(f"dwells: given {dwells!r}: needs a Dwell, or a list of them")
    return tuple(given)
