"""A part with its masters held: what every choice of fixed-interface vectors starts from.

    Ψ = -K_ss⁻¹ K_sm        constraint modes, the static answer to the masters
    L = M_sm + M_ss Ψ       inertia forces of the static answer, per acceleration of the masters

with K_mm + K_ms Ψ and M_mm + M_ms Ψ + ΨᴴL as the masters' matrices, Guyan's. Ψ and L are not kept.
Of the factors of K_ss it takes one sweep up for Ψ and one down for ΨᴴL and LᴴK_ss⁻¹L.
(For a sector at its nodal diameters `vanelock.rom.fixed_interface.inertia` does better.)

In the lowest modes of K x = ω² M x massless coordinates follow the others without inertia. With M =
Y m Yᴴ, m > 0, and the columns of Z without mass,

    x = X y,    X = Y - Z (Zᴴ K Z)⁻¹ Zᴴ K Y,    Xᴴ K X y = ω² m y.

Y, m and Z are of D M D with D = diag(M)^-1/2, times D, so that kg stand beside kg m².
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem import Interior
from vanelock.rom.fixed_interface.inertia import Inertia, Mass, SweptInertia
from vanelock.rom.system.system import Matrix

Solve = Callable[[Matrix], Matrix]

COLUMNS = 64
"""Constraint modes computed at a time: a column of fewer costs more, and of more as much, since the
system allocates their memory anew."""


class _HeldStiffness(Protocol):
    """The stiffness of a part whose masters are held, as factors."""

    @property
    def stiffness(self) -> Matrix:
        """(m, m) stiffness of the part moved by its masters."""

    def solve(self, b: Matrix) -> Matrix:
        """K_ss⁻¹ b."""


@dataclass(frozen=True)
class HeldMatrices:
    """A part in one piece, condensed to its masters."""

    stiffness: Matrix  # (m, m), of the part moved by its masters
    slaves: Interior  # factors of K_ss

    def solve(self, b: Matrix) -> Matrix:
        """K_ss⁻¹ b."""
        return np.asarray(self.slaves.solve(b))


@dataclass(frozen=True)
class HeldPart:
    """Matrices of a part, m master and s slave dofs; real, or complex at a nodal diameter."""

    held: _HeldStiffness  # K_ss
    M_ss: Mass  # of the slaves
    K_mm: Matrix  # (m, m), stiffness and mass of the part moved by its masters
    M_mm: Matrix
    inertia: Inertia  # L
    compliance: Matrix  # (m, m), Lᴴ K_ss⁻¹ L


def held_part(held: HeldMatrices, M: sp.csc_array, rows: Integers) -> HeldPart:
    """A part whose stiffness is condensed to its kept rows: one blocked solve for each of them."""
    slaves = held.slaves.rest
    M_s, M_mm = M[slaves], M[rows][:, rows]
    M_sm, M_ss = M_s[:, rows].tocsc(), M_s[:, slaves].tocsc()
    s, m = M_sm.shape
    stiffness = held.stiffness
    unit = np.eye(m, dtype=stiffness.dtype)
    halves = np.empty((s, m), stiffness.dtype)
    L = halves if held.slaves.half_is_root else np.empty_like(halves)
    mass = M_mm.toarray().astype(stiffness.dtype)
    M_ms = M_sm.conj().T.tocsr()
    for start in range(0, m, COLUMNS):
        block = slice(start, start + COLUMNS)
        Psi = held.slaves.extend(unit[:, block])
        own = M_ss @ Psi
        direct = M_sm[:, block].tocoo()
        np.add.at(own, direct.coords, direct.data)
        if L is not halves:
            L[:, block] = own
        halves[:, block], of_masters = held.slaves.down(own)
        mass[:, block] += M_ms @ Psi + of_masters
    return HeldPart(
        held,
        M_ss,
        hermitian(stiffness),
        hermitian(mass),
        SweptInertia(held.slaves, M_sm, M_ss),
        hermitian(held.slaves.energy(L, halves)),
    )


def hermitian(A: Matrix) -> Matrix:
    """(A + Aᴴ)/2, without the round-off that is not Hermitian."""
    return np.asarray((A + A.conj().T) / 2)


NONE = 1e-11
"""A scaled mass below this is none."""
_NEGATIVE = 1e-7  # negative scaled mass that is no longer round-off of what wrote the matrix


def lowest(K: Array, M: Array, count: int) -> tuple[Floats, Array]:
    """Lowest modes of Hermitian matrices; fewer than `count` if fewer coordinates have a mass."""
    if _definite(M):
        omega2, shapes = sl.eigh(K, M, subset_by_index=[0, count - 1])
        return omega2, shapes
    refuse_negative_mass(M)
    d = _scale(M)
    mass, U = sl.eigh(d[:, None] * M * d)
    heavy = mass > NONE
    Y, Z = d[:, None] * U[:, heavy], d[:, None] * U[:, ~heavy]
    try:
        follow = sl.cho_solve(sl.cho_factor(Z.conj().T @ K @ Z), Z.conj().T @ K @ Y)
    except sl.LinAlgError:
        raise InputError("a coordinate without mass is held by nothing") from None
    X = (Y - Z @ follow) / np.sqrt(mass[heavy])
    reduced = X.conj().T @ K @ X
    last = min(count, reduced.shape[0]) - 1
    omega2, shapes = sl.eigh((reduced + reduced.conj().T) / 2, subset_by_index=[0, last])
    return omega2, X @ shapes


def refuse_negative_mass(M: Array) -> None:
    """Raise InputError if some motion has a negative mass, which no structure has."""
    d = _scale(M)
    scaled = d[:, None] * M * d
    try:
        sl.cholesky(scaled + _NEGATIVE * np.eye(len(M)), check_finite=False)
    except sl.LinAlgError:
        values = np.linalg.eigvalsh(scaled)
        raise InputError(
            f"the mass matrix is not positive: scaled to a diagonal of ones its smallest "
            f"eigenvalue is {values[0]:.2g}, where 0 or more is needed"
        ) from None


def _scale(M: Array) -> Floats:
    own = M.diagonal().real
    largest = max(float(own.max(initial=0.0)), np.finfo(float).tiny)
    return np.asarray(1 / np.sqrt(np.where(own > 0, own, largest)))


def _definite(M: Array) -> bool:
    """Whether every scaled pivot is a mass."""
    own = M.diagonal().real
    if not np.all(own > 0):
        return False
    d = _scale(M)
    try:
        L = sl.cholesky(d[:, None] * M * d, lower=True, check_finite=False)
    except sl.LinAlgError:
        return False
    return bool(np.all(L.diagonal().real ** 2 > NONE))
