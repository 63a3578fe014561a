"""Craig-Bampton reduction with every constraint mode formed, faces included.

    { x_m }   [ I  0 ] { x_m }
    { x_s } = [ Ψ  Φ ] { η   },      Ψ = -K_ss⁻¹ K_sm,    K_ss Φ = M_ss Φ Ω²

R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
(1968) 1313-1319.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.fem import SingularError, factorise
from vanelock.fem.vibration.block_lanczos import krylov_space
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.fixed_interface.selection import Selection
from vanelock.rom.routes.problem import Problem, not_held

COLUMNS = 128  # constraint modes at a time: each block is multiplied with all of them


@dataclass(frozen=True)
class CraigBampton:
    """Real reduced matrices in the coordinates (x_m, η).

    Attributes
    ----------
    K, M : (b, b) float
        Stiffness, N/m, and mass, kg; b = 3·(number of master nodes) + number of modes.
    fixed_modes : (s, f) float
        Φ, mass-normalised, on the slave dofs.
    """

    K: NDArray[np.float64]
    M: NDArray[np.float64]
    fixed_modes: NDArray[np.float64]


def craig_bampton(problem: Problem, wanted: Selection) -> CraigBampton:
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
    blocks = [slice(start, start + COLUMNS) for start in range(0, len(m), COLUMNS)]
    for block in blocks:
        Psi[:, block] = -factor.solve(K_sm[:, block].toarray())
        K_mm[:, block] += K_ms @ Psi[:, block]
        M_mm[:, block] += M_ms @ Psi[:, block]
    for block in blocks:
        M_mm[:, block] += Psi.T @ (M_sm[:, block].toarray() + M_ss @ Psi[:, block])

    modes = wanted.modes_in(krylov_space(factor.solve, M_ss))
    Phi = modes.vectors
    M_me = M_ms @ Phi + Psi.T @ (M_ss @ Phi)
    K_cb = sl.block_diag(hermitian(K_mm), np.diag(modes.omega_squared))
    M_cb = np.block([[hermitian(M_mm), M_me], [M_me.T, np.eye(Phi.shape[1])]])
    return CraigBampton(K_cb, M_cb, Phi)
