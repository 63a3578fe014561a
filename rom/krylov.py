"""Lowest modes of a stiffness that can be solved with, by block Lanczos.

The operator K⁻¹M is self-adjoint in the inner product of M; its largest eigenvalues are the inverse
of the lowest ω². A Krylov space is built block by block, each made M-orthonormal to all before,
and searched by Rayleigh-Ritz. Blocks of right-hand sides cost a sparse solver a fraction of as many
single ones, which outweighs that a block method takes a few more of them. (Grimes, Lewis and Simon,
A shifted block Lanczos algorithm, SIAM J. Matrix Anal. Appl. 15 (1994) 228-272.)
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.rom.system import Matrix

Apply = Callable[[Matrix], Matrix]

BLOCK = 8
TOLERANCE = 3e-6
"""Residual of a mode relative to its eigenvalue, whose error is of the second order in it."""
_LARGEST = 400  # blocks


def lowest_modes(
    solve: Apply,
    mass: Apply,
    start: Matrix,
    enough: Callable[[NDArray[np.float64]], int | None],
    tolerance: float = TOLERANCE,
) -> tuple[NDArray[np.float64], Matrix]:
    """Lowest pairs of K x = λ M x.

    Parameters
    ----------
    solve, mass : callable
        K⁻¹ b and M x of blocks of columns.
    start : (n, p)
        Any block that no wanted mode is orthogonal to.
    enough : callable
        From eigenvalue estimates, ascending, to how many of them are wanted; None where more
        are needed to tell.
    tolerance : float
        Largest residual of K⁻¹M x = x/λ, relative to 1/λ, before a last step that reduces it.

    Returns
    -------
    omega_squared : (f,) float
        Ascending.
    vectors : (n, f)
        Mass-normalised.

    Raises
    ------
    InputError
        If the iteration does not converge.
    """
    n = len(start)
    Q = np.empty((n, 0), start.dtype)
    H = np.empty((0, 0), start.dtype)
    block, of_block = _orthonormal(start, mass, Q, Q)
    MQ = Q
    for _ in range(_LARGEST):
        Q, MQ = np.hstack([Q, block]), np.hstack([MQ, of_block])
        grown = solve(of_block)
        H = _bordered(H, MQ.conj().T @ grown, block.shape[1])
        theta, S = sl.eigh(H)
        theta, S = theta[::-1], S[:, ::-1]
        rest = grown - Q @ (MQ.conj().T @ grown)
        block, of_block = _orthonormal(rest, mass, Q, MQ)
        coupling = of_block.conj().T @ rest
        residual = np.linalg.norm(coupling @ S[-rest.shape[1] :], axis=0)
        known = theta > 0
        count = enough(1 / theta[known])
        whole = Q.shape[1] + block.shape[1] > n or block.shape[1] == 0
        if count is None and whole:
            count = int(known.sum())
        if count is not None and count <= len(theta):
            converged = residual[:count] < tolerance * theta[:count]
            if whole or bool(np.all(converged)):
                return _refined(solve, mass, Q @ S[:, :count], theta[:count])
    raise InputError("the fixed-interface modes of the part did not converge")


def _orthonormal(block: Matrix, mass: Apply, Q: Matrix, MQ: Matrix) -> tuple[Matrix, Matrix]:
    """The block made M-orthonormal to Q and in itself, without dependent columns; M times it.

    M is applied once, as it may be dear: its product follows the block's combinations.
    """
    size = np.linalg.norm(block, axis=0)
    block = block[:, size > 0] / size[size > 0]
    of_block = mass(block)
    for _ in range(2):  # twice is enough
        overlap = MQ.conj().T @ block
        block, of_block = block - Q @ overlap, of_block - MQ @ overlap
        values, vectors = sl.eigh(_hermitian(block.conj().T @ of_block))
        kept = values > 1e-14 * values[-1:]
        turn = vectors[:, kept] / np.sqrt(values[kept])
        block, of_block = block @ turn, of_block @ turn
    return block, of_block


def _bordered(H: Matrix, columns: Matrix, width: int) -> Matrix:
    """H with the columns of a new block, and their adjoint as rows."""
    old = len(H)
    grown: Matrix = np.zeros((old + width, old + width), np.result_type(H, columns))
    grown[:old, :old] = H
    grown[:, old:] = columns
    grown[old:, :old] = columns[:old].conj().T
    grown[old:, old:] = _hermitian(columns[old:])
    return grown


def _refined(
    solve: Apply, mass: Apply, X: Matrix, theta: NDArray[np.float64]
) -> tuple[NDArray[np.float64], Matrix]:
    """One step of subspace iteration, which squares the error that is left."""
    load = mass(X / theta)
    X = solve(load)
    values, V = sl.eigh(_hermitian(X.conj().T @ load), _hermitian(X.conj().T @ mass(X)))
    return values, X @ V


def _hermitian(A: Any) -> Matrix:
    return np.asarray((A + A.conj().T) / 2)
