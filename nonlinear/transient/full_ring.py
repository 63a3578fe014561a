"""The linear ring of all sectors, its contacts stuck, and the contacts at the end of a step.

The coordinates of sector j are x_j = Σ_k X_k e^{-2πikj/N}, k = 0 ... N - 1. They are real, so
X_{N-k} is the conjugate of X_k and half of the diameters suffice:

    x_j = Re Σ_k m_k X_k e^{-2πikj/N},   k = 0 ... ⌊N/2⌋,   m_k = 1 where k = N - k, otherwise 2.

With the modes of the stuck structure (`stuck_modes`) the motion is X_k = V_k (a_k + y_k), where a_k
is the steady linear vibration with every contact stuck, known in closed form, and y_k answers to
the deviations w_j of the contacts from sticking,

    Λ y_k'' + D y_k' + A y_k = b_kᴴ K_c W_k,      W_k = 1/N Σ_j w_j e^{2πikj/N}.

Contacts that are open in the modes pull with w_j less the displacement that is y_k's.

Within a time step the relative displacements run straight from where they are to where they come to
rest at its end, u = known + G w, G the motion that the deviations w cause within the step. Along a
straight path the contact law is exact: a slider that meets its bound goes with it, and one that
comes back into contact holds on where the path crosses v = 0. The deviations at the end of the step
are one scalar problem each, of isotropic friction one of two unknowns (`_slider_in_plane`), solved
in turn, until none changes (nonlinear Gauss-Seidel).

For these the disc's centre moves straight and its radius linearly, so that the path has a closed
form (`disc_slider`): the place w at the end is a function P of the centre there, which w
itself moves,

    w = P(known + G w),

two equations, solved by Newton's method with the closed form's derivative. Where a step of it
does not come closer, one of the plain iteration is taken.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vanelock.common.arrays import Array, Booleans, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.stuck_modes import StuckModes, check_uncoupled, stuck_modes
from vanelock.nonlinear.contact.disc_slider import HELD, RATES, TO, pursue
from vanelock.nonlinear.fourier import kernel
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


_ITERATIONS = 60
_CLOSE = 1e-14  # of the displacements: what P(known + G w) may be off w at the end of the iteration


@kernel
def _slider_in_plane(
    free: Floats, G: Floats, held: Floats, start: Floats, r_start: float, r: float, slider: Floats
) -> None:
    """Place w of a slider at the end of a step, u = free + G w."""
    x, y, before = slider[0], slider[1], math.inf
    centre, following, rates = start.copy(), np.empty(2), np.empty((2, RATES))
    for _ in range(_ITERATIONS):
        centre[0] = free[0] + G[0, 0] * x + G[0, 1] * y
        centre[1] = free[1] + G[1, 0] * x + G[1, 1] * y
        kind, _ = pursue(held, start, centre, r_start, r, following, rates)
        fx, fy = following[0] - x, following[1] - y
        apart = math.hypot(fx, fy)
        size = abs(centre[0]) + abs(centre[1]) + abs(following[0]) + abs(following[1])
        if apart <= _CLOSE * size:
            break
        if apart >= before or (kind == HELD and r_start > 0.0):
            x, y, before = following[0], following[1], math.inf
            continue
        before = apart
        a, b = rates[0, TO], rates[0, TO + 1]
        c, d = rates[1, TO], rates[1, TO + 1]
        m00, m01 = (1.0 - a * G[0, 0] - b * G[1, 0], -a * G[0, 1] - b * G[1, 1])
        m10, m11 = (-c * G[0, 0] - d * G[1, 0], 1.0 - c * G[0, 1] - d * G[1, 1])
        det = m00 * m11 - m01 * m10
        x += (m11 * fx - m01 * fy) / det
        y += (m00 * fy - m10 * fx) / det
    slider[0], slider[1] = following[0], following[1]


@kernel
def _slider_place(
    free: float, G: float, held: float, u_before: float, v_before: float, v: float, alpha: float
) -> float:
    """Place w of a slider at the end of a step, u = free + G w."""
    if v <= 0.0:
        return free / (1.0 - G)
    place = held
    if v_before < 0.0:  # touches down on the way, unstressed
        share = v_before / (v_before - v)
        place = ((1.0 - share) * u_before + share * free) / (1.0 - share * G)
    apart = free + G * place - place
    if apart > alpha * v:
        return (free - alpha * v) / (1.0 - G)
    if apart < -alpha * v:
        return (free + alpha * v) / (1.0 - G)
    return place


@kernel
def _spread(
    u: Floats, coupling: Floats, sector: int, column: int, change: float, listed: Integers
) -> None:
    """Move the listed contacts of all sectors by the change of one deviation."""
    sectors = u.shape[0]
    for i in range(sectors):
        row = coupling[(i - sector) % sectors, column]
        for c in listed:
            u[i, 3 * c] += row[3 * c] * change
            u[i, 3 * c + 1] += row[3 * c + 1] * change
            u[i, 3 * c + 2] += row[3 * c + 2] * change


@kernel
def sweep(
    u: Floats,
    w: Floats,
    u_before: Floats,
    w_before: Floats,
    coupling: Floats,
    alpha: Floats,
    isotropic: bool,
    listed: Integers,
) -> float:
    """Solve the listed contacts once, one after the other; the largest change of a deviation."""
    largest, places, free = 0.0, np.empty(3), np.empty(2)
    for j in range(u.shape[0]):
        for c in listed:
            for e in range(3):
                a = 3 * c + e
                own = coupling[0, a, a]
                known = u[j, a] - own * w[j, a]
                v_before, v = u_before[j, 3 * c], u[j, 3 * c]
                if e == 0:
                    places[0] = min(known, 0.0) / (1.0 - own)
                elif not isotropic:
                    places[e] = _slider_place(
                        known, own, w_before[j, a], u_before[j, a], v_before, v, alpha[c, e - 1]
                    )
                elif e == 1:
                    here, plane = w[j, a : a + 2], coupling[0, a : a + 2, a : a + 2].T
                    for i in range(2):
                        free[i] = u[j, a + i] - plane[i, 0] * here[0] - plane[i, 1] * here[1]
                    places[1:] = here
                    r_before, r = alpha[c, 0] * v_before, alpha[c, 0] * v
                    before, held = u_before[j, a : a + 2], w_before[j, a : a + 2]
                    _slider_in_plane(free, plane, held, before, r_before, r, places[1:])
                change = places[e] - w[j, a]
                if change != 0.0:
                    w[j, a] = places[e]
                    _spread(u, coupling, j, a, change, listed)
                    largest = max(largest, abs(change))
    return largest


@kernel
def follow(u: Floats, alpha: Floats, isotropic: bool, w: Floats) -> None:
    """Move the deviations w (N, 3c) along displacements u (s, N, 3c), which begin at u[0]."""
    for i in range(1, u.shape[0]):
        for j in range(u.shape[1]):
            for c in range(alpha.shape[0]):
                a, b = 3 * c, 3 * c + 3
                before, after, places = u[i - 1, j, a:b], u[i, j, a:b], w[j, a:b]
                places[0] = min(after[0], 0.0)
                if isotropic:
                    r0, r1 = alpha[c, 0] * before[0], alpha[c, 0] * after[0]
                    out, rates = np.empty(2), np.empty((2, RATES))
                    pursue(places[1:], before[1:], after[1:], r0, r1, out, rates)
                    places[1:] = out
                    continue
                for e in range(1, 3):
                    v_before, v, bound = before[0], after[0], alpha[c, e - 1]
                    places[e] = _slider_place(
                        after[e], 0.0, places[e], before[e], v_before, v, bound
                    )


@kernel
def awaken(u: Floats, w: Floats, alpha: Floats, isotropic: bool, awake: Booleans) -> bool:
    """Mark sleeping contacts that no longer stick in some sector; whether there are any."""
    found = False
    for c in range(awake.size):
        if awake[c]:
            continue
        for j in range(u.shape[0]):
            v = u[j, 3 * c]
            x, y = u[j, 3 * c + 1] - w[j, 3 * c + 1], u[j, 3 * c + 2] - w[j, 3 * c + 2]
            beyond = abs(x) > alpha[c, 0] * v or abs(y) > alpha[c, 1] * v
            if isotropic:
                beyond = math.hypot(x, y) > alpha[c, 0] * v
            if v < 0.0 or beyond:
                awake[c] = True
                found = True
    return found
