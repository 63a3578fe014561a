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
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.stuck_modes import NEAR, StuckModes
from vanelock.nonlinear.fourier.trigonometric import to_complex, to_real

Array: TypeAlias = NDArray[Any]
Floats = NDArray[np.float64]


class ExcitedModes:
    """One harmonic's structure at s = hω, excited by itself, ready to be solved.

    Parameters
    ----------
    modes : StuckModes
        Of the harmonic.
    s : float
        rad/s.
    xi : float
        ξ, 1/s.
    border : (n,) complex, optional
        VᴴMφ, where the amplitude along a shape is held.
    """

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

    def columns(self, stiffness: Floats, wanted: NDArray[np.int64]) -> Array:
        """Columns of R̂, (k, 3c), of the wanted (k,) components."""
        moved = self.solve(self.modes.pull[:, wanted])[0]
        return (self.modes.rows @ moved).T * stiffness[wanted, None]


@dataclass(frozen=True)
class HeldVibration:
    """A structure excited by itself at (ω, ξ), its fundamental's amplitude along a shape held.

    Attributes
    ----------
    structure : Structure
        Of one harmonic at least; of its forces the static one alone acts.
    shape : (n,) complex
        VᴴMφ of the fundamental's modes.
    amplitude : float
        a, kg^½ m.
    omega : float
        rad/s.
    xi : float
        ξ, 1/s.
    mean : (c, 3) float, optional
        Mean displacement that is held whatever the contacts do, m.
    """

    structure: Structure
    shape: Array
    amplitude: float
    omega: float
    xi: float
    mean: Floats | None = None

    @cached_property
    def excited(self) -> list[ExcitedModes]:
        """Those of the harmonics h = 1 ... H."""
        return [
            ExcitedModes(
                self.structure.at(h), h * self.omega, self.xi, self.shape if h == 1 else None
            )
            for h in range(1, self.structure.harmonics + 1)
        ]

    @cached_property
    def balance(self) -> Balance:
        """The balance of the contacts."""
        prepared = self.structure
        modes, none = prepared.at(1), np.zeros((len(self.shape), 1))
        still = np.zeros(len(prepared.stiffness), complex)
        first = modes.rows @ self.excited[0].solve(none, self.amplitude)[0][:, 0]
        compute = tuple(partial(each.columns, prepared.stiffness) for each in self.excited)
        vibrations = [first, *(still for _ in self.excited[1:])]
        found = prepared.assembled(self.omega, vibrations, compute)
        return found if self.mean is None else found.with_mean(self.mean)

    def motion(self, w: Floats) -> tuple[list[Array], complex]:
        """Modal amplitudes of the harmonics 0 to H at a deviation w, and the force Λ, kg^½ m/s²."""
        return self._moved(w, self.amplitude, True)

    def moved(self, change: Floats) -> complex:
        """How Λ changes with w, to first order and exactly, as it is linear in w."""
        return self._moved(change, 0.0, False)[1]

    def _moved(self, w: Floats, held: float, loaded: bool) -> tuple[list[Array], complex]:
        prepared, force = self.structure, 0j
        pulled = to_complex(w.reshape(-1, w.shape[2])) * prepared.stiffness
        amplitudes: list[Array] = []
        if loaded:
            modes = prepared.at(0)
            push = prepared.modal_force(0, self.omega) + (modes.pull @ pulled[0]).real
            amplitudes.append(modes.solve(0.0, push))
        for h, excited in enumerate(self.excited, 1):
            push = excited.modes.pull @ pulled[h]
            found, needed = excited.solve(push[:, None], held if h == 1 else 0.0)
            amplitudes.append(found[:, 0])
            if h == 1:
                force = complex(needed[0])
            if not loaded:
                break
        return amplitudes, force

    def rates(self, amplitudes: Sequence[Array]) -> list[tuple[Floats, complex]]:
        """Derivatives of u (c, 3, 2H + 1) and of Λ by ω and by ξ, at fixed w.

        Parameters
        ----------
        amplitudes : sequence of (n_h,)
            Modal amplitudes of the harmonics, as `motion` gives them.
        """
        prepared, still = self.structure, np.zeros(len(self.structure.stiffness), complex)
        force = prepared.system.force.get(0)
        by_omega, by_xi = [still], [still]
        if force is not None and force.omega_power and self.mean is None:
            rate = prepared.push_rate(0, self.omega, amplitudes[0])
            modes = prepared.at(0)
            by_omega = [modes.rows @ modes.solve(0.0, rate)]
        changes: list[complex] = []
        for h, (excited, y) in enumerate(zip(self.excited, amplitudes[1:], strict=True), 1):
            modes = excited.modes
            inertia = modes.compliance * y
            slower = -h * (modes.slope(h * self.omega, y) - 1j * self.xi * inertia)
            excites = 1j * h * self.omega * inertia
            found, needed = excited.solve(np.column_stack([slower, excites]))
            both = modes.rows @ found
            by_omega.append(both[:, 0])
            by_xi.append(both[:, 1])
            if h == 1:
                changes = [complex(each) for each in needed]
        shape = (prepared.system.contacts.count, 3, 2 * prepared.harmonics + 1)
        return [
            (to_real(np.stack(moved)).reshape(shape), change)
            for moved, change in zip((by_omega, by_xi), changes, strict=True)
        ]

    def at(self, omega: float, xi: float) -> "HeldVibration":
        """The same at another frequency and self-excitation."""
        return replace(self, omega=omega, xi=xi)
