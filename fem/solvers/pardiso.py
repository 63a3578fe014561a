"""PARDISO of Intel's MKL through pypardiso.

It takes real matrices alone: a complex Hermitian one becomes [Re -Im; Im Re], symmetric, of twice
the size and with every eigenvalue twice.
"""

import weakref
from importlib import import_module
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.fem.solvers.backend import BreakdownError, Matrix, Numeric

DEFINITE, INDEFINITE = 2, -2  # matrix types of PARDISO: real symmetric
SOLVE = 33  # its phase of forward and backward substitution
NEGATIVE, NONZEROS, PERTURBED = 23, 18, 14  # of its iparm, counted from 1


def pardiso(A: sp.csc_array, definite: bool, like: Any = None) -> Numeric:
    """Factorise a matrix in canonical form; `like` is not used.

    Its analysis lives in the handle of one factorisation and cannot be shared by two.
    """
    module = import_module("pypardiso")
    n = A.shape[0]
    is_complex = np.iscomplexobj(A.data)
    if is_complex:
        A = sp.block_array([[A.real, -A.imag], [A.imag, A.real]], format="csr")
    upper = _upper(A)
    solver = module.PyPardisoSolver(mtype=DEFINITE if definite else INDEFINITE)
    try:
        solver.factorize(upper)
    except module.pardiso_wrapper.PyPardisoError:
        raise BreakdownError from None
    # It keeps a copy of the matrix, to which `solve` compares its argument at every call.
    solver.remove_stored_factorization()
    solver.set_phase(SOLVE)

    def substitute(b: Matrix) -> Matrix:
        return np.asarray(solver._call_pardiso(upper, b)).reshape(b.shape)

    def solve(b: Matrix) -> Matrix:
        if not is_complex:
            return substitute(b)
        x = substitute(np.asfortranarray(np.vstack([b.real, b.imag])))
        return x[:n] + 1j * x[n:]

    weakref.finalize(solve, solver.free_memory, everything=True)  # the library never does
    negative: int | None = 0
    if not definite:
        count = int(solver.get_iparm(NEGATIVE)) // (2 if is_complex else 1)
        negative = None if solver.get_iparm(PERTURBED) else count
    return Numeric(solve, negative, int(solver.get_iparm(NONZEROS)))


def _upper(A: Any) -> sp.csr_matrix:
    """Upper half, with every entry of the diagonal stored, zeros too, as PARDISO demands."""
    half = sp.triu(A, format="coo")
    on = np.arange(A.shape[0])
    entries = np.concatenate([half.data, np.zeros(len(on))])
    places = np.concatenate([half.row, on]), np.concatenate([half.col, on])
    return sp.csr_matrix(sp.coo_array((entries, places), shape=A.shape).tocsr())
