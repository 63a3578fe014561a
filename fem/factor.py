"""Factorisation of a sparse positive definite matrix, behind one small interface.

CHOLMOD (supernodal Cholesky, real and complex) is used where scikit-sparse is installed, else
PARDISO through pypardiso (real; a complex matrix as a real one of twice the size), else SciPy's
SuperLU, which always works and is several times slower.
"""

import weakref
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.errors import InputError

Matrix = NDArray[Any]
Solve = Callable[[Matrix], Matrix]

_MODULES = {"cholmod": "sksparse", "pardiso": "pypardiso", "superlu": "scipy"}

COLUMNS = 128  # right-hand sides at once: beyond that a solver gains nothing more
BYTES = 2**28  # and no more of them than fit in this

# Smallest eigenvalue of the matrix scaled to a unit diagonal, below which it is singular. Round-off
# leaves some 1e-17 where a rigid-body motion is free; thin flat elements come down to 1e-15.
SINGULAR = 1e-16


@dataclass(frozen=True)
class Factor:
    """A factorised Hermitian positive definite matrix A.

    Attributes
    ----------
    backend : str
        "cholmod", "pardiso" or "superlu".
    size : int
        Rows of A.
    is_complex : bool
        Whether A is.
    """

    backend: str
    size: int
    is_complex: bool
    _solve: Solve

    def solve(self, b: Any) -> Matrix:
        """Solution x of A x = b.

        Parameters
        ----------
        b : (n,) or (n, k) array, or sparse
            Right-hand sides, real or complex whatever A is. They are solved in blocks, a sparse b
            being made dense one block at a time.

        Returns
        -------
        (n,) or (n, k) array
            Complex if A or b is.
        """
        if not sp.issparse(b):
            b = np.asarray(b)
        if b.shape[0] != self.size or b.ndim > 2:
            raise ValueError(f"right-hand side of shape {b.shape} for a matrix of {self.size} rows")
        kind = np.complex128 if self.is_complex or np.iscomplexobj(b) else np.float64
        if b.ndim == 1:
            column = b.toarray() if sp.issparse(b) else b
            return self._block(column[:, None])[:, 0].astype(kind, copy=False)
        if sp.issparse(b):
            b = b.tocsc()
        x = np.empty(b.shape, kind, order="F")
        width = max(1, min(COLUMNS, BYTES // (self.size * x.itemsize)))
        for start in range(0, b.shape[1], width):
            block = b[:, start : start + width]
            x[:, start : start + width] = self._block(
                block.toarray() if sp.issparse(block) else block
            )
        return x

    def _block(self, b: Matrix) -> Matrix:
        if self.is_complex:
            return self._solve(np.asfortranarray(b, np.complex128))
        if not np.iscomplexobj(b):
            return self._solve(np.asfortranarray(b, np.float64))
        k = b.shape[1]
        x = self._solve(np.asfortranarray(np.hstack([b.real, b.imag])))
        return x[:, :k] + 1j * x[:, k:]


def backends() -> tuple[str, ...]:
    """Names of the backends that can be imported, the preferred one first."""
    return tuple(name for name, module in _MODULES.items() if find_spec(module) is not None)


def factorise(A: Any, backend: str | None = None) -> Factor:
    """Factorise a symmetric or Hermitian positive definite sparse matrix.

    Parameters
    ----------
    A : (n, n) sparse
        Real symmetric or complex Hermitian; both halves must be stored.
    backend : str, optional
        One of `backends()`; its first unless given.

    Raises
    ------
    InputError
        If A is not positive definite, singular included, or the backend is unknown or missing.

    Examples
    --------
    >>> import scipy.sparse as sp
    >>> A = sp.diags_array([[2.0, 4.0]], offsets=[0])
    >>> factorise(A).solve([1.0, 1.0])
    array([0.5 , 0.25])
    """
    have = backends()
    backend = backend or have[0]
    if backend not in have:
        raise InputError(f"backend = {backend!r}: the installed solvers are {', '.join(have)}")
    A = sp.csc_array(A)
    if A.shape[0] != A.shape[1] or A.shape[0] == 0:
        raise InputError(f"matrix of shape {A.shape}: it must be square and not empty")
    if not np.all(np.isfinite(A.data)):
        raise InputError("the matrix holds values that are not finite")
    is_complex = np.iscomplexobj(A.data)
    if not A.has_canonical_format:  # unsorted, or with duplicates: in a copy, not in the caller's
        A = A.copy()
        A.sum_duplicates()
    data = np.ascontiguousarray(A.data, np.complex128 if is_complex else np.float64)
    A = sp.csc_array((data, A.indices, A.indptr), shape=A.shape)
    diagonal = A.diagonal().real
    if diagonal.min() <= 0:
        raise InputError(f"{_NOT_DEFINITE} (row {int(diagonal.argmin())} of its diagonal)")
    solve = {"cholmod": _cholmod, "pardiso": _pardiso, "superlu": _superlu}[backend](A)
    factor = Factor(backend, A.shape[0], is_complex, solve)
    _refuse_singular(factor, diagonal)
    return factor


_NOT_DEFINITE = (
    "the matrix is not positive definite: a part that is free to move as a rigid body needs "
    "a clamped set or a negative shift"
)


def _refuse_singular(factor: Factor, diagonal: NDArray[np.float64]) -> None:
    """Inverse iteration for the smallest eigenvalue of A scaled to a unit diagonal."""
    scale = np.sqrt(diagonal)
    x = np.random.default_rng(0).standard_normal(factor.size)
    for _ in range(2):
        x /= np.linalg.norm(x)
        x = scale * factor.solve(scale * x)
        growth = np.linalg.norm(x)
        if not growth * SINGULAR < 1:
            raise InputError(_NOT_DEFINITE)


def _cholmod(A: sp.csc_array) -> Solve:
    from sksparse.cholmod import CholmodNotPositiveDefiniteError, cholesky

    try:
        factor = cholesky(A, mode="supernodal")
    except CholmodNotPositiveDefiniteError:
        raise InputError(_NOT_DEFINITE) from None
    return lambda b: np.asarray(factor(b))


def _superlu(A: sp.csc_array) -> Solve:
    from scipy.sparse.linalg import splu

    try:
        # Pivots stay on the diagonal, so that their signs are those of the eigenvalues.
        factor = splu(
            A,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:
        raise InputError(_NOT_DEFINITE) from None
    if np.any(factor.U.diagonal().real <= 0):
        raise InputError(_NOT_DEFINITE)
    return lambda b: np.asarray(factor.solve(b))


def _pardiso(A: sp.csc_array) -> Solve:
    pypardiso = import_module("pypardiso")
    n = A.shape[0]
    is_complex = np.iscomplexobj(A.data)
    if is_complex:  # [Re -Im; Im Re] is symmetric positive definite if A is Hermitian and so
        A = sp.block_array([[A.real, -A.imag], [A.imag, A.real]], format="csr")
    upper = sp.csr_matrix(sp.triu(A, format="csr"))
    solver = pypardiso.PyPardisoSolver(mtype=2)
    try:
        solver.factorize(upper)
    except pypardiso.pardiso_wrapper.PyPardisoError:
        raise InputError(_NOT_DEFINITE) from None

    def solve(b: Matrix) -> Matrix:
        if not is_complex:
            return np.asarray(solver.solve(upper, b)).reshape(b.shape)
        stacked = np.asfortranarray(np.vstack([b.real, b.imag]))
        x = np.asarray(solver.solve(upper, stacked)).reshape(stacked.shape)
        return x[:n] + 1j * x[n:]

    weakref.finalize(solve, solver.free_memory, everything=True)  # the library never does
    return solve
