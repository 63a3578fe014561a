"""The structure excited by itself, the modal amplitude of its fundamental held.

With a self-excitation -ξ M q̇, ξ in 1/s, the dynamic stiffness of harmonic h is

    D̃_h(ω, ξ) = K̃ + ihω C - (hω)² M - ihω ξ M                       (Krack 2015).

Near a mode, where ω and ξ are those of free vibration, that of the fundamental is singular. So its
modal amplitude along a shape φ, φᴴMφ = 1, is held at a, and the force Λ along the shape that this
takes comes out, zero in free vibration:

    [ D̃₁    -Mφ ] [ q ]   [ f ]
    [ φᴴM    0  ] [ Λ ] = [ a ].

In the modes V of `StuckModes`, p the diagonal of their dynamic stiffness, k the springs that act on
what is open in them, g their forces,

    p y + b_oᴴ g - VᴴMφ Λ = f,      b_o y - k⁻¹ g = 0,      φᴴMV y = a,

from which all modes but those near resonance are eliminated first; the pivots that are left are as
good as the bordered matrix is regular. M. Krack, Nonlinear modal analysis of nonconservative
systems: extension of the periodic motion concept, Computers & Structures 154 (2015) 59-71.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import scipy.linalg as la

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.stuck_modes import NEAR, StuckModes
from vanelock.nonlinear.fourier import to_complex, to_real


class _ExcitedModes:
    """One harmonic's structure at s = hω, excited by itself, ready to be solved."""

    def __init__(self, modes: StuckModes, s: float, xi: float, border: Array | None = None) -> None:
        self.modes, self.s, self.xi = modes, s, xi
        self._diagonal = modes.dynamic(s) - 1j * s * xi * modes.compliance
        coupled = modes.coupled_damping
        if coupled is None:
            near = np.abs(self._diagonal) < NEAR
            inner = np.diag(self._diagonal[near])
        else:
            near = np.ones(len(self._diagonal), bool)
            inner = 1j * s * (coupled - np.diag(coupled.diagonal().real)) + np.diag(self._diagonal)
        self._near, self._far = np.flatnonzero(near), np.flatnonzero(~near)
        own = modes.opened
        push, see = modes.pull[:, own], modes.rows[own]
        give = -1 / modes.springs[own] if modes.springs is not None else np.zeros(0)
        if border is not None:  # ω times it, so that it weighs as much as the stiffness does
            push = np.column_stack([push, -s * border])
            see = np.vstack([see, s * border.conj()])
            give = np.append(give, 0.0)
        self._held = border is not None
        self._push, self._see = push.astype(complex), see.astype(complex)
        far = self._far
        self._answer = self._see[:, far] / self._diagonal[far]
        corner = np.diag(give) - self._answer @ self._push[far]
        near = self._near
        matrix = np.block([[inner, self._push[near]], [self._see[:, near], corner]])
        self._factors = la.lu_factor(matrix, check_finite=False)

    def solve(self, push: Array, held: float = 0.0) -> tuple[Array, Array]:
        """Modal amplitudes (n, k) under the forces (n, k), and the forces Λ (k,), zeros if free."""
        near, far, count = self._near, self._far, push.shape[1]
        right = np.zeros((len(near) + len(self._see), count), complex)
        right[: len(near)] = push[near]
        right[len(near) :] = -self._answer @ push[far]
        if self._held:
            right[-1] += self.s * held
        found = la.lu_solve(self._factors, right, check_finite=False)
        forces = found[len(near) :]
        amplitudes = np.empty(push.shape, complex)
        amplitudes[near] = found[: len(near)]
        left = push[far] - self._push[far] @ forces
        amplitudes[far] = left / self._diagonal[far, None]
        return amplitudes, self.s * forces[-1] if self._held else np.zeros(count, complex)

    def by_push(self) -> Array:
        """(n,) by which the force Λ follows modal forces."""
        last = np.zeros(len(self._near) + len(self._see), complex)
        last[-1] = self.s
        found = la.lu_solve(self._factors, last, trans=1, check_finite=False)
        row = np.empty(len(self._diagonal), complex)
        row[self._near] = found[: len(self._near)]
        row[self._far] = -found[len(self._near) :] @ self._answer
        return row

    def columns(self, stiffness: Floats, components: Integers) -> Array:
        """Columns of R̂, (k, 3c), of the wanted (k,) components."""
        moved = self.solve(self.modes.pull[:, components])[0]
        return (self.modes.rows @ moved).T * stiffness[components, None]


@dataclass(frozen=True)
class HeldVibration:
    """A structure excited by itself at (ω, ξ), its fundamental's amplitude along a shape held.

    `structure`: of one harmonic at least; of its forces the static one alone acts; `shape` (n,):
    VᴴMφ of the fundamental's modes; `omega`: rad/s; `xi`: ξ, 1/s; `mean` (c, 3): mean displacement
    that is held whatever the contacts do, m; `everywhere`: whether harmonics h > 1 are excited by
    themselves, too.
    """

    structure: Structure
    shape: Array
    omega: float
    xi: float
    mean: Floats | None = None
    everywhere: bool = True

    @cached_property
    def excited(self) -> list[_ExcitedModes]:
        """Those of the harmonics h = 1 ... H."""
        others = self.xi if self.everywhere else 0.0
        return [
            _ExcitedModes(self.structure.at(1), self.omega, self.xi, self.shape),
            *(
                _ExcitedModes(self.structure.at(h), h * self.omega, others)
                for h in range(2, self.structure.harmonics + 1)
            ),
        ]

    @cached_property
    def _unit(self) -> tuple[Array, complex]:
        """Modal amplitudes of the fundamental and Λ at a = 1 kg^½ m, all contacts stuck."""
        found, force = self.excited[0].solve(np.zeros((len(self.shape), 1)), 1.0)
        return found[:, 0], complex(force[0])

    @cached_property
    def direction(self) -> Floats:
        """(c, 3, 2H + 1) dũ/da, 1/kg^½."""
        prepared = self.structure
        moved = np.zeros((prepared.harmonics + 1, len(prepared.stiffness)), complex)
        moved[1] = prepared.at(1).rows @ self._unit[0]
        return self._by_contact(moved)

    @cached_property
    def still(self) -> Balance:
        """The balance of the contacts at a = 0."""
        prepared = self.structure
        none = np.zeros(len(prepared.stiffness), complex)
        compute = tuple(partial(each.columns, prepared.stiffness) for each in self.excited)
        found = prepared.assembled(self.omega, [none for _ in self.excited], compute)
        return found if self.mean is None else found.with_mean(self.mean)

    def balance(self, amplitude: float) -> Balance:
        """The balance of the contacts at an amplitude a, kg^½ m."""
        return replace(self.still, linear=self.still.linear + amplitude * self.direction)

    def motion(self, amplitude: float, w: Floats) -> tuple[list[Array], complex]:
        """Modal amplitudes of the harmonics 0 to H at a deviation w, and the force Λ, kg^½ m/s²."""
        prepared = self.structure
        pulled = to_complex(w.reshape(-1, w.shape[2])) * prepared.stiffness
        modes = prepared.at(0)
        push = prepared.modal_force(0, self.omega) + (modes.pull @ pulled[0]).real
        amplitudes, force = [modes.solve(0.0, push)], 0j
        for h, excited in enumerate(self.excited, 1):
            push = excited.modes.pull @ pulled[h]
            found, needed = excited.solve(push[:, None], amplitude if h == 1 else 0.0)
            amplitudes.append(found[:, 0])
            force = complex(needed[0]) if h == 1 else force
        return amplitudes, force

    @cached_property
    def force_rates(self) -> tuple[Array, complex]:
        """Derivatives of Λ by w, (c, 3, 2H + 1) complex, and by a; it is linear in both."""
        first, prepared = self.excited[0], self.structure
        by_first = (first.by_push() @ first.modes.pull) * prepared.stiffness
        rates = np.zeros((len(by_first), 2 * prepared.harmonics + 1), complex)
        rates[:, 1], rates[:, 2] = by_first, 1j * by_first
        return rates.reshape(-1, 3, rates.shape[1]), self._unit[1]

    def rates(self, amplitudes: Sequence[Array]) -> list[tuple[Floats, complex]]:
        """Derivatives of u (c, 3, 2H + 1) and of Λ by ω and by ξ, at fixed a and w."""
        prepared = self.structure
        moved = np.zeros((2, prepared.harmonics + 1, len(prepared.stiffness)), complex)
        changes = np.zeros(2, complex)
        if self.mean is None:
            rate, modes = prepared.push_rate(0, self.omega, amplitudes[0]), prepared.at(0)
            if rate is not None:
                moved[0, 0] = modes.rows @ modes.solve(0.0, rate)
        for h, (excited, y) in enumerate(zip(self.excited, amplitudes[1:], strict=True), 1):
            modes = excited.modes
            inertia = modes.compliance * y
            slower = -h * (modes.slope(h * self.omega, y) - 1j * excited.xi * inertia)
            excites = 1j * h * self.omega * inertia * (self.everywhere or h == 1)
            found, needed = excited.solve(np.column_stack([slower, excites]))
            moved[:, h] = (modes.rows @ found).T
            if h == 1:
                changes = needed
        return [
            (self._by_contact(each), complex(change))
            for each, change in zip(moved, changes, strict=True)
        ]

    def _by_contact(self, moved: Array) -> Floats:
        """(c, 3, 2H + 1) of coefficients (H + 1, 3c)."""
        return to_real(moved).reshape(self.structure.system.contacts.count, 3, -1)
