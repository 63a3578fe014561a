"""The form in which a matrix goes to a solver."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.common.errors import InputError

SYMMETRIC = 1e-12  # of |x| |A y|: how far xᴴ(A y) may be from (A x)ᴴ y


def hermitian(A: Any) -> sp.csc_array:
    """A in compressed columns, sorted, without duplicates and in double precision."""
    A = sp.csc_array(A)
    if A.shape[0] != A.shape[1] or A.shape[0] == 0:
        raise InputError(f"matrix of shape {A.shape}: it must be square and not empty")
    if not np.all(np.isfinite(A.data)):
        raise InputError("the matrix holds values that are not finite")
    if not A.has_canonical_format:  # in a copy, not in the caller's
        A = A.copy()
        A.sum_duplicates()
    kind = np.complex128 if np.iscomplexobj(A.data) else np.float64
    data = np.ascontiguousarray(A.data, kind)
    A = sp.csc_array((data, A.indices, A.indptr), shape=A.shape)
    x, y = np.random.default_rng(1).standard_normal((2, A.shape[0]))
    Ax, Ay = A @ x, A @ y
    if abs(x @ Ay - Ax.conj() @ y) > SYMMETRIC * np.linalg.norm(x) * np.linalg.norm(Ay):
        raise InputError("the matrix is not Hermitian: both its halves must be stored, and agree")
    return A
