"""Linear limits of the response: every contact either a spring or open.

Where at most friction damps a system, nothing may bound a resonance. At the natural frequency of a
mode φ whose contacts slide, the harmonic of a friction force, 4/π μ n at most, is all that can hold
the load f. No vibration is steady there where

    |φᴴ f| > 4/π Σ μ n |φ_t|,

if φ moves no contact in its normal direction, and every n that counts stays as it is. Elsewhere
there is no more to see than that a largest amplitude is not found.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import TypeAlias

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Booleans, Floats, Integers, as_whole
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.limit_modes import limit_modes, times
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import OPEN, STUCK, Deviation
from vanelock.nonlinear.forced_response.options import Options, checked_frequencies, static_part
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import TURN, one_thread, to_real
from vanelock.nonlinear.newton.newton import Solution, scales
from vanelock.rom.system.system import Contacts, System

_Closed: TypeAlias = str | Sequence[str] | Booleans


@one_thread
def linear_response(
    system: System,
    frequencies: ArrayLike,
    closed: _Closed = "all",
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
    ready = options.prepare(system, hertz, 0, modes)  # without tables
    omegas, opened = TURN * hertz, np.flatnonzero(np.repeat(~mask, 3))
    vibration, static = _vibration(ready.structure, mask, omegas), static_part(ready.structure)
    place = {omega: i for i, omega in enumerate(omegas.tolist())}
    force, shape = system.force.get(0), (len(mask), 3, 2 * options.highest + 1)
    grows = force is not None and force.omega_power
    still = lru_cache(None)(lambda omega: _at_rest(static.balance(omega), opened))

    def point(i: int, omega: float) -> Solution:
        """One frequency: an open contact has w = u; those at rest are a linear system."""
        w, worst = np.zeros((options.highest + 1, 3 * len(mask)), complex), 0.0
        u = w.copy()
        w[0], u[0] = still(omega if grows else 0.0)
        for h, (_, left, moved) in enumerate(vibration, 1):
            u[h] = moved[:, i]
            w[h, opened] = u[h, opened]
            worst = max(worst, float(left[i]))
        deviation, moved = (to_real(each).reshape(shape) for each in (w, u))
        gap = deviation - np.where(mask[:, None, None], 0.0, moved)
        residual = max(worst, float(np.abs(gap / scales(moved)).max(initial=0.0)))
        state = np.where(mask, STUCK, OPEN)
        found = Deviation(deviation, np.empty(0), state, np.zeros(len(mask)))
        return Solution(omega, omega, deviation, moved, residual, 1, residual < 1e-8, found)

    def amplitudes(omega: float, w: Floats) -> list[Array]:
        """Modal amplitudes of every harmonic, once w is known."""
        at_rest = static.amplitudes(omega, w[:, :, :1])[0]
        return [at_rest, *(each[:, place[omega]] for each, _, _ in vibration)]

    found = [point(i, omega) for i, omega in enumerate(omegas.tolist())]
    return ready.response(found, amplitudes)


def closed_contacts(contacts: Contacts, closed: _Closed) -> Booleans:
    """(c,) mask of the contacts that `closed` names, elements never among them."""
    if isinstance(closed, str) and closed in ("all", "none"):
        return contacts.springs & (closed == "all")
    names = [closed] if isinstance(closed, str) else closed
    if isinstance(names, Iterable) and all(isinstance(name, str) for name in names):
        for name in names:
            if name not in contacts.joint:
                known = ", ".join(sorted(set(contacts.joint))) or "none named"
                raise InputError(f"closed: given {name!r}: joints are {known}, or 'all', 'none'")
        mask = np.array([joint in names for joint in contacts.joints], bool)
        return np.asarray(mask & contacts.springs)
    mask = np.asarray(closed)
    if mask.dtype != bool or mask.shape != (contacts.count,):
        raise InputError(
            f"closed: given {mask.dtype} of shape {mask.shape}: needs bool, ({contacts.count},)"
        )
    return np.asarray(mask & contacts.springs)


def _vibration(
    structure: Structure, closed: Booleans, omegas: Floats
) -> list[tuple[Array, Floats, Array]]:
    """Of each harmonic h >= 1, which depends on no other, at all frequencies (f,), rad/s.

    Amplitudes (n, f), what is left of their balances (f,), and displacements (3c, f), m.
    """
    springs, found = np.repeat(closed, 3), []
    limits = {
        k: structure.modes[k].closed
        if springs.all()
        else limit_modes(structure.modes[k], structure.stiffness, springs)
        for k in set(structure.nodal_diameters[1:])
    }
    for h, k in enumerate(structure.nodal_diameters[1:], 1):
        push = np.stack([structure.modal_force(h, omega) for omega in omegas.tolist()], axis=1)
        amplitudes, left = limits[k].solve(h * omegas, push)
        found.append((amplitudes, left, times(structure.at(h).rows, amplitudes)))
    return found


def _at_rest(balance: Balance, opened: Integers) -> tuple[Floats, Floats]:
    """(3c,) w and u at rest, these components open."""
    linear = balance.linear[:, :, 0].reshape(-1)
    w = np.zeros(len(linear))
    balance.columns.hold(opened)
    R = balance.columns.held[0][np.ix_(balance.columns.place[opened], opened)].real
    w[opened] = _consistent(np.eye(len(opened)) - R.T, linear[opened])
    return w, balance.displacement(w.reshape(-1, 3, 1)).reshape(-1)


def _consistent(matrix: Floats, right: Floats) -> Floats:
    """Solve a static system that may leave free motions, if nothing drives them."""
    if not len(right):
        return right
    solution = la.lstsq(matrix, right, cond=1e-12)[0]
    missing = np.abs(matrix @ solution - right).max()
    if missing > 1e-8 * max(np.abs(right).max(), np.finfo(float).tiny):
        raise InputError("closed: these contacts do not hold the static load")
    return np.asarray(solution)


_SMALL = 1e-9  # of the largest, what counts as none of loads and motions
_LEAST = 1e-2  # of the load's work, friction's at a top that it holds: there it is all, or nearly


def check_bound(
    structure: Structure,
    limits: tuple[float, float],
    output: tuple[int, int] | None,
    what: str,
    lost: float | None = None,
) -> None:
    """Refuse a range, rad/s, in which friction does not bound a resonance of an output, or of any.

    Where a largest amplitude is `lost`, rad/s, refuse that friction alone may bound it, too.
    """
    if unheld := unbound(structure, limits, output):
        omega, why = unheld[0], f"friction holds {unheld[1]:.3g} of its load at most"
    elif lost is not None and not _damped(structure.system):
        omega, why = lost, "friction alone may not bound it"
    else:
        return
    raise InputError(
        f"{what}: near {omega / TURN:.6g} Hz it grows without damping, and {why}; "
        "give damping, less load, or another range"
    )


def check_top(structure: Structure, response: Response, output: tuple[int, int], what: str) -> None:
    """Refuse a largest amplitude inside a range that neither damping nor friction holds.

    At a resonance that is bounded the load's work, π Σ h |f_h x_h| at most, is that of friction; a
    top at which friction does next to none is a point beside a pole.
    """
    sizes = np.where(response.converged, response.amplitude[:, *output], 0.0)
    top, system = int(sizes.argmax()), structure.system
    if _damped(system) or top in (response.frequency.argmin(), response.frequency.argmax()):
        return
    omega = TURN * float(response.frequency[top])
    work = np.pi * sum(
        h * abs(np.vdot(force.at(omega), response.x[h][top]))
        for h, force in system.force.items()
        if h
    )
    if response.dissipation[top].sum() < _LEAST * work:
        limits = TURN * response.frequency
        check_bound(structure, (limits.min(), limits.max()), output, what, omega)


def unbound(
    structure: Structure, limits: tuple[float, float], output: tuple[int, int] | None
) -> tuple[float, float] | None:
    """A resonance that friction does not bound, rad/s, and the largest share of f that it holds."""
    if _damped(structure.system):
        return None
    contacts, count = structure.system.contacts, structure.system.contacts.count
    normal = np.stack([abs(modes.rows[::3]).max(axis=1) for modes in structure.modes.values()])
    limit = contacts.mu * contacts.kn * contacts.v0.clip(0)
    limit[normal.any(axis=0) & (contacts.mu > 0)] = np.inf
    for h in filter(None, structure.unit_forces):
        modes, power = structure.at(h), structure.system.force[h].omega_power
        sliding = limit_modes(modes, structure.stiffness, np.tile([True, False, False], count))
        shapes = np.eye(len(modes.static)) if sliding.shapes is None else sliding.shapes
        with np.errstate(divide="ignore", invalid="ignore"):
            omega = np.sqrt(sliding.static / sliding.compliance) / h
        moved = _counted(modes.rows @ shapes).reshape(count, 3, shapes.shape[1])
        friction = np.where(moved[:, 1:] > 0, limit[:, None, None], 0.0) * moved[:, 1:]
        hold = 4 / np.pi * friction.sum(axis=(0, 1))
        push = _counted(shapes.conj().T @ structure.unit_forces[h]) * omega**power
        seen = _counted(structure.output_rows[h] @ shapes)
        seen = seen.max(axis=(0, 1)) if output is None else seen[output]
        within = (omega >= min(limits)) & (omega <= max(limits)) & ~moved[:, 0].any(axis=0)
        for i in np.flatnonzero(within & (seen > 0) & (push > (1 + _SMALL) * hold)):
            return float(omega[i]), float(hold[i] / push[i])
    return None


def _counted(moved: Array) -> Floats:
    """Their sizes, but for those that round-off leaves."""
    sizes = np.abs(moved)
    return np.where(sizes < _SMALL * sizes.max(initial=0.0), 0.0, sizes)


def _damped(system: System) -> bool:
    """Whether more than friction damps a system."""
    if system.damping_ratio or system.contacts.elements:
        return True
    return any(each.C is not None and bool(np.any(each.C)) for each in system.diameters.values())
