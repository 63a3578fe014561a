"""Linear limits of the response: every contact either a spring or open.

Where at most friction damps a system, nothing may bound a resonance. At the natural frequency of a
mode φ whose contacts slide, the harmonic of a friction force, 4/π μ n at most, is all that can hold
the load f. No vibration is steady there where

    |φᴴ f| > 4/π Σ μ n |φ_t|,

if φ moves no contact in its normal direction, and every n that counts stays as it is. Elsewhere
there is no more to see than that a largest amplitude is not found.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Booleans, Floats, Integers, as_whole
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.limit_modes import LimitModes, limit_modes, times
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
    limit = _Limit(ready.structure, mask, tuple((TURN * hertz).tolist()))
    found = [limit.at(omega) for omega in limit.omegas]
    return ready.response(found, amplitudes=limit.amplitudes)


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
        mask = np.array([joint in names for joint in contacts.joint], bool)
        return np.asarray(mask & contacts.springs)
    mask = np.asarray(closed)
    if mask.dtype != bool or mask.shape != (contacts.count,):
        raise InputError(
            f"closed: given {mask.dtype} of shape {mask.shape}: needs bool, ({contacts.count},)"
        )
    return np.asarray(mask & contacts.springs)


@dataclass(frozen=True)
class _Limit:
    """Contacts that are springs or open, in a structure.

    `closed` (c,); `omegas`: frequencies, rad/s, that are solved together.
    """

    structure: Structure
    closed: Booleans
    omegas: tuple[float, ...]

    @cached_property
    def _open(self) -> Integers:
        """Components of open contacts."""
        return np.flatnonzero(np.repeat(~self.closed, 3))

    @cached_property
    def _modes(self) -> dict[int, LimitModes]:
        """Of the nodal diameters that vibrate."""
        every, closed = self.structure, np.repeat(self.closed, 3)
        return {
            k: every.modes[k].closed
            if closed.all()
            else limit_modes(every.modes[k], every.stiffness, closed)
            for k in set(every.nodal_diameters[1:])
        }

    def amplitudes(self, omega: float, w: Floats) -> list[Array]:
        """Modal amplitudes of every harmonic, once `w` is known."""
        still = self._static.amplitudes(omega, w[:, :, :1])[0]
        vibrating = range(1, self.structure.harmonics + 1)
        return [still, *(self._alone[h][0][:, self._place[omega]] for h in vibrating)]

    @cached_property
    def _place(self) -> dict[float, int]:
        return {omega: i for i, omega in enumerate(self.omegas)}

    @cached_property
    def _alone(self) -> dict[int, tuple[Array, Floats, Array]]:
        """Of each harmonic h >= 1, which depends on no other.

        Amplitudes (n, f), what is left of their balances (f,), and displacements (3c, f), m.
        """
        structure, found = self.structure, {}
        for h in range(1, structure.harmonics + 1):
            push = np.stack([structure.modal_force(h, omega) for omega in self.omegas], axis=1)
            modes = self._modes[structure.nodal_diameters[h]]
            amplitudes, left = modes.solve(h * np.array(self.omegas), push)
            found[h] = amplitudes, left, times(structure.at(h).rows, amplitudes)
        return found

    @cached_property
    def _static(self) -> Structure:
        """The structure at rest, whose modes and receptances are kept for all frequencies."""
        return static_part(self.structure)

    @cached_property
    def _still(self) -> tuple[Floats, Floats]:
        """At rest, for a static load that does not depend on the frequency."""
        return self._at_rest(self._static.balance(0.0))

    def _at_rest(self, balance: Balance) -> tuple[Floats, Floats]:
        """(3c,) w and u at rest."""
        rows, linear = self._open, balance.linear[:, :, 0].reshape(-1)
        w = np.zeros(len(linear))
        balance.columns.hold(rows)
        R = balance.columns.held[0][np.ix_(balance.columns.place[rows], rows)].real
        w[rows] = _consistent(np.eye(len(rows)) - R.T, linear[rows])
        return w, balance.displacement(w.reshape(len(self.closed), 3, 1)).reshape(-1)

    def at(self, omega: float) -> Solution:
        """One frequency: an open contact has w = u; those at rest are a linear system."""
        structure, rows = self.structure, self._open
        force = structure.system.force.get(0)
        varies = force is not None and force.omega_power
        w = np.zeros((structure.harmonics + 1, len(structure.stiffness)), complex)
        u, shape, worst = w.copy(), (len(self.closed), 3, 2 * structure.harmonics + 1), 0.0
        w[0], u[0] = self._at_rest(self._static.balance(omega)) if varies else self._still
        for h in range(1, structure.harmonics + 1):
            _, left, u_h = self._alone[h]
            u[h] = u_h[:, self._place[omega]]
            w[h, rows] = u[h, rows]
            worst = max(worst, float(left[self._place[omega]]))
        deviation, moved = to_real(w).reshape(shape), to_real(u).reshape(shape)
        gap = deviation - np.where(self.closed[:, None, None], 0.0, moved)
        residual = max(worst, float(np.abs(gap / scales(moved)).max(initial=0.0)))
        state = np.where(self.closed, STUCK, OPEN)
        found = Deviation(deviation, np.empty(0), state, np.zeros(len(self.closed)))
        return Solution(omega, omega, deviation, moved, residual, 1, residual < 1e-8, found)


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
