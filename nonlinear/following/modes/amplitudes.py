"""Amplitudes that a mode is asked for, and how far it goes where none are."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import as_array
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.held_vibration import Floats
from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.following.modes.mode_path import ModePath
from vanelock.nonlinear.following.modes.mode_point import ModePoint

BEYOND = 100.0
"""Where a mode ends, of the amplitude at which the last contact of those that may open slips."""
FARTHEST = 1e5
"""Where it ends at the latest, of the amplitude at which the first contact slips or opens."""


def checked_amplitudes(amplitudes: ArrayLike | tuple[float, float] | None) -> Floats | None:
    """(p,) amplitudes, ascending; those of a range are its ends."""
    if amplitudes is None:
        return None
    given = np.atleast_1d(as_array(amplitudes, "amplitudes"))
    if given.ndim != 1 or not len(given) or not np.all(np.isfinite(given) & (given > 0)):
        raise InputError(f"amplitudes: given {given.tolist()}: must be > 0 and finite")
    if isinstance(amplitudes, tuple) and (len(given) != 2 or given[0] >= given[1]):
        raise InputError(f"amplitudes: given {amplitudes}: a range is (low, high), low < high")
    return np.unique(given)


def followed(
    path: ModePath, wanted: Floats | None, is_range: bool, onset: float
) -> Iterator[ModePoint]:
    """Points that are asked for, as the path passes them; it may end before the last one."""
    if wanted is None:
        yield path.last
        yield from until_gross_slip(path, onset)
        return
    for i, amplitude in enumerate(wanted.tolist()):
        if is_range and i:
            yield from path.onward(amplitude)
            return
        for _ in path.onward(amplitude):
            pass
        if not path.arrived:
            return
        yield path.last


def until_gross_slip(path: ModePath, onset: float) -> Iterator[ModePoint]:
    """Points from the first one to well beyond where the last contact of those that may slips."""
    contacts = path.solver.structure.system.contacts
    may = contacts.opens & (contacts.mu > 0)
    farthest = FARTHEST * onset
    for point in path.onward(farthest):
        yield point
        if not np.any(point.solution.deviation.state[may] == STUCK):
            yield from path.onward(min(BEYOND * point.amplitude, farthest))
            return
