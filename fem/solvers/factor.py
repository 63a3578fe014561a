"""Factorisation of positive definite sparse matrices, behind one small interface.

CHOLMOD is used where scikit-sparse is installed, else PARDISO through pypardiso, else SciPy's
SuperLU, which always works and is several times slower; docs/benchmarks/factorisation.md compares
them.

PARDISO takes real matrices alone: a complex Hermitian one becomes [Re -Im; Im Re], symmetric, of
twice the size and with every eigenvalue twice.
"""

import weakref
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats
from vanelock.common.errors import InputError
from vanelock.fem.solvers.backend import (
    MEMORY_TIMES,
    BreakdownError,
    Factor,
    Sparse,
    cholmod,
    hermitian,
    require_memory,
)
from vanelock.fem.solvers.singular import (
    FREE,
    SingularError,
    free_motions,
    is_singular,
    scale_of,
)

_DEFINITE = 2  # matrix type of PARDISO: real symmetric
_SOLVE = 33  # its phase of forward and backward substitution
_NONZEROS = 18  # of its iparm, counted from 1


def _pardiso(A: sp.csc_array) -> Factor:
    """Factorise a matrix in canonical form."""
    module = import_module("pypardiso")
    n = A.shape[0]
    is_complex = np.iscomplexobj(A.data)
    if is_complex:
        A = sp.block_array([[A.real, -A.imag], [A.imag, A.real]], format="csr")
    upper = _upper(A)
    solver = module.PyPardisoSolver(mtype=_DEFINITE)
    try:
        solver.factorize(upper)
    except module.pardiso_wrapper.PyPardisoError:
        raise BreakdownError from None
    # It keeps a copy of the matrix, to which `solve` compares its argument at every call.
    solver.remove_stored_factorization()
    solver.set_phase(_SOLVE)

    def substitute(b: Array) -> Array:
        return np.asarray(solver._call_pardiso(upper, b)).reshape(b.shape)

    def solve(b: Array) -> Array:
        if not is_complex:
            return substitute(b)
        x = substitute(np.asfortranarray(np.vstack([b.real, b.imag])))
        return x[:n] + 1j * x[n:]

    weakref.finalize(solve, solver.free_memory, everything=True)  # the library never does
    nonzeros = int(solver.get_iparm(_NONZEROS))
    return Factor("pardiso", n, is_complex, nonzeros, solve)


def _upper(A: Any) -> sp.csr_matrix:
    """Upper half, with every entry of the diagonal stored, zeros too, as PARDISO demands."""
    half = sp.triu(A, format="coo")
    on = np.arange(A.shape[0])
    entries = np.concatenate([half.data, np.zeros(len(on))])
    places = np.concatenate([half.row, on]), np.concatenate([half.col, on])
    return sp.csr_matrix(sp.coo_array((entries, places), shape=A.shape).tocsr())


def _superlu(A: sp.csc_array) -> Factor:
    """Factorise a matrix in canonical form.

    Pivots stay on the diagonal unless they vanish: their signs are those of the eigenvalues.
    """
    from scipy.sparse.linalg import splu

    try:
        factor = splu(
            A,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:
        raise BreakdownError from None
    if not np.array_equal(factor.perm_r, factor.perm_c) or factor.U.diagonal().real.min() <= 0:
        raise BreakdownError
    return Factor("superlu", A.shape[0], np.iscomplexobj(A.data), factor.nnz, factor.solve)


_MODULES = {"cholmod": "sksparse", "pardiso": "pypardiso", "superlu": "scipy"}
_SOLVERS: dict[str, Callable[[sp.csc_array], Factor]] = {
    "cholmod": cholmod,
    "pardiso": _pardiso,
    "superlu": _superlu,
}
_LIFT = 1e-10  # added to a matrix that has no factors, so that it has some
_NOT_DEFINITE = (
    "the matrix is not positive definite: a part that is free to move as a rigid body needs "
    "a clamped set or a negative shift"
)


def backends() -> tuple[str, ...]:
    """Names of the backends that can be imported, the preferred one first."""
    return tuple(name for name, module in _MODULES.items() if find_spec(module) is not None)


def factorise(A: Sparse | Array, backend: str | None = None) -> Factor:
    """Factorise a positive definite sparse matrix.

    Parameters
    ----------
    A : (n, n) sparse
        Real symmetric or complex Hermitian; both halves must be stored.
    backend : str, optional
        One of `backends()`; by default the fastest of them.

    Raises
    ------
    SingularError
        If A is singular: some motion is free. It names the rows that move.
    InputError
        If A has negative eigenvalues, is not Hermitian, or the backend is unknown or missing.

    Examples
    --------
    >>> import scipy.sparse as sp
    >>> A = sp.diags_array([[2.0, 4.0]], offsets=[0])
    >>> factorise(A).solve([1.0, 1.0])
    array([0.5 , 0.25])
    """
    A = hermitian(A)
    have = backends()
    if backend is not None and backend not in have:
        raise InputError(f"backend = {backend!r}: the installed solvers are {', '.join(have)}")
    backend = backend or have[0]
    scale = scale_of(A)
    try:
        factor = _factors(A, backend)
    except BreakdownError:
        raise _diagnosis(A, backend, scale) from None
    if is_singular(factor.solve, scale):
        raise SingularError(free_motions(A, factor.solve, scale)[0])
    return factor


def _factors(A: sp.csc_array, backend: str) -> Factor:
    require_memory(A.shape[0], np.iscomplexobj(A.data), MEMORY_TIMES[backend])
    return _SOLVERS[backend](A)


def _diagnosis(A: sp.csc_array, backend: str, scale: Floats) -> InputError:
    """The error for a matrix that has no factors."""
    error = _empty_rows(A)
    if error is not None:
        return error
    diagonal = A.diagonal().real
    if diagonal.min() <= 0:
        return InputError(f"{_NOT_DEFINITE} (row {int(diagonal.argmin())} of its diagonal)")
    try:
        near = _factors(sp.csc_array(A + sp.diags_array(_LIFT * scale**2)), backend)
    except BreakdownError:
        return InputError(_NOT_DEFINITE)
    motions, values = free_motions(A, near.solve, scale)
    return InputError(_NOT_DEFINITE) if values[0] < -FREE else SingularError(motions)


def _empty_rows(A: sp.csc_array) -> SingularError | None:
    """Error for rows that hold nothing, if there are any."""
    rows = np.flatnonzero(abs(A).max(axis=1).toarray().ravel() == 0)
    if not len(rows):
        return None
    motions: Any = np.zeros((A.shape[0], len(rows)))
    motions[rows, np.arange(len(rows))] = 1
    return SingularError(motions)
