"""CHOLMOD through scikit-sparse: the fastest of the solvers where it is installed.

Positive definite matrices take the supernodal L Lᴴ. Indefinite ones take the simplicial L D Lᴴ,
which has no pivoting: the signs of D are the inertia, and the caller checks the accuracy.
"""

import hashlib
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.arrays import Array
from vanelock.fem.solvers.backend import BreakdownError, Numeric


@dataclass(frozen=True)
class SymbolicFactor:
    """Ordering and symbolic factor of one pattern.

    Attributes
    ----------
    pattern : bytes
        Of the matrix.
    kind : tuple of str
        Real or complex, supernodal or simplicial: what the symbolic factor is bound to.
    symbolic : sksparse.cholmod.Factor
        Without numbers.
    order : (n,) int or None
        Rows in the order in which the symbolic factor takes them, where it has none of its own.
    """

    pattern: bytes
    kind: tuple[str, str]
    symbolic: Any
    order: NDArray[np.int32] | None = None


@contextmanager
def cholmod_errors() -> Generator[None, None, None]:
    """CHOLMOD's errors as those that every solver has."""
    from sksparse.cholmod import CholmodNotPositiveDefiniteError, CholmodOutOfMemoryError

    try:
        yield
    except CholmodNotPositiveDefiniteError:
        raise BreakdownError from None
    except CholmodOutOfMemoryError:
        raise MemoryError("CHOLMOD could not allocate") from None


def cholmod(A: sp.csc_array, definite: bool, like: Any = None) -> Numeric:
    """Factorise a matrix in canonical form; `like` is an earlier `Numeric.analysis` or None."""
    if not definite and np.iscomplexobj(A.data):
        A = _with_real_diagonal(A)
    with cholmod_errors():
        analysis = _analysed(A, "supernodal" if definite else "simplicial", like)
        order = analysis.order
        factor = analysis.symbolic.cholesky(A if order is None else _permuted(A, order))
        negative = 0 if definite else int(np.sum(factor.D().real < 0))

    def solve(b: Array) -> Array:
        with cholmod_errors():
            if order is None:
                return np.asarray(factor(b))
            x = np.empty_like(b)
            x[order] = factor(np.asfortranarray(b[order]))
            return x

    return Numeric(solve, negative, analysis=analysis)


def _analysed(A: sp.csc_array, mode: str, like: Any) -> SymbolicFactor:
    """The earlier analysis if it fits; else one with its ordering, if that does; else a new one."""
    from sksparse.cholmod import analyze

    pattern, kind = pattern_of(A), (str(A.dtype), mode)
    if not (isinstance(like, SymbolicFactor) and like.pattern == pattern):
        # AMD, the default, leaves the simplicial factor of a solid a third more work.
        ordering = "default" if mode == "supernodal" else "nesdis"
        return SymbolicFactor(pattern, kind, analyze(A, mode=mode, ordering_method=ordering))
    if like.kind == kind:
        return like
    order = like.symbolic.P() if like.order is None else like.order
    symbolic = analyze(_permuted(A, order), mode=mode, ordering_method="natural")
    return SymbolicFactor(pattern, kind, symbolic, order)


def _permuted(A: sp.csc_array, order: Array) -> sp.csc_array:
    permuted = sp.csc_array(A[order][:, order])
    permuted.sort_indices()
    return permuted


def pattern_of(A: sp.csc_array) -> bytes:
    """Digest of where the entries are."""
    digest = hashlib.sha256(f"{A.shape} {A.indptr.dtype}".encode())
    digest.update(A.indptr.data)
    digest.update(A.indices.data)
    return digest.digest()


def _with_real_diagonal(A: sp.csc_array) -> sp.csc_array:
    """L D Lᴴ takes a diagonal with the round-off of a product Tᴴ K T for a breakdown."""
    columns = np.repeat(np.arange(A.shape[0]), np.diff(A.indptr))
    data = A.data.copy()
    data.imag[columns == A.indices] = 0
    return sp.csc_array((data, A.indices, A.indptr), shape=A.shape)
