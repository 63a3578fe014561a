"""Linear limits of the response: every contact either a spring or open."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike, NDArray

from vanelock.common.arrays import as_whole
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import OPEN, STUCK, Deviation
from vanelock.nonlinear.forced_response.frequencies import checked_frequencies
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN, to_complex, to_real
from vanelock.nonlinear.newton.newton import Solution, scales
from vanelock.rom.system.system import Contacts, System

Closed: TypeAlias = str | Sequence[str] | NDArray[np.bool_]


@one_thread
def linear_response(
    system: System,
    frequencies: ArrayLike,
    closed: Closed = "all",
    harmonics: int = 1,
    modes: Mapping[int, StuckModes] | None = None,
) -> Response:
    """Response with some contacts acting as linear springs and the others open.

    The damping is that of the structure with its joints as `System.damping_joints` says, whatever
    `closed` says, so that free, stuck and nonlinear responses differ by their contacts alone.

    Parameters
    ----------
    system : System
    frequencies : (p,) array_like
        Hz.
    closed : (c,) bool, or joint names, or "all", or "none"
        Contacts that act as springs, in tension too, with their interference; elements never do.
    harmonics : int
        H.
    modes : dict of int to StuckModes, optional
        As of `frequency_response`.

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
    mask = closed_contacts(system.contacts, closed)
    hertz = checked_frequencies(frequencies)
    options = Options(as_whole(harmonics, "harmonics"))
    ready = options.prepare(system, hertz, len(hertz), modes)
    return ready.response([_solve(ready.source.balance(omega), mask) for omega in TURN * hertz])


def closed_contacts(contacts: Contacts, closed: Closed) -> NDArray[np.bool_]:
    """(c,) mask of the contacts that `closed` names, elements never among them.

    Raises
    ------
    InputError
        If a joint is unknown or the mask has the wrong length.
    """
    if isinstance(closed, str) and closed in ("all", "none"):
        return contacts.springs & (closed == "all")
    names = [closed] if isinstance(closed, str) else closed
    if isinstance(names, Iterable) and all(isinstance(name, str) for name in names):
        for name in names:
            if name not in contacts.joint:
                known = ", ".join(sorted(set(contacts.joint))) or "none named"
                raise InputError(f"closed: given {name!r}: joints are {known}, or 'all', 'none'")
        mask = np.array([joint in names for joint in contacts.joint], bool)
        return np.asarray(mask & contacts.springs)
    mask = np.asarray(closed)
    if mask.dtype != bool or mask.shape != (contacts.count,):
        raise InputError(
            f"closed: given {mask.dtype} of shape {mask.shape}: needs bool, ({contacts.count},)"
        )
    return np.asarray(mask & contacts.springs)


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
