"""The linear structure with every contact stuck: modes, damping, receptances.

With K̃ = K + BᴴK_cB, regular although a segment hangs in its contacts alone, and modes V normalised
to VᴴK̃V = I, VᴴMV = Λ (the inverse squared frequencies), the dynamic stiffness at s = hω is

    Vᴴ D̃ V = I - s² Λ + i s (2ζ Λ^½ + VᴴCV).

Normalised by stiffness, static and low-frequency receptances keep full accuracy whatever the
highest modes are, and massless coordinates do no harm.

Where the modal damping is that of the structure whose joints are open (`System.damping_joints`),
its modes serve: Vᴴ(K̃ - bᴴkb + σ²M)V = I, b the rows of the contacts that open and k their springs,
σ about the lowest frequency, as the open structure may have motions that nothing holds. Then

    Vᴴ D̃ V = p(s) + bᴴ k b,      p = A - s² Λ + i s 2ζ (AΛ)^½,      A = I - σ² Λ,

of which p is diagonal and the springs few: D̃⁻¹ = p⁻¹ - p⁻¹ bᴴ (k⁻¹ + b p⁻¹ bᴴ)⁻¹ b p⁻¹.

Motions R that not even stuck contacts hold, K̃R = 0, RᴴMR = I, are modes by themselves: MRRᴴM,
which no other mode sees, is added to the stiffness, and their A is 0. At rest they are left out,
which is inertia relief: a load f is balanced by the inertia of a rigid acceleration, what acts is
f - MRRᴴf, and the structure lies where RᴴMx = 0.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg as la

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.limit_modes import LimitModes, limit_modes
from vanelock.nonlinear.fourier import one_thread
from vanelock.rom.joining.linear_modes import apart_from_springs, unheld_motions
from vanelock.rom.system.system import System

_KEPT = 2**24  # entries of condensed springs that are kept, over frequencies
NEAR = 0.1  # modal dynamic stiffness, of 1 at rest, of a mode told apart
_FEW = 5  # times fewer springs than modes, by which factors at a frequency are cheaper than modes
_LEFT_OUT = 1e-10  # of the largest entry of a matrix, by its factors
_MASSLESS = (
    'with the contacts open that the limit "free" opens, and what they alone hold has no mass: '
    'damping of the structure with these open needs mass there; damping/joints = "stuck" does not'
)


@dataclass(frozen=True)
class StuckModes(Product):
    """Modes of one nodal diameter, in which the structure with all contacts stuck is expressed.

    `shapes` (n, n): V, one mode a column; `rows` (3c, n): b = B V, relative displacements of the
    contacts (normal, t1, t2) in each mode; `compliance` (n,): Λ, s²/rad²; `static` (n,): A, modal
    stiffness: 1, less where the modes are those of the open structure; `damping` (n,): diagonal of
    the modal damping, s/rad; `coupled_damping` (n, n): the whole modal damping where a given C does
    not leave it diagonal; `springs` (3c,): stiffness of the contacts that are open in the modes,
    zero for others, N/m; None where all are stuck in them; `rigid`: how many of them nothing holds
    even with all contacts stuck; they come first.
    """

    shapes: Array
    rows: Array
    compliance: Floats
    static: Floats
    damping: Floats
    coupled_damping: Array | None = None
    springs: Floats | None = None
    rigid: int = 0

    @cached_property
    def held(self) -> "StuckModes":
        """Without the motions that nothing holds, which move no contact."""
        r = self.rigid
        coupled = self.coupled_damping
        return replace(
            self,
            shapes=self.shapes[:, r:],
            rows=self.rows[:, r:],
            compliance=self.compliance[r:],
            static=self.static[r:],
            damping=self.damping[r:],
            coupled_damping=None if coupled is None else coupled[r:, r:],
            rigid=0,
        )

    @cached_property
    def pull(self) -> Array:
        """(n, 3c) bᴴ, modal forces of forces in the contacts."""
        return np.ascontiguousarray(self.rows.conj().T)

    def conjugate(self) -> "StuckModes":
        """The modes of the nodal diameter N - k."""
        coupled = self.coupled_damping
        return replace(
            self,
            shapes=self.shapes.conj(),
            rows=self.rows.conj(),
            coupled_damping=None if coupled is None else coupled.conj(),
        )

    @cached_property
    def opened(self) -> Integers:
        """(m,) components of contacts that are open in the modes."""
        return np.flatnonzero(np.zeros(0) if self.springs is None else self.springs)

    @cached_property
    def _opened(self) -> tuple[Array, Array, Floats]:
        """(m, n) their rows, (n, m) modal forces, (m,) flexibility."""
        own = self.opened
        assert self.springs is not None
        return (
            np.ascontiguousarray(self.rows[own]),
            np.ascontiguousarray(self.pull[:, own]),
            1 / self.springs[own],
        )

    @cached_property
    def tables(self) -> dict[int, Any]:
        """What `receptance_tables` made of them last, by harmonic."""
        return {}

    @cached_property
    def _last(self) -> dict[float, tuple[Array, tuple[Array, Array], Array, Array]]:
        return {}

    @cached_property
    def closed(self) -> LimitModes:
        """The structure with all contacts stuck, by its own modes."""
        none = np.zeros(len(self.rows))
        springs = none if self.springs is None else self.springs
        return limit_modes(self, springs, np.ones(len(none), bool))

    @cached_property
    def _still(self) -> tuple[Array, Array]:
        """(n, n) T with TTᴴ the inverse of the modal stiffness, all contacts stuck; (3c, n) b T."""
        own, (rows, _, flexibility) = self.opened, self._opened
        K = np.diag(self.static).astype(rows.dtype)
        apart = apart_from_springs(K, rows, 1 / flexibility)
        if apart is not None:
            Q, rows = apart
            K = Q.conj().T @ K @ Q
        upper = la.cholesky(K + (rows.conj().T / flexibility) @ rows)
        T = la.solve_triangular(upper, np.eye(len(upper)))
        own_motion, T = rows @ T, T if apart is None else Q @ T
        motion = self.rows @ T
        motion[own] = own_motion
        return np.asarray(T), motion

    @cached_property
    def at_rest(self) -> "StuckModes":
        """Without inertia, damping and what nothing holds: shapes of stiffness 1, all stuck."""
        if self.rigid:
            return self.held.at_rest
        if self.springs is None:
            return self
        none = np.zeros(len(self.compliance))
        T, rows = self._still
        return StuckModes(self.shapes @ T, rows, none, np.ones(len(none)), none)

    def dynamic(self, s: float) -> Array:
        """Diagonal of the modal dynamic stiffness at s, rad/s, the springs of `springs` aside."""
        return np.asarray(self.static - s**2 * self.compliance + 1j * s * self.damping)

    def sprung(self, s: float, amplitudes: Array) -> Array:
        """Amplitudes (n,) or (n, k) once the springs of `springs` act, given those without.

        Modes at resonance are told apart: the others answer with the receptance F, and with
        A = (k⁻¹ + bFbᴴ)⁻¹ these n are left, (p_n + b_nᴴ A b_n) a_n = r_n - b_nᴴ A b F r.
        """
        if self.springs is None:
            return amplitudes
        rows, pull, flexibility = self._opened
        diagonal = self.dynamic(s)
        if s not in self._last:
            near = np.flatnonzero(np.abs(diagonal) < NEAR)
            answer = rows / diagonal
            answer[:, near] = 0.0
            factors = la.lu_factor(np.diag(flexibility) + answer @ pull, check_finite=False)
            coupled = la.lu_solve(factors, rows[:, near], check_finite=False)
            inner = np.diag(diagonal[near]) + pull[near] @ coupled
            if len(self._last) >= max(1, _KEPT // len(flexibility) ** 2):
                self._last.clear()
            self._last[s] = near, factors, coupled, inner
        near, factors, coupled, inner = self._last[s]
        own = amplitudes.reshape(len(diagonal), -1)
        far = own.copy()
        far[near] = 0.0
        force = la.lu_solve(factors, rows @ far, check_finite=False)
        if len(near):
            push = diagonal[near, None] * own[near] - pull[near] @ force
            moved = np.linalg.solve(inner, push)
            force += coupled @ moved
        far -= (pull @ force) / diagonal[:, None]
        if len(near):
            far[near] = moved
        return far.reshape(amplitudes.shape)

    def poles(self) -> Floats:
        """(n,) smallest |s|, rad/s, at which each mode's complex dynamic stiffness vanishes.

        That is its natural frequency if it can oscillate; of an overdamped mode, the slower decay.
        """
        c, d = self.static * self.compliance, np.abs(self.damping)
        stable = np.maximum(2 * np.sqrt(c), d + np.sqrt(np.maximum(d**2 - 4 * c, 0.0)))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.static > 0, np.asarray(2 * self.static / stable), 0.0)

    def static_beyond(self, s: float) -> "StuckModes":
        """The same modes, those whose poles lie beyond s, rad/s, following at once."""
        if self.coupled_damping is not None:
            raise InputError("static_beyond: given with a C that couples the modes; leave it out")
        follows = self.poles() < s
        return replace(
            self,
            compliance=np.where(follows, self.compliance, 0.0),
            damping=np.where(follows, self.damping, 0.0),
        )

    @cached_property
    def added_damping(self) -> Floats:
        """(n, r) F with FFᵀ = 1/(ω_i + ω_j) of the modes, s; zero of motions without mass.

        A small dK adds 2ζ dK_ij/(ω_i + ω_j) to the modal damping, D M⁻¹ D = 4ζ² K. Of Cholesky's
        factors with pivots a few dozen are left.
        """
        with np.errstate(divide="ignore"):
            omega = np.sqrt(self.static / self.compliance)
        moves = np.flatnonzero(np.isfinite(omega) & (omega > 0))
        kernel = 1 / (omega[moves, None] + omega[moves])
        rounding = _LEFT_OUT * float(kernel.max(initial=0.0))
        lower, pivot, rank, _ = la.lapack.dpstrf(kernel, tol=rounding, lower=1)
        found = np.zeros((len(omega), rank))
        found[moves[pivot - 1]] = np.tril(lower[:, :rank])
        return found

    def solve(self, s: float, right: Array) -> Array:
        """Modal amplitudes (n,) or (n, k) under the modal forces `right` at s, rad/s."""
        if s == 0 and self.rigid:
            none = np.zeros_like(right[: self.rigid])
            return np.concatenate([none, self.held.solve(s, right[self.rigid :])])
        if s == 0 and self.springs is not None:
            return np.asarray(self._still[0] @ (self._still[0].conj().T @ right))
        by_modes = self.coupled_damping is not None or _FEW * len(self.opened) > len(right)
        if right.ndim == 1 and s and by_modes:
            return self.closed.solve(np.array([s]), right[:, None])[0][:, 0]
        diagonal = self.dynamic(s)
        if self.coupled_damping is None or s == 0:
            return self.sprung(s, right / (diagonal if right.ndim == 1 else diagonal[:, None]))
        full = 1j * s * self.coupled_damping
        full[np.diag_indices_from(full)] += self.static - s**2 * self.compliance
        if self.springs is not None:
            rows, pull, flexibility = self._opened
            full += (pull / flexibility) @ rows
        return np.asarray(la.solve(full, right))

    def slope(self, s: float, amplitudes: Array) -> Array:
        """(d(VᴴD̃V)/ds) times modal amplitudes."""
        if self.coupled_damping is None:
            damped: Array = self.damping * amplitudes
        else:
            damped = self.coupled_damping @ amplitudes
        return np.asarray(-2 * s * self.compliance * amplitudes + 1j * damped)


def stuck_modes(system: System, nodal_diameter: int) -> StuckModes:
    """Modes, contact rows and damping of a nodal diameter, all contacts stuck.

    Raises
    ------
    InputError
        If a stiffness is negative, a motion without mass not held, or a static diameter 0 not real.
    """
    matrices = system.at(nodal_diameter)
    n = len(matrices.K)
    B = system.contact_rows(nodal_diameter).reshape(-1, n)
    k = system.contacts.stiffness.reshape(-1)
    K, M, C = matrices.K, matrices.M, matrices.C
    if nodal_diameter == 0:
        K, M, B = (_real(value, "nd/0") for value in (K, M, B))
    apart = apart_from_springs(K, B, k)
    if apart is not None:
        Q, B = apart
        K, M = Q.conj().T @ K @ Q, Q.conj().T @ M @ Q
    stuck = K + (B.conj().T * k) @ B
    stuck, M = (stuck + stuck.conj().T) / 2, (M + M.conj().T) / 2
    opens = np.repeat(system.opens_in_damping, 3) & bool(M.any())
    base, shift = stuck, 0.0
    wrong = "with all contacts stuck: some motion meets a negative stiffness"
    where = f"system: nd/{nodal_diameter}/K"
    try:
        R = unheld_motions(system, nodal_diameter, np.ones(system.contacts.count, bool))
        R = R if apart is None else Q.conj().T @ R
        rigid = R.shape[1]
        if rigid or opens.any():
            P = M @ R @ (M @ R).conj().T
            unit = float(stuck.trace().real / M.trace().real)
            slow = float(la.cho_solve(la.cho_factor(stuck + unit * P), M).trace().real)
            if rigid:  # what is left is of those that vibrate
                slow = max(slow - rigid / unit, 1 / unit)
            shift = 1 / slow if opens.any() else 0.0
            base = K + (B.conj().T * np.where(opens, 0.0, k)) @ B + shift * M
            base += (0.5 / slow - shift) * P  # slower than any other
            base = (base + base.conj().T) / 2
            wrong = _MASSLESS if opens.any() else wrong
        values, shapes = la.eigh(M, base)
    except la.LinAlgError:
        raise InputError(f"{where} is not positive definite {wrong}") from None
    except InputError as error:
        raise InputError(f"{where}: with all contacts stuck {error}") from None
    values, shapes = values[::-1].clip(min=0), np.ascontiguousarray(shapes[:, ::-1])
    rows, shapes = B @ shapes, shapes if apart is None else Q @ shapes
    static = 1 - shift * values
    if rigid:
        static[:rigid] = 1 - 0.5 / slow * values[:rigid]
    static[static < n * np.finfo(float).eps] = 0.0  # damping is no root of round-off
    damping = 2 * (system.damping_ratio or 0.0) * np.sqrt(static * values)
    damping[:rigid] = 0.0
    springs = np.where(opens, k, 0.0) if opens.any() else None
    coupled = None
    if C is not None:
        modal = shapes.conj().T @ C @ shapes
        size = np.sqrt(np.abs(np.outer(modal.diagonal(), modal.diagonal())))
        mixed = np.abs(modal - np.diag(modal.diagonal()))
        if np.all(mixed <= 1e-10 * np.maximum(size, np.abs(modal.diagonal()).max())):
            damping = damping + modal.diagonal().real
        else:
            coupled = modal + np.diag(damping)
            damping = coupled.diagonal().real
    return StuckModes(shapes, rows, values, static, damping, coupled, springs, rigid)


@dataclass(frozen=True)
class HarmonicModes(Product):
    """Stuck modes of all nodal diameters that a number of harmonics has.

    Attributes
    ----------
    diameters : dict of int to StuckModes
        Those that the system has; of N - k where it has k, they are the conjugates.
    """

    diameters: Mapping[int, StuckModes]


@one_thread
def harmonic_modes(
    system: System, harmonics: int, stuck: Mapping[int, StuckModes] | None = None
) -> HarmonicModes:
    """Stuck modes for harmonics 0 to `harmonics`; friction, preload and loads do not matter.

    Those of nodal diameters that are `stuck` are taken as they are.
    """
    stuck = stuck or {}
    wanted = {system.nodal_diameter(h) for h in range(harmonics + 1)}
    wanted |= {(system.sectors - k) % system.sectors for k in wanted}
    held = sorted(wanted & set(system.diameters))
    return HarmonicModes({k: stuck[k] if k in stuck else stuck_modes(system, k) for k in held})


def check_uncoupled(system: System, modes: StuckModes, nodal_diameter: int, what: str) -> None:
    """Refuse modes that a given C couples, which `what` cannot do with."""
    if modes.coupled_damping is not None:
        joints = "open" if system.opens_in_damping.any() else "stuck"
        raise InputError(
            f"system: nd/{nodal_diameter}/C: given one that couples the modes, joints {joints}: "
            f"{what} allows damping/ratio and a C that they leave diagonal"
        )


def _real(value: Array, where: str) -> Array:
    """The real matrix that a static balance needs."""
    if np.iscomplexobj(value):
        if np.abs(value.imag).max(initial=0.0) > 1e-9 * np.abs(value).max(initial=0.0):
            raise InputError(
                f"system: {where} is not real; choose real coordinates at nodal diameter 0"
            )
        value = value.real
    return np.ascontiguousarray(value)
