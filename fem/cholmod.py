"""CHOLMOD through scikit-sparse: the fastest of the solvers where it is installed.

Positive definite matrices take the supernodal L Lᴴ. Indefinite ones take the simplicial L D Lᴴ,
which has no pivoting: the signs of D are the inertia, and the caller checks the accuracy.
"""

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.fem.backend import BreakdownError, Numeric


@dataclass(frozen=True)
class Analysis:
    """Ordering and supernodes of one pattern."""

    pattern: bytes
    mode: str
    symbolic: Any


def cholmod(A: sp.csc_array, definite: bool, like: Any = None) -> Numeric:
    """Factorise a matrix in canonical form; `like` is an earlier `Numeric.analysis` or None."""
    from sksparse.cholmod import CholmodNotPositiveDefiniteError, analyze

    mode = "supernodal" if definite else "simplicial"
    if not definite and np.iscomplexobj(A.data):
        A = _with_real_diagonal(A)
    pattern = pattern_of(A)
    if not (isinstance(like, Analysis) and (like.pattern, like.mode) == (pattern, mode)):
        # AMD, the default, leaves the simplicial factor of a solid a third more work.
        ordering = "default" if definite else "nesdis"
        like = Analysis(pattern, mode, analyze(A, mode=mode, ordering_method=ordering))
    try:
        factor = like.symbolic.cholesky(A)
    except CholmodNotPositiveDefiniteError:
        raise BreakdownError from None
    negative = 0 if definite else int(np.sum(factor.D().real < 0))
    return Numeric(lambda b: np.asarray(factor(b)), negative, analysis=like)


def pattern_of(A: sp.csc_array) -> bytes:
    """Of the pattern and of the kind: CHOLMOD's symbolic factor is bound to real or complex."""
    digest = hashlib.blake2b(f"{A.shape} {A.data.dtype} {A.indptr.dtype}".encode())
    digest.update(A.indptr.data)
    digest.update(A.indices.data)
    return digest.digest()


def _with_real_diagonal(A: sp.csc_array) -> sp.csc_array:
    """L D Lᴴ takes a diagonal with the round-off of a product Tᴴ K T for a breakdown."""
    columns = np.repeat(np.arange(A.shape[0]), np.diff(A.indptr))
    data = A.data.copy()
    data.imag[columns == A.indices] = 0
    return sp.csc_array((data, A.indices, A.indptr), shape=A.shape)
