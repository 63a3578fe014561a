"""Factorisation of sparse symmetric and Hermitian matrices, behind one small interface.

CHOLMOD is used where scikit-sparse is installed, else PARDISO through pypardiso, else SciPy's
SuperLU, which always works and is several times slower. An indefinite matrix prefers PARDISO, then
CHOLMOD if real and SuperLU if complex. docs/benchmarks/factorisation.md compares them.

PARDISO takes real matrices alone: a complex Hermitian one becomes [Re -Im; Im Re], symmetric, of
twice the size and with every eigenvalue twice.
"""

import weakref
from collections.abc import Callable
from dataclasses import replace
from functools import partial
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
    Solve,
    Sparse,
    cholmod,
    hermitian,
    require_memory,
)
from vanelock.fem.solvers.singular import (
    FREE,
    SingularError,
    empty_rows,
    free_motions,
    is_singular,
    lifted,
    scale_of,
)

_DEFINITE, INDEFINITE = 2, -2  # matrix types of PARDISO: real symmetric
_SOLVE = 33  # its phase of forward and backward substitution
_NEGATIVE, _NONZEROS, _PERTURBED = 23, 18, 14  # of its iparm, counted from 1


def _pardiso(A: sp.csc_array, definite: bool, like: Any = None) -> Factor:
    """Factorise a matrix in canonical form; `like` is not used.

    Its analysis lives in the handle of one factorisation and cannot be shared by two.
    """
    module = import_module("pypardiso")
    n = A.shape[0]
    is_complex = np.iscomplexobj(A.data)
    if is_complex:
        A = sp.block_array([[A.real, -A.imag], [A.imag, A.real]], format="csr")
    upper = _upper(A)
    solver = module.PyPardisoSolver(mtype=_DEFINITE if definite else INDEFINITE)
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
    negative: int | None = 0
    if not definite:
        count = int(solver.get_iparm(_NEGATIVE)) // (2 if is_complex else 1)
        negative = None if solver.get_iparm(_PERTURBED) else count
    nonzeros = int(solver.get_iparm(_NONZEROS))
    return Factor("pardiso", n, is_complex, negative, nonzeros, solve)


def _upper(A: Any) -> sp.csr_matrix:
    """Upper half, with every entry of the diagonal stored, zeros too, as PARDISO demands."""
    half = sp.triu(A, format="coo")
    on = np.arange(A.shape[0])
    entries = np.concatenate([half.data, np.zeros(len(on))])
    places = np.concatenate([half.row, on]), np.concatenate([half.col, on])
    return sp.csr_matrix(sp.coo_array((entries, places), shape=A.shape).tocsr())


def _superlu(A: sp.csc_array, definite: bool, like: Any = None, threshold: float = 0.0) -> Factor:
    """Factorise a matrix in canonical form.

    With a threshold of 0 the pivots stay on the diagonal unless they vanish, so that their signs
    are those of the eigenvalues. Above, a pivot smaller than that part of its column is changed
    for another, which bears any regular matrix and loses the inertia. `like` is not used.
    """
    from scipy.sparse.linalg import splu

    try:
        factor = splu(
            A,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=threshold,
            options={"SymmetricMode": True},
        )
    except RuntimeError:
        raise BreakdownError from None
    negative = None
    if np.array_equal(factor.perm_r, factor.perm_c):
        negative = int(np.sum(factor.U.diagonal().real <= 0))
    if definite and negative != 0:
        raise BreakdownError
    is_complex = np.iscomplexobj(A.data)
    return Factor("superlu", A.shape[0], is_complex, negative, factor.nnz, factor.solve)


_MODULES = {"cholmod": "sksparse", "pardiso": "pypardiso", "superlu": "scipy"}
_SOLVERS: dict[str, Callable[..., Factor]] = {
    "cholmod": cholmod,
    "pardiso": _pardiso,
    "superlu": _superlu,
}
# In order of preference. CHOLMOD's simplicial solve is poor at complex numbers.
_INDEFINITE = {False: ("pardiso", "cholmod", "superlu"), True: ("pardiso", "superlu", "cholmod")}

# Backward error of the solution for a random right-hand side.
_ACCURATE = 1e-14  # above it every solution is refined once
_COUNTED = 1e-10  # above it, before that step, the negative pivots are not counted
_USABLE = 1e-11  # above it, refined, the factors are thrown away

_NOT_DEFINITE = (
    "the matrix is not positive definite: a part that is free to move as a rigid body needs "
    "a clamped set or a negative shift"
)


def backends() -> tuple[str, ...]:
    """Names of the backends that can be imported, the preferred one first."""
    return tuple(name for name, module in _MODULES.items() if find_spec(module) is not None)


def factorise(
    A: Sparse | Array, backend: str | None = None, like: Factor | None = None, definite: bool = True
) -> Factor:
    """Factorise a symmetric or Hermitian sparse matrix.

    Parameters
    ----------
    A : (n, n) sparse
        Real symmetric or complex Hermitian; both halves must be stored.
    backend : str, optional
        One of `backends()`; by default the fastest of them.
    like : Factor, optional
        Of an earlier matrix with the same pattern, whose ordering and symbolic analysis are used
        again: of the same sector at another nodal diameter, say. Between real and complex, or
        definite and indefinite, CHOLMOD shares the ordering alone. A matrix with another pattern,
        and one that goes to PARDISO or SuperLU, is analysed anew.
    definite : bool
        Whether A must be positive definite. False takes any regular matrix, K - ω² M between its
        eigenvalues for instance, at up to six times the cost.

    Raises
    ------
    SingularError
        If A is singular: some motion is free. It names the rows that move.
    InputError
        If A has negative eigenvalues and must not, is not Hermitian, or the backend is unknown
        or missing.

    Notes
    -----
    An indefinite matrix is factorised without exchanging rows, or with small perturbations
    (PARDISO), which gives the number of negative eigenvalues. The solution for a random
    right-hand side decides whether that is accurate, needs a step of iterative refinement each
    time, or gives way to SuperLU with threshold pivoting, which has no such count.

    Examples
    --------
    >>> import scipy.sparse as sp
    >>> A = sp.diags_array([[2.0, 4.0]], offsets=[0])
    >>> factorise(A).solve([1.0, 1.0])
    array([0.5 , 0.25])
    >>> factorise(-A, definite=False).negative
    2
    """
    A = hermitian(A)
    is_complex = np.iscomplexobj(A.data)
    backend = _chosen(backend, is_complex, definite)
    scale = scale_of(A, definite)
    try:
        factor = _factors(A, backend, definite, like)
    except BreakdownError:
        raise _diagnosis(A, backend, definite, scale) from None
    if is_singular(factor.solve, scale):
        motions, _ = free_motions(A, factor.solve, scale)
        raise SingularError(motions, definite)
    return factor


def _chosen(backend: str | None, is_complex: bool, definite: bool) -> str:
    """The backend that is wanted, or the fastest one."""
    have = backends()
    if backend is None:
        preferred = have if definite else _INDEFINITE[is_complex]
        return next(name for name in preferred if name in have)
    if backend not in have:
        raise InputError(f"backend = {backend!r}: the installed solvers are {', '.join(have)}")
    return backend


def _factors(A: sp.csc_array, backend: str, definite: bool, like: Factor | None = None) -> Factor:
    """Factors that are accurate."""
    solver = _SOLVERS[backend]
    require_memory(A.shape[0], np.iscomplexobj(A.data), MEMORY_TIMES[backend])
    analysis = like._analysis if like is not None else None
    if definite:
        return solver(A, True, analysis)
    pivoting: Callable[..., Factor] = partial(_superlu, threshold=0.1)
    for attempt in (solver, pivoting):
        try:
            return _accurate(A, attempt(A, False, analysis))
        except BreakdownError:
            continue
    raise BreakdownError


def _accurate(A: sp.csc_array, factor: Factor) -> Factor:
    """The factors, with a step of refinement if they need it."""
    error = _backward_error(A, factor._solve)
    if error < _ACCURATE:
        return factor

    def refined(b: Array) -> Array:
        x = factor._solve(b)
        return x + factor._solve(np.asfortranarray(b - A @ x))

    if not _backward_error(A, refined) < _USABLE:
        raise BreakdownError
    # The signs of the pivots are those of a matrix that is as far away as this error.
    negative = factor.negative if error < _COUNTED else None
    return replace(factor, _solve=refined, negative=negative)


def _backward_error(A: sp.csc_array, solve: Solve) -> float:
    b = np.random.default_rng(2).standard_normal((A.shape[0], 1)).astype(A.dtype)
    x = solve(np.asfortranarray(b))
    if not np.all(np.isfinite(x)):
        return np.inf
    size = float(abs(A).sum(axis=1).max())
    return float(abs(b - A @ x).max() / (size * abs(x).max() + abs(b).max()))


def _diagnosis(A: sp.csc_array, backend: str, definite: bool, scale: Floats) -> InputError:
    """The error for a matrix that has no factors."""
    error = empty_rows(A, definite)
    if error is not None:
        return error
    diagonal = A.diagonal().real
    if definite and diagonal.min() <= 0:
        return InputError(f"{_NOT_DEFINITE} (row {int(diagonal.argmin())} of its diagonal)")
    try:
        near = _factors(lifted(A, scale), backend, definite)
    except BreakdownError:
        return InputError(_NOT_DEFINITE)
    motions, values = free_motions(A, near.solve, scale)
    if definite and values[0] < -FREE:
        return InputError(_NOT_DEFINITE)
    return SingularError(motions, definite)
