"""Lowest eigenpairs of K x = λ M x by shift-invert Lanczos."""

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, eigsh

from vanelock.common.errors import InputError
from vanelock.fem.solvers.factor import Factor, factorise

Matrix = NDArray[Any]

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
    Lanczos (ARPACK) runs on (K - shift M)⁻¹ M from a fixed start vector, so that equal matrices
    give equal bits. One step of subspace iteration with a Rayleigh-Ritz projection follows, which
    makes vectors of close or repeated eigenvalues orthogonal and squares the error that is left.
    """
    n = K.shape[0]
    if not 1 <= count <= n:
        raise InputError(f"count = {count}: a model of {n} dofs has 1 to {n} modes")
    if factor is None:
        factor = factorise(K - shift * M if shift else K)
    if n <= DENSE or count > n // 4:
        values, vectors = scipy.linalg.eigh((K - shift * M).toarray(), M.toarray())
    else:
        values, vectors = _rayleigh_ritz(factor, M, _lanczos(factor, K, M, count, shift))
    return shift + values[:count], _oriented(vectors[:, :count])


def _lanczos(factor: Factor, K: Any, M: Any, count: int, shift: float) -> Matrix:
    n = factor.size
    start = np.random.default_rng(0).standard_normal(n)
    kind = np.complex128 if factor.is_complex else np.float64
    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=kind)
    wanted = count + 4  # spare ones, since a cluster may straddle the last that is wanted
    _, vectors = eigsh(
        K,
        wanted,
        M,
        sigma=shift,
        which="LM",
        v0=start.astype(kind),
        OPinv=inverse,
        ncv=min(n - 1, max(2 * wanted + 1, wanted + 30)),
    )
    return np.asarray(vectors)


def _rayleigh_ritz(factor: Factor, M: Any, basis: Matrix) -> tuple[NDArray[np.float64], Matrix]:
    """Ritz pairs of K - shift M on X = (K - shift M)⁻¹ M basis, ascending, mass-normalised."""
    load = M @ basis
    X = factor.solve(load)
    stiffness, mass = X.conj().T @ load, X.conj().T @ (M @ X)
    # The columns of X are nearly eigenvectors over (λ - shift): scaled, the mass is nearly one.
    scale = 1 / np.sqrt(np.diagonal(mass).real)
    stiffness, mass = (scale[:, None] * (A + A.conj().T) / 2 * scale for A in (stiffness, mass))
    values, coefficients = scipy.linalg.eigh(stiffness, mass)
    return values, X @ (scale[:, None] * coefficients)


def _oriented(vectors: Matrix) -> Matrix:
    """Vectors turned so that their largest component is real and positive."""
    largest = vectors[np.argmax(abs(vectors), axis=0), np.arange(vectors.shape[1])]
    oriented: Matrix = vectors * (abs(largest) / largest)
    return oriented
