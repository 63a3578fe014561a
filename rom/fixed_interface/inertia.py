"""Inertia forces of the static answers to a part's masters, and what they do.

    L = M_sm + M_ss Ψ,    Ψ = -K_ss⁻¹ K_sm

At a nodal diameter k the masters t of a sector move its faces F as well, y = (x_F, x_t) = Y_k x_t,
and each real motion of the boundary b = (F, t) has one static answer, whatever the diameter. All
Y_k lie in the span of a few real motions Z, the masters' own and U of the faces,

    Y_k = Z C_k,    Z = [0 U; 1 0],    C_k = [1; Uᵀ x_F],

since neighbouring diameters move the faces almost alike. So sweeps with the factors of K_ss are
made for the real columns of Z alone,

    L_Z = M_sb Z + M_ss Ψ Z,    N_Z = M_bb Z + M_bs Ψ Z,    P_Z = Ψᵀ L_Z,    E_Z = L_Zᵀ K_ss⁻¹ L_Z,

and what a nodal diameter needs follows from dense products with C_k.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp

from vanelock.common.arrays import Floats
from vanelock.fem import Interior
from vanelock.rom.system.system import Matrix

_COLUMNS = 128  # motions answered at a time
_SPANNED = 1e-12
"""Part of a face's motion, relative to the largest, that need not lie in the span of U."""


@dataclass(frozen=True)
class SweptInertia:
    """L by sweeps with the factors, a column of which costs no more than one of L itself."""

    slaves: Interior  # factors of K_ss
    M_sm: sp.csc_array  # (s, m) and (s, s), mass
    M_ss: sp.csc_array

    def push(self, x: Matrix) -> Matrix:
        """L x."""
        return np.asarray(self.M_sm @ x + self.M_ss @ self.slaves.extend(x))

    def gather(self, v: Matrix) -> Matrix:
        """Lᴴ v."""
        return np.asarray(self.M_sm.conj().T @ v + self.slaves.restrict(self.M_ss @ v))


@dataclass(frozen=True)
class SectorInertia:
    """L at a nodal diameter; its slaves are the left face's dofs and those of K_ss."""

    left: Matrix  # (l, t), L on the left face
    blocks: tuple[Floats, ...]  # (s, a_i), L_Z
    coefficients: Matrix  # (a, t), C_k

    def push(self, x: Matrix) -> Matrix:
        """L x."""
        c, start, total = self.coefficients @ x, 0, np.zeros(0)
        for i, block in enumerate(self.blocks):
            stop = start + block.shape[1]
            added = real_times(block, c[start:stop])
            total = total + added if i else added
            start = stop
        return np.concatenate([self.left @ x, total])

    def gather(self, v: Matrix) -> Matrix:
        """Lᴴ v."""
        own, rest = v[: len(self.left)], np.ascontiguousarray(v[len(self.left) :])
        of_blocks = np.concatenate([real_times(block.T, rest) for block in self.blocks])
        return np.asarray(self.left.conj().T @ own + self.coefficients.conj().T @ of_blocks)


Inertia = SweptInertia | SectorInertia
"""L as an operator, (s, m)."""


@dataclass(frozen=True)
class _SectorMass:
    """M_ss at a nodal diameter, whose slaves are the left face's dofs and those of K_ss."""

    interior: sp.csr_array  # (s, s), mass of those of K_ss, the same at all nodal diameters
    across: sp.csr_array  # (F, s), that between them and both faces
    on_faces: sp.csr_array  # (l, l), that of the faces, Wᴴ M_FF W
    follow: sp.csr_array  # (F, l), W

    @property
    def shape(self) -> tuple[int, int]:
        """(s, s)."""
        size = self.interior.shape[0] + self.follow.shape[1]
        return size, size

    @property
    def dtype(self) -> np.dtype[Any]:
        """That of W."""
        kind: np.dtype[Any] = self.follow.dtype
        return kind

    def diagonal(self) -> Matrix:
        """(s,)."""
        return np.concatenate([self.on_faces.diagonal(), self.interior.diagonal()])

    def __matmul__(self, x: Matrix) -> Matrix:
        """M_ss x."""
        left = self.follow.shape[1]
        x_l, x_s = x[:left], x[left:]
        of_faces = self.on_faces @ x_l + self.follow.conj().T @ real_times(self.across, x_s)
        moved = real_times(self.across.T, self.follow @ x_l)
        return np.concatenate([of_faces, real_times(self.interior, x_s) + moved])


Mass = sp.csc_array | _SectorMass
"""M_ss."""


@dataclass(frozen=True)
class _SpannedMasters:
    """What the masters of a sector do, and the faces with them, at a nodal diameter."""

    blocks: tuple[Floats, ...]  # L_Z
    coefficients: Matrix  # (a, t), C_k
    on_faces: Matrix  # (F, t)
    reaching: Matrix  # (F, t)
    mass: Matrix  # (t, t)
    energy: Matrix  # (t, t)


class BoundaryAnswers:
    """Static answers to real motions of faces and masters, more as nodal diameters ask for more."""

    def __init__(self, interior: Interior, M: sp.csc_array, faces: int) -> None:
        rows, kept = interior.rest, interior.kept_rows
        M_s, M_b = M[rows].tocsr(), M[kept].tocsr()
        self._interior = interior
        self._M_ss, self._M_sb = M_s[:, rows].tocsr(), M_s[:, kept].tocsr()
        self._M_bs, self._M_bb = M_b[:, rows].tocsr(), M_b[:, kept].tocsr()
        self._faces, self._masters = faces, len(kept) - faces
        self._motions: Floats = np.empty((faces, 0))
        self._blocks: list[Floats] = []
        self._halves: list[Floats] = []
        self._inertia: Floats = np.empty((len(kept), 0))
        self._loads: Floats = np.empty((len(kept), 0))
        self._energy: Floats = np.empty((0, 0))

    def mass(self, follow: sp.csr_array) -> _SectorMass:
        """Mass of all but the masters where both faces follow the left one by `follow`."""
        F = self._faces
        on_faces = sp.csr_array(follow.conj().T @ self._M_bb[:F, :F] @ follow)
        return _SectorMass(self._M_ss, self._M_bs[:F], on_faces, follow)

    def at(self, moved: Matrix) -> _SpannedMasters:
        """What the masters do where they move the faces by `moved`, (F, t)."""
        F, t = self._faces, self._masters
        found = np.hstack([moved.real, moved.imag]) if np.iscomplexobj(moved) else moved
        Q, R, _ = sl.qr(self._apart(found, unit=False), mode="economic", pivoting=True)
        least = _SPANNED * np.linalg.norm(found, axis=0).max(initial=0.0)
        new = self._apart(Q[:, : int(np.sum(abs(np.diagonal(R)) > least))])
        own = 0 if self._blocks else t
        Z = np.zeros((F + t, own + new.shape[1]))
        Z[F:, :own], Z[:F, own:] = np.eye(t, own), new
        if Z.shape[1] or not self._blocks:
            self._answer(Z)
        self._motions = np.hstack([self._motions, new])
        C = np.concatenate([np.eye(t), self._motions.T @ moved])
        mass = np.concatenate([self._loads[F:], self._motions.T @ self._loads[:F]])
        return _SpannedMasters(
            blocks=tuple(self._blocks),
            coefficients=C,
            on_faces=real_times(self._inertia[:F], C),
            reaching=real_times(self._loads[:F], C),
            mass=C.conj().T @ real_times(mass, C),
            energy=C.conj().T @ real_times(self._energy, C),
        )

    def _apart(self, x: Floats, unit: bool = True) -> Floats:
        """What of motions is orthogonal to those known; of unit ones, an orthonormal basis.

        What was left of a motion by rounding alone, scaled to unit length, is not orthogonal to
        the others before it is made so once more, and U would not be orthonormal.
        """
        for _ in range(2):
            x = x - self._motions @ (self._motions.T @ x)
        return np.asarray(sl.qr(x, mode="economic")[0]) if unit and x.size else x

    def _answer(self, Z: Floats) -> None:
        """One sweep up and one down for each motion."""
        count, solid = Z.shape[1], self._interior
        L, half = np.empty((2, len(solid.rest), count))
        inertia, loads = np.empty((2, len(Z), count))
        for start in range(0, count, _COLUMNS):
            block = slice(start, start + _COLUMNS)
            z = Z[:, block]
            answer = solid.extend(z)
            L[:, block] = self._M_sb @ z + self._M_ss @ answer
            inertia[:, block] = self._M_bb @ z + self._M_bs @ answer
            half[:, block], gathered = solid.down(L[:, block])
            loads[:, block] = inertia[:, block] + gathered
        energy = solid.energy(L, half)
        before = zip(self._blocks, self._halves, strict=True)
        felt = [solid.energy(*old, half) for old in before]
        across = np.concatenate([np.empty((0, count)), *felt])
        self._energy = np.block([[self._energy, across], [across.T, energy]])
        self._inertia = np.hstack([self._inertia, inertia])
        self._loads = np.hstack([self._loads, loads])
        self._blocks.append(L)
        self._halves.append(half)


def real_times(A: Any, B: Matrix) -> Matrix:
    """A B of a real and a real or complex matrix, without making the first complex."""
    if not np.iscomplexobj(B):
        return np.asarray(A @ B)
    parts = np.ascontiguousarray(B).view(np.float64).reshape(len(B), 2 * B.shape[1])
    return np.ascontiguousarray(A @ parts).view(np.complex128)
