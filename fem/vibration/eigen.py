"""Lowest eigenpairs of K x = λ M x by shift-invert block Lanczos."""

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.fem.solvers.backend import Matrix
from vanelock.fem.solvers.factor import Factor, factorise
from vanelock.fem.vibration.block_lanczos import krylov_space, lowest_modes

DENSE = 200  # below this size, or for most of the spectrum, a dense solve is as fast and simpler


def eigenpairs(
    K: sp.csc_array,
    M: sp.csc_array,
    count: int,
    shift: float = 0.0,
    factor: Factor | None = None,
) -> tuple[NDArray[np.float64], Matrix]:
    """Lowest eigenvalues and mass-normalised vectors of K x = λ M x.

    Parameters
    ----------
    K, M : (n, n) sparse
        Real symmetric or complex Hermitian; M positive definite.
    count : int
        How many.
    shift : float
        K - shift M must be positive definite: 0 for a supported part, negative for a free one.
    factor : Factor, optional
        Of K - shift M, where it exists already.

    Returns
    -------
    omega_squared : (count,) float
        Ascending, rad²/s² for stiffness and mass.
    vectors : (n, count)
        Real if K and M are; xᴴ M x = 1, and the component of largest modulus is real positive.

    Raises
    ------
    InputError
        If count is not between 1 and n, or K - shift M is not positive definite.

    Notes
    -----
    `block_lanczos` runs on (K - shift M)⁻¹ M from a fixed start, so that equal matrices give equal
    bits.
    """
    n = K.shape[0]
    if not 1 <= count <= n:
        raise InputError(f"count = {count}: a model of {n} dofs has 1 to {n} modes")
    if factor is None:
        factor = factorise(K - shift * M if shift else K)
    if n <= DENSE or count > n // 4:
        values, vectors = scipy.linalg.eigh((K - shift * M).toarray(), M.toarray())
    else:
        mass = M.astype(complex, copy=False) if factor.is_complex else M
        found = lowest_modes(krylov_space(factor.solve, mass), count)
        values, vectors = found.omega_squared, found.vectors
    return shift + values[:count], _oriented(vectors[:, :count])


def _oriented(vectors: Matrix) -> Matrix:
    """Vectors turned so that their largest component is real and positive."""
    largest = vectors[np.argmax(abs(vectors), axis=0), np.arange(vectors.shape[1])]
    oriented: Matrix = vectors * (abs(largest) / largest)
    return oriented
