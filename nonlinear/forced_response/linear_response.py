"""Linear limits of the response: every contact either a spring or open."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike, NDArray

from vanelock.common.arrays import as_whole
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Array, Balance, Structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import OPEN, STUCK, Deviation
from vanelock.nonlinear.forced_response.frequencies import checked_frequencies
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.forced_response.static_mean import static_part
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN, to_complex, to_real
from vanelock.nonlinear.newton.newton import Solution, scales
from vanelock.rom.system.system import Contacts, System

Floats = NDArray[np.float64]
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
    limit = _Limit(ready.structure, mask)
    found = [limit.at(float(omega), ready.source) for omega in TURN * hertz]
    return ready.response(found, amplitudes=limit.amplitudes)


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


@dataclass(frozen=True)
class _Limit:
    """Contacts that are springs or open, in a structure.

    Attributes
    ----------
    structure : Structure
    closed : (c,) bool
    """

    structure: Structure
    closed: NDArray[np.bool_]

    @cached_property
    def _open(self) -> NDArray[np.int64]:
        """Components of open contacts."""
        return np.flatnonzero(np.repeat(~self.closed, 3))

    @cached_property
    def _by_modes(self) -> bool:
        """Whether the modes that damping is of are those of this very limit."""
        structure = self.structure
        every = [structure.modes[k] for k in structure.nodal_diameters[1:]]
        return bool(len(self._open)) and all(
            each.coupled_damping is None and np.array_equal(each.opened, self._open)
            for each in every
        )

    def amplitudes(self, omega: float, w: Floats) -> list[Array]:
        """Modal amplitudes of every harmonic, once `w` is known."""
        structure = self.structure
        if not self._by_modes:
            return structure.amplitudes(omega, w)
        return [
            self._static.amplitudes(omega, w[:, :, :1])[0],
            *(self._alone(h, omega) for h in range(1, structure.harmonics + 1)),
        ]

    def _alone(self, harmonic: int, omega: float) -> Array:
        """Amplitudes of the modes of the open structure, each of which stands alone."""
        push = self.structure.modal_force(harmonic, omega)
        return push / self.structure.at(harmonic).dynamic(harmonic * omega)

    @cached_property
    def _static(self) -> Structure:
        """The structure at rest, whose modes and receptances are kept for all frequencies."""
        return static_part(self.structure)

    @cached_property
    def _still(self) -> Floats:
        """(3c,) w at rest, for a static load that does not depend on the frequency."""
        return self._at_rest(self._static.balance(0.0))

    def _at_rest(self, balance: Balance) -> Floats:
        """(3c,) w at rest."""
        rows, linear = self._open, balance.linear[:, :, 0].reshape(-1)
        w = np.zeros(len(linear))
        balance.columns.hold(rows)
        R = balance.columns.held[0][np.ix_(balance.columns.place[rows], rows)].real
        w[rows] = _consistent(np.eye(len(rows)) - R.T, linear[rows])
        return w

    def at(self, omega: float, source: Structure | Tabulated) -> Solution:
        """One frequency: an open contact has w = u, so u = ũ + R̂ w is a linear system for those.

        In the modes of the open structure nothing has to be solved.
        """
        structure, rows = self.structure, self._open
        force = structure.system.force.get(0)
        varies = force is not None and force.omega_power
        if self._by_modes and not varies:
            w = np.zeros((structure.harmonics + 1, len(structure.stiffness)), complex)
            u, w[0], shape = w.copy(), self._still, (len(self.closed), 3, -1)
            u[0] = self._static.balance(0.0).displacement(self._still.reshape(shape)).reshape(-1)
            for h in range(1, structure.harmonics + 1):
                u[h] = structure.at(h).rows @ self._alone(h, omega)
                w[h, rows] = u[h, rows]
            return self._solution(omega, to_real(w).reshape(shape), to_real(u).reshape(shape), 0.0)
        balance = source.balance(omega)
        linear = to_complex(balance.linear.reshape(-1, balance.linear.shape[2]))
        w = np.zeros_like(linear)
        w[0] = self._at_rest(self._static.balance(omega)) if varies else self._still
        balance.columns.hold(rows)
        for h, R in enumerate(balance.columns.held[1:], 1):
            matrix = np.eye(len(rows)) - R[np.ix_(balance.columns.place[rows], rows)].T
            w[h, rows] = la.solve(matrix, linear[h, rows])
        real = to_real(w).reshape(balance.linear.shape)
        return self._solution(omega, real, balance.displacement(real), scales(balance.linear))

    def _solution(self, omega: float, w: Floats, u: Floats, least: Floats | float) -> Solution:
        """What is solved, and how well."""
        gap = w - np.where(self.closed[:, None, None], 0.0, u)
        # Near a resonance of the open structure u is far larger than ũ, and so is its rounding.
        scale = np.maximum(least, scales(u))
        residual = float(np.abs(gap / scale).max(initial=0.0))
        state = np.where(self.closed, STUCK, OPEN)
        deviation = Deviation(w, np.empty(0), state, np.zeros(len(self.closed)))
        return Solution(omega, omega, w, u, residual, 1, residual < 1e-8, deviation)


def _consistent(matrix: Floats, right: Floats) -> Floats:
    """Solve a static system that may leave free motions, if nothing drives them."""
    if not len(right):
        return right
    solution = la.lstsq(matrix, right, cond=1e-12)[0]
    missing = np.abs(matrix @ solution - right).max()
    if missing > 1e-8 * max(np.abs(right).max(), np.finfo(float).tiny):
        raise InputError("closed: these contacts do not hold the static load")
    return np.asarray(solution)
