"""Fixed-interface modes, K_ss φ = ω² M_ss φ: a number of them, or all below a frequency."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.fem.vibration.block_lanczos import TOLERANCE, KrylovSpace, lowest_modes
from vanelock.rom.system.system import Matrix


@dataclass(frozen=True)
class Fixed:
    """Fixed-interface modes, the lowest ones.

    Attributes
    ----------
    vectors : (s, f)
        Mass-normalised.
    omega_squared : (f,) float
        Ascending, rad²/s².
    complete : float
        Circular frequency up to which no fixed-interface mode is left out, rad/s; infinite where
        the vectors are all there are.
    """

    vectors: Matrix
    omega_squared: NDArray[np.float64]
    complete: float


def fixed_modes(
    space: KrylovSpace,
    count: int | None = None,
    below: float | None = None,
    tolerance: float = TOLERANCE,
) -> Fixed:
    """Lowest fixed-interface modes: a number of them, or all up to a circular frequency."""
    s, most = space.shape
    if count is not None and not 0 <= count <= most:
        raise InputError(
            f"{count} fixed-interface modes of {s} slave dofs: allowed are 0 to {most}"
        )
    highest = np.inf if below is None else below**2
    if count == 0:
        first = lowest_modes(space, 1, highest, tolerance).omega_squared if most else [np.inf]
        return Fixed(space.vectors(np.empty((0, 0))), np.empty(0), float(np.sqrt(first[0])))
    found = lowest_modes(space, count, highest, tolerance)
    all_of_them = len(found.omega_squared) == most
    complete = np.inf if all_of_them else float(np.sqrt(found.beyond))
    return Fixed(found.vectors, found.omega_squared, complete)
