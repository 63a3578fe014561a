"""The structure with some contacts closed and the others open, by its own modes.

In the modes V of `stuck_modes`, VᴴMV = Λ, the stiffness of such a limit is

    K = A + Σ ± bᴴ k b,

plus the springs of contacts that are closed here and open in V, minus those of contacts that are
stuck in V and open here. With T of Tᴴ(K + σ²Λ)T = 1, TᴴΛT = Λ', σ² small, since nothing need hold
it, its dynamic stiffness is diagonal but for the damping C', which is of V's modes:

    Tᴴ D T = 1 - (σ² + s²) Λ' + i s C'.

A balance of few modes is solved as it stands. Of many, those slower than three times s are coupled
by C' as they are; the others, of which s C' is a small part, follow from them by repetition. What
is left of the balance is measured.
"""

from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.common.arrays import Array, Booleans, Floats
from vanelock.rom.fixed_interface.inertia import real_times
from vanelock.rom.joining.linear_modes import apart_from_springs

if TYPE_CHECKING:
    from vanelock.nonlinear.balance.stuck_modes import StuckModes


_TINY = np.finfo(float).tiny
_NEAR = 9.0  # of s², below which the square of a mode's frequency is near
_FEW = 100  # modes up to which the balance is solved as it stands, which is quicker
_SMALL, _MOST = 1e-13, 60
"""Relative change at which a repetition ends, and repetitions before all modes are coupled."""


@dataclass(frozen=True)
class LimitModes:
    """Modes of one nodal diameter with some contacts closed, in the modes of `StuckModes`.

    `shapes` (n, n): T, a mode of the limit a column; None where they are V's own; `compliance`,
    `static` (n,): Λ' and 1 - σ²Λ'; `damping` (n, n): C', s/rad; its diagonal where it has no more.
    """

    shapes: Array | None
    compliance: Floats
    static: Floats
    damping: Array

    def solve(self, s: Floats, push: Array) -> tuple[Array, Floats]:
        """Amplitudes (n, f) of the modes V under modal forces `push` at s (f,), rad/s; the errors.

        An error (f,) is what is left of the balance, relative to its largest term. All frequencies
        are solved together, which reads C' once a repetition.
        """
        T = self.shapes
        force = np.asarray(push, complex) if T is None else times(T.conj().T, push)
        diagonal = self.static[:, None] - s**2 * self.compliance[:, None]
        left = np.zeros(len(s))
        if self.damping.ndim == 1:
            y = force / (diagonal + 1j * s * self.damping[:, None])
        else:
            if len(diagonal) <= _FEW:
                y = np.zeros(force.shape, complex)
                for i in range(len(s)):
                    with suppress(la.LinAlgError):  # else the balance stays open by all the force
                        y[:, i] = np.linalg.solve(self._whole(s[i], diagonal[:, i]), force[:, i])
            else:
                y = self._repeated(s, diagonal, force)
            scale = np.abs(np.stack([diagonal * y, force])).max(axis=(0, 1), initial=_TINY)
            left = np.abs(self._left(s, diagonal, force, y)).max(axis=0, initial=0.0) / scale
        return y if T is None else times(T, y), left

    def _repeated(self, s: Floats, diagonal: Floats, force: Array) -> Array:
        """Amplitudes (n, f) of the limit's modes by repetition."""
        far = diagonal + 1j * s * self.damping.diagonal()[:, None]
        near = [self._near(each, diagonal[:, i]) for i, each in enumerate(s)]

        def step(rest: Array, which: NDArray[np.intp]) -> Array:
            found = rest / far[:, which]
            for column, i in enumerate(which):
                rows, factors = near[i]
                if len(rows):
                    found[rows, column] = la.lu_solve(factors, rest[rows, column])
            return np.asarray(found)

        going = np.arange(len(s))
        y = step(force, going)
        for _ in range(_MOST):
            rest = self._left(s[going], diagonal[:, going], force[:, going], y[:, going])
            change = step(rest, going)
            y[:, going] += change
            size = np.abs(y[:, going]).max(axis=0, initial=0.0)
            going = going[np.abs(change).max(axis=0, initial=0.0) > _SMALL * size]
            if not len(going):
                break
        for i in going:
            y[:, i] = la.solve(self._whole(s[i], diagonal[:, i]), force[:, i])
        return y

    def _left(self, s: Floats, diagonal: Floats, force: Array, y: Array) -> Array:
        """What amplitudes (n, f) leave of the balance."""
        return np.asarray(force - diagonal * y - 1j * s * times(self.damping, y))

    def _whole(self, s: float, diagonal: Floats) -> Array:
        """The dynamic stiffness (n, n) at s, rad/s, whose part without damping is given."""
        full = np.asarray(1j * s * self.damping)
        full[np.diag_indices_from(full)] += diagonal
        return full

    def _near(self, s: float, diagonal: Floats) -> tuple[NDArray[np.intp], Any]:
        """Modes that are near at s, rad/s, and factors of their coupled dynamic stiffness."""
        near = np.flatnonzero(self.static < _NEAR * s**2 * self.compliance)
        block = 1j * s * self.damping[np.ix_(near, near)]
        block[np.diag_indices_from(block)] += diagonal[near]
        return near, la.lu_factor(block) if len(near) else None


def times(A: Array, y: Array) -> Array:
    """A y, (n, f), without making a real matrix complex."""
    return np.asarray(A @ y) if np.iscomplexobj(A) else real_times(A, y)


def limit_modes(modes: "StuckModes", stiffness: Floats, closed: Booleans) -> LimitModes:
    """Modes of a limit."""
    opened = np.zeros(len(stiffness), bool)
    opened[modes.opened] = True
    damping = modes.damping if modes.coupled_damping is None else modes.coupled_damping
    change = closed.astype(float) - ~opened
    rows = np.flatnonzero(change)
    if not len(rows):
        return LimitModes(None, modes.compliance, modes.static, damping)
    springs, own_rows = (change * stiffness)[rows], modes.rows[rows]
    K, compliance = np.diag(modes.static).astype(own_rows.dtype), np.diag(modes.compliance)
    apart = apart_from_springs(K, own_rows, springs) if springs.min() >= 0 else None
    if apart is not None:
        Q, own_rows = apart
        K, compliance = Q.conj().T @ K @ Q, Q.conj().T @ compliance @ Q
    K = K + (own_rows.conj().T * springs) @ own_rows
    shift = 1 / float(modes.compliance.sum())
    base = (K + K.conj().T) / 2 + shift * compliance
    values, T = la.eigh(compliance, base)
    values, T = values[::-1].clip(min=0), T[:, ::-1] if apart is None else Q @ T[:, ::-1]
    T = np.ascontiguousarray(T)
    own = (T.conj().T * damping) @ T if damping.ndim == 1 else T.conj().T @ damping @ T
    return LimitModes(T, values, (1 - shift * values).clip(min=0), own)
