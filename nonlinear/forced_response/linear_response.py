"""Linear limits of the response: every contact either a spring or open."""

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike, NDArray

from vanelock.common.arrays import as_array
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Balance, structure
from vanelock.nonlinear.balance.receptance_tables import balances
from vanelock.nonlinear.contact.law import OPEN, STUCK, Deviation
from vanelock.nonlinear.forced_response.response import Response, assemble_response
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN, to_complex, to_real
from vanelock.nonlinear.newton.newton import Solution, scales
from vanelock.rom.system import Contacts, System, wider_band

ROUND_OFF = 1e-9
"""By which a frequency may exceed a band."""
Closed: TypeAlias = str | Sequence[str] | NDArray[np.bool_]


@one_thread
def linear_response(
    system: System, frequencies: ArrayLike, closed: Closed = "all", harmonics: int = 1
) -> Response:
    """Response with some contacts acting as linear springs and the others open.

    The damping is that of the structure with all contacts stuck, whatever `closed` says, so that
    free, stuck and nonlinear responses differ by their contacts alone.

    Parameters
    ----------
    system : System
    frequencies : (p,) array_like
        Hz.
    closed : (c,) bool, or joint names, or "all", or "none"
        Contacts that act as springs, in tension too, with their interference.
    harmonics : int
        H.

    Returns
    -------
    Response
        With `state` STUCK for the springs and OPEN for the others.

    Raises
    ------
    InputError
        If the mask or a joint does not fit, a static load is not held by what is closed, or a
        harmonic above H is excited.
    """
    prepared = structure(system, harmonics)
    check_forces(system, harmonics)
    mask = closed_contacts(system.contacts, closed)
    hertz = checked_frequencies(frequencies)
    check_band(system, hertz)
    omegas = TURN * hertz
    source = balances(prepared, float(omegas.min()), float(omegas.max()), len(omegas))
    return assemble_response(prepared, [_solve(source.balance(omega), mask) for omega in omegas])


def checked_frequencies(frequencies: ArrayLike) -> NDArray[np.float64]:
    """(p,) Hz, positive and finite.

    Raises
    ------
    InputError
        If they are not.
    """
    hertz = np.atleast_1d(as_array(frequencies, "frequencies"))
    if hertz.ndim != 1 or not len(hertz):
        raise InputError(f"frequencies: given shape {hertz.shape}: needs a list of at least one")
    if not np.all(np.isfinite(hertz)) or np.any(hertz <= 0):
        raise InputError(f"frequencies: given {hertz.min()} Hz: must be > 0 and finite")
    return hertz


def checked_range(frequencies: ArrayLike, name: str = "frequencies") -> NDArray[np.float64]:
    """(2,) Hz, a range.

    Raises
    ------
    InputError
        If it is none.
    """
    hertz = checked_frequencies(frequencies)
    if len(hertz) != 2 or hertz[0] >= hertz[1]:
        raise InputError(f"{name}: given {tuple(hertz)}: a range is (low, high), low < high")
    return hertz


def check_band(system: System, hertz: ArrayLike) -> None:
    """Refuse frequencies beyond those that a system's reduced parts answer.

    Parameters
    ----------
    system : System
    hertz : (p,) array_like
        Frequencies of the excitation; their higher harmonics may lie beyond.

    Raises
    ------
    InputError
        Naming the frequency and the band.
    """
    highest = float(np.max(hertz))
    if system.band is not None and highest > system.band * (1 + ROUND_OFF):
        raise InputError(
            f"frequencies: given {highest:.6g} Hz: the system's reduced parts answer up to "
            f"{system.band:.6g} Hz (its band): reduce them with band = {wider_band(highest):g}"
        )


def check_option(name: str, given: str, allowed: Iterable[str]) -> None:
    """Refuse an option that is not among those allowed.

    Raises
    ------
    InputError
        Naming it.
    """
    if given not in allowed:
        raise InputError(f"{name}: given {given!r}: allowed: {', '.join(allowed)}")


def check_forces(system: System, harmonics: int) -> None:
    """Refuse a system that is excited at a harmonic beyond those of the balance.

    Raises
    ------
    InputError
        Naming the force.
    """
    if (most := max(excited(system), default=0)) > harmonics:
        raise InputError(
            f"harmonics: given {harmonics}: the system has force/{most}; needs at least {most}"
        )


def excited(system: System) -> list[int]:
    """Harmonics that a force acts at."""
    return [h for h, force in sorted(system.force.items()) if np.any(force.vector)]


def closed_contacts(contacts: Contacts, closed: Closed) -> NDArray[np.bool_]:
    """(c,) mask of the contacts that `closed` names.

    Raises
    ------
    InputError
        If a joint is unknown or the mask has the wrong length.
    """
    if isinstance(closed, str) and closed in ("all", "none"):
        return np.full(contacts.count, closed == "all")
    names = [closed] if isinstance(closed, str) else closed
    if isinstance(names, Iterable) and all(isinstance(name, str) for name in names):
        for name in names:
            if name not in contacts.joint:
                known = ", ".join(sorted(set(contacts.joint))) or "none named"
                raise InputError(f"closed: given {name!r}: joints are {known}, or 'all', 'none'")
        return np.array([joint in names for joint in contacts.joint], bool)
    mask = np.asarray(closed)
    if mask.dtype != bool or mask.shape != (contacts.count,):
        raise InputError(
            f"closed: given {mask.dtype} of shape {mask.shape}: needs bool, ({contacts.count},)"
        )
    return mask


def _solve(balance: Balance, closed: NDArray[np.bool_]) -> Solution:
    """One frequency: an open contact has w = u, so u = ũ + R̂ w is a linear system for those."""
    c = len(closed)
    rows = np.flatnonzero(np.repeat(~closed, 3))
    linear = to_complex(balance.linear.reshape(3 * c, balance.linear.shape[2]))
    w = np.zeros_like(linear)
    balance.columns.hold(rows)
    for h, R in enumerate(balance.columns.held):
        matrix = np.eye(len(rows)) - R[np.ix_(balance.columns.place[rows], rows)].T
        right = linear[h, rows].real if h == 0 else linear[h, rows]
        w[h, rows] = _consistent(matrix, right) if h == 0 else la.solve(matrix, right)
    real = to_real(w).reshape(balance.linear.shape)
    u = balance.displacement(real)
    gap = real - np.where(closed[:, None, None], 0.0, u)
    # Near a resonance of the open structure u is far larger than ũ, and so is its rounding.
    scale = np.maximum(scales(balance.linear), scales(u))
    residual = float(np.abs(gap / scale).max(initial=0.0))
    deviation = Deviation(real, np.empty(0), np.where(closed, STUCK, OPEN), np.zeros(c))
    return Solution(balance.omega, balance.omega, real, u, residual, 1, residual < 1e-8, deviation)


def _consistent(matrix: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve a static system that may leave free motions, if nothing drives them."""
    if not len(right):
        return right
    solution = la.lstsq(matrix, right, cond=1e-12)[0]
    missing = np.abs(matrix @ solution - right).max()
    if missing > 1e-8 * max(np.abs(right).max(), np.finfo(float).tiny):
        raise InputError("closed: these contacts do not hold the static load")
    return np.asarray(solution)
