"""The linear ring of all sectors, its contacts stuck.

The coordinates of sector j are x_j = Σ_k X_k e^{-2πikj/N}, k = 0 ... N - 1. They are real, so
X_{N-k} is the conjugate of X_k and half of the diameters suffice:

    x_j = Re Σ_k m_k X_k e^{-2πikj/N},   k = 0 ... ⌊N/2⌋,   m_k = 1 where k = N - k, otherwise 2.

With the modes of the stuck structure (`stuck_modes`) the motion is X_k = V_k (a_k + y_k), where a_k
is the steady linear vibration with every contact stuck, known in closed form, and y_k answers to
the deviations w_j of the contacts from sticking,

    Λ y_k'' + D y_k' + A y_k = b_kᴴ K_c W_k,      W_k = 1/N Σ_j w_j e^{2πikj/N}.

Contacts that are open in the modes pull with w_j less the displacement that is y_k's.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vanelock.common.arrays import Array, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.stuck_modes import StuckModes, check_uncoupled, stuck_modes
from vanelock.rom.system.coordinates import ROUND_OFF, check, check_ring
from vanelock.rom.system.system import Diameter, System


@dataclass(frozen=True)
class FullRing:
    """A ring, or a sector that stands for all where all move alike.

    `sectors`: sectors that are followed: N, or 1; `diameters`: k = 0 ... ⌊N/2⌋, or 0 alone;
    `modes`: by diameter; `shift` (k, N): e^{-2πikj/N}; `weight` (k,): m_k.
    """

    system: System
    sectors: int
    diameters: tuple[int, ...]
    modes: tuple[StuckModes, ...]
    shift: Complex
    weight: Floats

    @property
    def stiffness(self) -> Floats:
        """K_c, (3c,) N/m."""
        return self.system.contacts.stiffness.reshape(-1)

    def wave(self, harmonic: int) -> tuple[int, bool]:
        """Place of a harmonic's diameter, and whether it is stored as its conjugate."""
        k = self.system.nodal_diameter(harmonic) if self.sectors > 1 else 0
        return (k, False) if k < len(self.diameters) else (self.sectors - k, True)

    def modal(self, harmonic: int, x: Array) -> Array:
        """Modal amplitudes VᴴK̃x of coordinates x (n,) in the basis of the harmonic's diameter."""
        k, mirrored = self.wave(harmonic)
        matrices = self.system.at(self.diameters[k])
        B = self.system.contact_rows(self.diameters[k]).reshape(-1, len(x))
        own = x.conj() if mirrored else x
        force = matrices.K @ own + B.conj().T @ (self.stiffness * (B @ own))
        amplitude = self.modes[k].solve(0.0, self.modes[k].shapes.conj().T @ force)
        return amplitude.conj() if mirrored else amplitude

    def linear(self, omega: float) -> dict[int, Array]:
        """Modal amplitudes of the steady linear vibration by harmonic; 0 holds the interference."""
        found: dict[int, Array] = {}
        for h in sorted({0, *self.system.force}):
            k, mirrored = self.wave(h)
            modes, force = self.modes[k], self.system.force.get(h)
            load = np.zeros(len(modes.compliance), complex)
            if force is not None:
                given = force.at(omega)
                load += modes.shapes.conj().T @ (given.conj() if mirrored else given)
            if h == 0:
                offset = self.system.contacts.offset.reshape(-1)
                load -= modes.rows.conj().T @ (self.stiffness * offset)
            steady = modes.solve(-h * omega if mirrored else h * omega, load)
            found[h] = steady.conj() if mirrored else steady
        return found

    def lag(self, harmonics: Integers) -> Complex:
        """(h, N) factors of harmonics of a wave from the first sector to each."""
        turn = -2j * np.pi * self.system.engine_order / self.system.sectors
        return np.asarray(np.exp(turn * np.outer(harmonics, np.arange(self.sectors))))

    def travelling(self, harmonic: int, amplitude: Array, angles: Floats) -> Floats:
        """(s, N, d) history Re(q e^{ihθ}) of a harmonic's wave, q (d,) in the first sector."""
        lag = self.lag(np.array([harmonic]))[0]
        turned = np.exp(1j * harmonic * angles)[:, None, None] * lag[:, None]
        return np.asarray((turned * amplitude).real)

    def rows(self, harmonic: int) -> Array:
        """(3c, n) relative displacements in the modes of a harmonic's diameter."""
        k, mirrored = self.wave(harmonic)
        return self.modes[k].rows.conj() if mirrored else self.modes[k].rows

    def by_diameter(self, values: Floats) -> Array:
        """Amplitudes (k, ..., d) by diameter from real values (..., N, d) in every sector."""
        return np.asarray(np.einsum("kj,...jd->k...d", self.shift.conj(), values) / self.sectors)


def ring(system: System, every: bool = False) -> FullRing:
    """The ring of a system."""
    check(system)
    system.contacts.refuse_elements("time integration of the ring")
    N = system.sectors
    alike = not every and system.engine_order % N == 0
    diameters = (0,) if alike else tuple(range(N // 2 + 1))
    check_ring(system, diameters[-1], "time integration of the ring")
    standing = {k: _real(system.at(k), k) for k in diameters if (2 * k) % N == 0}
    system = replace(system, diameters={**system.diameters, **standing})
    modes = tuple(stuck_modes(system, k) for k in diameters)
    for k, found in zip(diameters, modes, strict=True):
        check_uncoupled(system, found, k, "time integration")
    sectors = 1 if alike else N
    order = np.array(diameters)
    shift = np.exp(-2j * np.pi * np.outer(order, np.arange(sectors)) / N)
    weight = np.where((2 * order) % N == 0, 1.0, 2.0)
    return FullRing(system, sectors, diameters, modes, shift, weight)


def _real(matrices: Diameter, nodal_diameter: int) -> Diameter:
    """Matrices of a diameter at which no wave travels, freed of round-off."""
    real: dict[str, Any] = {}
    for name in ("K", "M", "own", "next", "output", "C"):
        value = getattr(matrices, name)
        if value is None:
            continue
        if np.abs(value.imag).max(initial=0) > ROUND_OFF * np.abs(value).max(initial=0):
            raise InputError(
                f"system: nd/{nodal_diameter}/{name}: given complex values: time integration needs "
                "real coordinates at the nodal diameters 0 and N/2, where no wave travels"
            )
        real[name] = value.real
    return replace(matrices, **real)
