"""The coupled balance of all harmonics, condensed to the contacts, around the stuck state.

In the contact displacements u, with w their deviation from sticking (`law`) and R̂ = B D̃⁻¹ Bᴴ K_c,

    u^(h) = ũ^(h) + R̂_h w^(h),      ũ^(h) = B D̃_h⁻¹ f^(h),
    ũ^(0) = v₀e_n + B₀ K̃₀⁻¹ (f^(0) - B₀ᴴ K_c v₀e_n),

so the nonlinear equations are w = W(u(w)), one for each component of w that is not zero.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.nonlinear.stuck import StuckModes, stuck_modes
from vanelock.nonlinear.trigonometric import to_complex, to_real
from vanelock.rom.consistency import check
from vanelock.rom.system import System

Array: TypeAlias = NDArray[Any]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Balance:
    """The balance at one frequency.

    Attributes
    ----------
    omega : float
        Excitation's circular frequency, rad/s.
    linear : (c, 3, 2H + 1) float
        ũ, relative displacements with all contacts stuck, m.
    receptance : tuple of (3c, 3c)
        R̂_h for h = 0 ... H.
    """

    omega: float
    linear: Floats
    receptance: tuple[Array, ...]

    def with_mean(self, mean: Floats) -> "Balance":
        """The balance whose mean displacement is held at (c, 3), m, whatever the contacts do."""
        linear = self.linear.copy()
        linear[:, :, 0] = mean
        still = np.zeros_like(self.receptance[0])
        return replace(self, linear=linear, receptance=(still, *self.receptance[1:]))

    def displacement(self, w: Floats) -> Floats:
        """U = ũ + R̂ w, (c, 3, 2H + 1)."""
        columns = np.flatnonzero(w.any(axis=2).reshape(-1))
        if not len(columns):
            return self.linear
        amplitude = to_complex(w.reshape(-1, w.shape[2])[columns])
        moved = np.stack(
            [R[:, columns] @ a for R, a in zip(self.receptance, amplitude, strict=True)]
        )
        u: Floats = self.linear + to_real(moved).reshape(w.shape)
        return u

    def times_receptance(self, functionals: Floats, rows: NDArray[np.int64]) -> Floats:
        """Functionals of the contacts' displacements as functionals of the components of w.

        Parameters
        ----------
        functionals : (r, 3, 2H + 1)
            Each is a linear form of one contact's (v, u1, u2).
        rows : (r,) int
            Indices into w.reshape(-1): the component that each functional belongs to, which
            names its contact, and the components of w for which the result is wanted.

        Returns
        -------
        (r, r) float
        """
        m = functionals.shape[2]
        contact, component, k = rows // (3 * m), rows // m, rows % m
        wanted, place = np.unique(component, return_inverse=True)
        out = np.empty((len(rows), len(rows)))
        for h, R in enumerate(self.receptance):
            own = R[:, wanted].reshape(-1, 3, len(wanted))[contact]
            if h == 0:
                columns = np.flatnonzero(k == 0)
                form = np.einsum("re,rec->rc", functionals[:, :, 0], own.real)
                out[:, columns] = form[:, place[columns]]
                continue
            # a_re Re x + a_im Im x = Re((a_re - i a_im) x)
            weight = functionals[:, :, 2 * h - 1] - 1j * functionals[:, :, 2 * h]
            form = np.matmul(weight[:, None, :], own)[:, 0, :]
            for part, k_part in ((form.real, 2 * h - 1), (-form.imag, 2 * h)):
                columns = np.flatnonzero(k == k_part)
                out[:, columns] = part[:, place[columns]]
        return out


@dataclass(frozen=True)
class Structure:
    """A system prepared for H harmonics: what does not depend on the frequency.

    Attributes
    ----------
    system : System
    harmonics : int
        H.
    nodal_diameters : tuple of int
        ND of each harmonic.
    modes : dict of int to StuckModes
        By nodal diameter.
    """

    system: System
    harmonics: int
    nodal_diameters: tuple[int, ...]
    modes: dict[int, StuckModes]

    def at(self, harmonic: int) -> StuckModes:
        """Stuck modes of a harmonic."""
        return self.modes[self.nodal_diameters[harmonic]]

    @cached_property
    def stiffness(self) -> Floats:
        """K_c, (3c,) N/m."""
        return self.system.contacts.stiffness.reshape(-1)

    @cached_property
    def _interference(self) -> Floats:
        """v₀e_n, (3c,) m."""
        offset = np.zeros((self.system.contacts.count, 3))
        offset[:, 0] = self.system.contacts.v0
        return offset.reshape(-1)

    @cached_property
    def _static_receptance(self) -> Floats:
        rows = self.at(0).rows
        return np.asarray((rows @ rows.T) * self.stiffness)

    @cached_property
    def output_rows(self) -> dict[int, Array]:
        """(o, 3, n) displacements of the output nodes in each mode, by nodal diameter."""
        rows = {}
        for k, modes in self.modes.items():
            output = self.system.at(k).output
            if output is None:
                output = np.zeros((len(self.system.output_names), 3, len(modes.shapes)))
            rows[k] = output @ modes.shapes
        return rows

    def modal_force(self, harmonic: int, omega: float) -> Array:
        """Modal force of the excitation; preload of the interference included at h = 0."""
        modes, force = self.at(harmonic), self.system.force.get(harmonic)
        total = np.zeros(len(modes.compliance), modes.shapes.dtype)
        if force is not None:
            applied = modes.shapes.conj().T @ force.at(omega)
            total = applied.real if harmonic == 0 else applied
        if harmonic == 0:
            total = total - modes.rows.T @ (self.stiffness * self._interference)
        return total

    def linear(self, omega: float) -> Floats:
        """ũ, (c, 3, 2H + 1) m."""
        moved = []
        for h in range(self.harmonics + 1):
            modes = self.at(h)
            moved.append(modes.rows @ modes.solve(h * omega, self.modal_force(h, omega)))
        moved[0] = moved[0] + self._interference
        shape = (self.system.contacts.count, 3, 2 * self.harmonics + 1)
        return to_real(np.stack(moved)).reshape(shape)

    def receptance(self, harmonic: int, omega: float) -> Array:
        """R̂_h, (3c, 3c), by summing all modes."""
        if harmonic == 0:
            return self._static_receptance
        modes = self.at(harmonic)
        return (modes.rows @ modes.solve(harmonic * omega, modes.rows.conj().T)) * self.stiffness

    def balance(self, omega: float) -> Balance:
        """The balance at a circular frequency, rad/s."""
        receptance = tuple(self.receptance(h, omega) for h in range(self.harmonics + 1))
        return Balance(omega, self.linear(omega), receptance)

    def slope(self, omega: float, w: Floats) -> Floats:
        """du/dω at fixed w, (c, 3, 2H + 1)."""
        amplitude = to_complex(w.reshape(-1, w.shape[2]))
        moved = [np.zeros(len(self.stiffness), complex)]
        for h in range(1, self.harmonics + 1):
            modes, s = self.at(h), h * omega
            push = self.modal_force(h, omega) + modes.rows.conj().T @ (
                self.stiffness * amplitude[h]
            )
            changed = -h * modes.slope(s, modes.solve(s, push))
            force = self.system.force.get(h)
            if force is not None and force.omega_power:
                grown = force.at(omega) * (force.omega_power / omega)
                changed = changed + modes.shapes.conj().T @ grown
            moved.append(modes.rows @ modes.solve(s, changed))
        return to_real(np.stack(moved)).reshape(w.shape)

    def amplitudes(self, omega: float, w: Floats) -> list[Array]:
        """Modal amplitudes of every harmonic under the excitation and the deviation w."""
        amplitude = to_complex(w.reshape(-1, w.shape[2]))
        result = []
        for h in range(self.harmonics + 1):
            modes = self.at(h)
            push = modes.rows.conj().T @ (self.stiffness * amplitude[h])
            if h == 0:
                push = push.real
            result.append(modes.solve(h * omega, self.modal_force(h, omega) + push))
        return result

    def output(self, amplitudes: list[Array]) -> NDArray[np.complex128]:
        """(H + 1, o, 3) displacement of the output nodes from modal amplitudes, m."""
        diameters = self.nodal_diameters
        pairs = zip(diameters, amplitudes, strict=True)
        return np.array([self.output_rows[k] @ amplitude for k, amplitude in pairs], complex)


def structure(system: System, harmonics: int, harmonic_diameters: str = "wave") -> Structure:
    """Prepare a system for the balance of `harmonics` harmonics.

    Parameters
    ----------
    system : System
    harmonics : int
        H >= 0.
    harmonic_diameters : {"wave", "sector"}
        Whether harmonic h has the nodal diameter (h·EO) mod N of a travelling wave, or every
        h >= 1 that of the first harmonic (to measure what that assumption costs).

    Raises
    ------
    InputError
        If the system's parts do not fit together, or an option is unknown.
    """
    check(system)
    if harmonics < 0:
        raise InputError(f"harmonics: given {harmonics}: must be >= 0")
    if harmonic_diameters not in ("wave", "sector"):
        raise InputError(
            f"harmonic_diameters: given {harmonic_diameters!r}: allowed are 'wave' and 'sector'"
        )
    wave = harmonic_diameters == "wave"
    diameters = tuple(system.nodal_diameter(h if wave else min(h, 1)) for h in range(harmonics + 1))
    modes = {k: stuck_modes(system, k) for k in sorted(set(diameters))}
    for h, k in enumerate(diameters):
        force = system.force.get(h)
        if force is not None and len(force.vector) != len(modes[k].shapes):
            raise InputError(
                f"system: force/{h} has {len(force.vector)} entries; "
                f"nodal diameter {k} has {len(modes[k].shapes)}"
            )
    return Structure(system, harmonics, diameters, modes)
