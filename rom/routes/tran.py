"""The route "paper": Craig-Bampton with every face dof a master, cyclic symmetry, Tran.

Every constraint mode is formed, faces included.

    { x_m }   [ I  0 ] { x_m }
    { x_s } = [ Ψ  Φ ] { η   },      Ψ = -K_ss⁻¹ K_sm,    K_ss Φ = M_ss Φ Ω²

R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
(1968) 1313-1319. A few interface modes then stand for the dofs of a face:

D.-M. Tran, Component mode synthesis methods using interface modes. Application to structures with
cyclic symmetry, Computers & Structures 79 (2001) 209-222.

With b the face dofs of the cyclic Craig-Bampton matrices and t the retained masters,
x_b = Φ_cs η_cs, Φ_cs modes of the part reduced statically to its faces (Guyan, all other masters
condensed).
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.fem import SingularError, factorise
from vanelock.fem.block_lanczos import krylov_space
from vanelock.rom.component import Component, Reduced
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.fixed_interface.selection import Selection
from vanelock.rom.routes.problem import Problem, cyclic_constraint, not_held
from vanelock.rom.system.system import Matrix


def _interface_basis(K: Matrix, M: Matrix, faces: int, masters: int, count: int) -> Matrix:
    """W_Tran in (x_b, x_t, η) = W_Tran (η_cs, x_t, η)."""
    b, t = slice(0, faces), slice(faces, faces + masters)
    # Static answer of the other masters to the faces; the modal amplitudes stay zero in it.
    X = -np.linalg.solve(K[t, t], K[t, b]) if masters else np.zeros((0, faces), K.dtype)
    S = K[b, b] + K[b, t] @ X
    M_aux = M[b, b] + M[b, t] @ X + X.conj().T @ (M[t, b] + M[t, t] @ X)
    modes = sl.eigh(hermitian(S), hermitian(M_aux), subset_by_index=[0, count - 1])[1]
    fixed = len(K) - faces - masters
    W = np.zeros((len(K), count + masters + fixed), K.dtype)
    W[b, :count] = modes
    W[faces:, count:] = np.eye(masters + fixed)
    return W


_COLUMNS = 128  # constraint modes at a time: each block is multiplied with all of them


@dataclass(frozen=True)
class CraigBampton:
    """Real reduced matrices in the coordinates (x_m, η)."""

    K: Floats
    """(b, b), stiffness, N/m, and mass, kg; b = 3·(number of master nodes) + number of modes."""
    M: Floats
    fixed_modes: Floats  # (s, f), Φ, mass-normalised, on the slave dofs
    problem: Problem  # the part

    def forget_answers(self) -> None:
        """Nothing: all diameters take all of it."""


def craig_bampton(problem: Problem, selection: Selection) -> CraigBampton:
    """Reduce a part to the dofs of its faces and masters, in this order, and its modes."""
    m = problem.boundary_rows
    s = np.setdiff1d(np.arange(problem.K.shape[0]), m)
    K, M = problem.K, problem.M
    K_s, M_s = K[s], M[s]
    K_sm, M_sm, M_ss = K_s[:, m], M_s[:, m], M_s[:, s].tocsc()
    try:
        factor = factorise(K_s[:, s].tocsc())
    except SingularError as error:
        raise InputError(not_held(problem, error, s)) from None

    K_mm, M_mm = K[m][:, m].toarray(), M[m][:, m].toarray()
    K_ms, M_ms = K_sm.T.tocsr(), M_sm.T.tocsr()
    Psi = np.empty((len(s), len(m)), order="F")
    blocks = [slice(start, start + _COLUMNS) for start in range(0, len(m), _COLUMNS)]
    for block in blocks:
        Psi[:, block] = -factor.solve(K_sm[:, block].toarray())
        K_mm[:, block] += K_ms @ Psi[:, block]
        M_mm[:, block] += M_ms @ Psi[:, block]
    for block in blocks:
        M_mm[:, block] += Psi.T @ (M_sm[:, block].toarray() + M_ss @ Psi[:, block])

    modes = selection.modes_in(krylov_space(factor.solve, M_ss))
    Phi = modes.vectors
    M_me = M_ms @ Phi + Psi.T @ (M_ss @ Phi)
    K_cb = sl.block_diag(hermitian(K_mm), np.diag(modes.omega_squared))
    M_cb = np.block([[hermitian(M_mm), M_me], [M_me.T, np.eye(Phi.shape[1])]])
    return CraigBampton(K_cb, M_cb, Phi, problem)


def paper(dense: CraigBampton, diameters: Iterable[int], interface_modes: int) -> Component:
    """Reduce a cyclic part exactly as published, at nodal diameters."""
    problem = dense.problem
    return Component(
        masters=problem.masters,
        cyclic=True,
        route="paper",
        interface_modes=interface_modes,
        fixed_modes=dense.fixed_modes.shape[1],
        diameters={k: _at_diameter(problem, dense, k, interface_modes) for k in diameters},
        boundary_nodes=problem.boundary_nodes,
        vectors=dense.fixed_modes,
    )


def _at_diameter(
    problem: Problem, part: CraigBampton, nodal_diameter: int, interface_modes: int
) -> Reduced:
    """Cyclic symmetry, then Tran, of Craig-Bampton matrices with the two faces first."""
    faces, masters = len(problem.left), len(problem.rows)
    sectors = problem.model.part.sectors
    W_cs = cyclic_constraint(faces, len(part.K) - 6 * faces, nodal_diameter, sectors)
    K = W_cs.conj().T @ (part.K @ W_cs)
    M = W_cs.conj().T @ (part.M @ W_cs)
    W = _interface_basis(K, M, 3 * faces, masters, interface_modes)
    return Reduced(hermitian(W.conj().T @ K @ W), hermitian(W.conj().T @ M @ W), basis=W_cs @ W)
