"""Craig-Bampton reduction of one part.

    { x_m }   [ I  0 ] { x_m }
    { x_s } = [ Ψ  Φ ] { η   },      Ψ = -K_ss⁻¹ K_sm,    K_ss Φ = M_ss Φ Ω²

R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
(1968) 1313-1319.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.fem import Model, eigenpairs, factorise

COLUMNS = 200
"""Constraint modes computed at a time: large enough for blocked solves, small in memory."""


@dataclass(frozen=True)
class CraigBampton:
    """Real reduced matrices in the coordinates (x_m, η).

    Attributes
    ----------
    K, M : (b, b) float
        Stiffness, N/m, and mass, kg; b = 3·(number of master nodes) + number of modes.
    nodes : (m,) int
        Master nodes; coordinates 3i to 3i+2 are x, y, z of `nodes[i]`.
    fixed_modes : (s, f) float
        Φ, mass-normalised, on the slave dofs.
    fixed_frequencies : (f,) float
        Ω/2π, Hz.
    """

    K: NDArray[np.float64]
    M: NDArray[np.float64]
    nodes: NDArray[np.int64]
    fixed_modes: NDArray[np.float64]
    fixed_frequencies: NDArray[np.float64]


def partition(
    model: Model, nodes: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Master dofs (x, y, z of each node, in order) and slave dofs (all others).

    Raises
    ------
    InputError
        If a master node is clamped.
    """
    masters = model.dofs[nodes].ravel()
    if np.any(masters < 0):
        clamped = nodes[np.any(model.dofs[nodes] < 0, axis=1)]
        raise InputError(f"{model.part.name}: master node {clamped[0]} is clamped")
    slaves = np.setdiff1d(np.arange(model.K.shape[0]), masters)
    return masters, slaves


def craig_bampton(model: Model, nodes: NDArray[np.int64], modes: int) -> CraigBampton:
    """Reduce a part to master nodes and fixed-interface modes.

    Parameters
    ----------
    model : fem.Model
        The part.
    nodes : (m,) int
        Master nodes, none clamped.
    modes : int
        Number of fixed-interface modes, the lowest ones.

    Raises
    ------
    InputError
        If a master is clamped, there are fewer slaves than modes, or the part is still free to
        move with the masters held.
    """
    m, s = partition(model, nodes)
    if not 0 <= modes < len(s):
        raise InputError(
            f"{model.part.name}: {modes} fixed-interface modes of {len(s)} slave dofs; "
            f"allowed are 0 to {len(s) - 1}"
        )
    K, M = model.K.tocsc(), model.M.tocsc()
    K_sm, M_sm = K[s][:, m], M[s][:, m]
    K_ss, M_ss = K[s][:, s], M[s][:, s]
    factor = factorise(K_ss)

    Psi = np.empty((len(s), len(m)), order="F")
    for start in range(0, len(m), COLUMNS):
        block = slice(start, start + COLUMNS)
        Psi[:, block] = -factor.solve(K_sm[:, block].toarray())

    K_mm = K[m][:, m].toarray() + K_sm.T @ Psi
    M_mm = M[m][:, m].toarray() + M_sm.T @ Psi
    for start in range(0, len(m), COLUMNS):
        block = slice(start, start + COLUMNS)
        M_mm[:, block] += Psi.T @ (M_sm[:, block].toarray() + M_ss @ Psi[:, block])

    if modes:
        omega2, Phi = eigenpairs(K_ss, M_ss, modes, factor=factor)
    else:
        omega2, Phi = np.empty(0), np.empty((len(s), 0))
    M_me = M_sm.T @ Phi + Psi.T @ (M_ss @ Phi)
    K_cb = sl.block_diag((K_mm + K_mm.T) / 2, np.diag(omega2))
    M_cb = np.block([[(M_mm + M_mm.T) / 2, M_me], [M_me.T, np.eye(modes)]])
    return CraigBampton(K_cb, M_cb, nodes, Phi, np.sqrt(omega2) / (2 * np.pi))
