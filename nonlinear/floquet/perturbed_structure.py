"""The stuck structure under a perturbation: modes and receptances of each of its harmonics.

Harmonic k of a perturbation of nodal diameter n has the diameter (n + k EO) mod N and moves as
e^{zt}, z = (s + ik)ω. In the modes V of that diameter (`stuck_modes`)

    p_r a_r = b_rᴴ K_c w_k,      p_r = A_r + z²Λ_r + z d_r,      u_k = Σ_r b_r a_r,

w - u instead of w for contacts that are open in the modes. Modes with a pole near the values of s
of interest are told apart, and all lower ones where contacts are open, whose closing raises them:
what all others add, R_k(s) w_k, is smooth in s there.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vanelock.common.arrays import Array, Complex, Floats, Integers
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.rom.system.system import System


@dataclass(frozen=True)
class Rectangle:
    """The values of s = λ/ω from `left` to `right` and from -i `half` to i `half`."""

    left: float
    right: float
    half: float

    def distance(self, s: Complex | complex) -> Floats:
        """How far values lie outside."""
        s = np.asarray(s)
        beside = np.maximum(np.maximum(self.left - s.real, s.real - self.right), 0.0)
        return np.hypot(beside, np.maximum(np.abs(s.imag) - self.half, 0.0))


@dataclass(frozen=True)
class PerturbedStructure:
    """One nodal diameter of perturbations of a motion.

    `modes`: of all diameters 0 ... N - 1; `diameter`: n; `omega`: of the motion, rad/s;
    `harmonics`: P; `near`: how far from the window the poles of modes told apart may lie.
    """

    system: System
    modes: Mapping[int, StuckModes]
    diameter: int
    omega: float
    harmonics: int
    window: Rectangle
    near: float

    @cached_property
    def each(self) -> list[StuckModes]:
        """Modes of the harmonics -P ... P."""
        N, order = self.system.sectors, self.system.engine_order
        harmonics = range(-self.harmonics, self.harmonics + 1)
        return [self.modes[(self.diameter + k * order) % N] for k in harmonics]

    @cached_property
    def poles(self) -> list[Complex]:
        """(2, n) values of s at which p of each mode vanishes, by harmonic."""
        pairs = enumerate(self.each, -self.harmonics)
        return [_complex_poles(modes) / self.omega - 1j * k for k, modes in pairs]

    @cached_property
    def chosen(self) -> list[tuple[int, int]]:
        """Place of the harmonic and number of the mode of the m near ones."""
        near = [(self.window.distance(s) < self.near).any(axis=0) for s in self.poles]
        for k, modes in enumerate(self.each, -self.harmonics):
            if modes.springs is not None:
                reach = self.omega * (abs(k) + self.window.half + self.near)
                near[k + self.harmonics] |= modes.poles() < reach
        return [(place, int(r)) for place, one in enumerate(near) for r in np.flatnonzero(one)]

    @cached_property
    def place(self) -> Integers:
        """(m,) place of the harmonic of each near mode."""
        return np.array([place for place, _ in self.chosen], np.int64)

    @cached_property
    def number(self) -> Integers:
        """(m,) number of each near mode among its diameter's."""
        return np.array([r for _, r in self.chosen], np.int64)

    @cached_property
    def stiffness(self) -> Floats:
        """K_c, (3c,) N/m."""
        return self.system.contacts.stiffness.reshape(-1)

    @cached_property
    def _quadratic(self) -> Floats:
        """(3, m) A, d and Λ of the near modes."""
        found = np.empty((3, len(self.chosen)))
        for i, (k, r) in enumerate(self.chosen):
            modes = self.each[k]
            found[:, i] = modes.static[r], modes.damping[r], modes.compliance[r]
        return found

    def diagonal(self, s: complex) -> Complex:
        """(m,) p of the near modes."""
        z = self.omega * (s + 1j * (self.place - self.harmonics))
        static, damping, compliance = self._quadratic
        found: Complex = static + z * (z * compliance + damping)
        return found

    def rows(self, components: Integers) -> Complex:
        """(m, k) relative displacements of k components in the near modes."""
        found = [self.each[k].rows[components, r] for k, r in self.chosen]
        return np.array(found, complex).reshape(len(found), len(components))

    def rest(self, s: complex, rows: list[Array], pull: list[Array]) -> Complex:
        """(2P + 1, k, o) R_k(s) of all modes but the near ones."""
        found = np.empty((len(rows), len(rows[0]), pull[0].shape[1]), complex)
        for place, modes in enumerate(self.each):
            z = self.omega * (s + 1j * (place - self.harmonics))
            answer = 1 / (modes.static + z * (z * modes.compliance + modes.damping))
            answer[self.number[self.place == place]] = 0.0
            found[place] = (rows[place] * answer) @ pull[place]
        return found

    def output_rows(self, place: int) -> Complex:
        """(d, n) displacements of the outputs, or of the contacts without any, in all modes."""
        modes = self.each[place]
        diameter = self.diameter + (place - self.harmonics) * self.system.engine_order
        output = self.system.at(diameter % self.system.sectors).output
        if output is None or not len(output):
            return modes.rows
        rows: Complex = output.reshape(-1, len(modes.shapes)) @ modes.shapes
        return rows


def _complex_poles(modes: StuckModes) -> Complex:
    """(2, n) values of z, rad/s, at which p of each mode vanishes; infinity is a large one."""
    d = modes.damping
    root = np.sqrt(d**2 - 4 * modes.static * modes.compliance.astype(complex))
    inverse = -np.stack([d + root, d - root]) / 2
    return np.asarray(modes.static / np.where(np.abs(inverse) > 1e-150, inverse, -1e-150))
