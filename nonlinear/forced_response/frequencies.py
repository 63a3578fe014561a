"""Frequencies that a response may be asked for."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock.common.arrays import as_array
from vanelock.common.errors import InputError
from vanelock.rom.system.system import System, wider_band

ROUND_OFF = 1e-9
"""By which a frequency may exceed a band."""


def checked_frequencies(frequencies: ArrayLike) -> NDArray[np.float64]:
    """(p,) Hz, positive and finite."""
    hertz = np.atleast_1d(as_array(frequencies, "frequencies"))
    if hertz.ndim != 1 or not len(hertz):
        raise InputError(f"frequencies: given shape {hertz.shape}: needs a list of at least one")
    if not np.all(np.isfinite(hertz)) or np.any(hertz <= 0):
        raise InputError(f"frequencies: given {hertz.min()} Hz: must be > 0 and finite")
    return hertz


def checked_range(frequencies: ArrayLike, name: str = "frequencies") -> NDArray[np.float64]:
    """(2,) Hz, a range."""
    hertz = checked_frequencies(frequencies)
    if len(hertz) != 2 or hertz[0] >= hertz[1]:
        raise InputError(f"{name}: given {tuple(hertz)}: a range is (low, high), low < high")
    return hertz


def check_band(system: System, hertz: ArrayLike) -> None:
    """Refuse frequencies beyond those that a system's reduced parts answer."""
    highest = float(np.max(hertz))
    if system.band is not None and highest > system.band * (1 + ROUND_OFF):
        raise InputError(
            f"frequencies: given {highest:.6g} Hz: the system's reduced parts answer up to "
            f"{system.band:.6g} Hz (its band): reduce them with band = {wider_band(highest):g}"
        )
