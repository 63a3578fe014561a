"""What every solver behind `factorise` takes and returns; right-hand sides go in blocks.

CHOLMOD through scikit-sparse is the fastest of the solvers where it is installed.

How much memory a factorisation takes is known before from its number of rows. Nested dissection of
a surface leaves O(n log n) entries in the factor, of a solid O(n^(4/3)); parts with walls of one or
two elements lie near the former:

    bytes(n) = B n (n / 30,000)^P

fitted to both parts of the example with elements of 4.8 to 25 mm (docs/benchmarks/memory.md).
"""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.common import process
from vanelock.common.arrays import Array
from vanelock.common.errors import InputError

Sparse = sp.sparray | sp.spmatrix
Solve = Callable[[Array], Array]


class BreakdownError(Exception):
    """A pivot that is zero or negative."""


_SYMMETRIC = 1e-12  # of |x| |A y|: how far xᴴ(A y) may be from (A x)ᴴ y


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
    if abs(x @ Ay - Ax.conj() @ y) > _SYMMETRIC * np.linalg.norm(x) * np.linalg.norm(Ay):
        raise InputError("the matrix is not Hermitian: both its halves must be stored, and agree")
    return A


_COLUMNS = 128  # right-hand sides at once: beyond that a solver gains nothing more
_BYTES = 2**28  # and no more of them than fit in this


def in_blocks(
    apply: Solve, b: Any, shape: tuple[int, int], is_complex: bool, by_rows: bool = False
) -> Array:
    """A linear operator times the columns of b, a block at a time."""
    if not sp.issparse(b):
        b = np.asarray(b)
    if b.shape[0] != shape[1] or b.ndim > 2:
        raise ValueError(f"right-hand side of shape {b.shape} for a matrix of {shape[1]} rows")
    kind = np.complex128 if is_complex or np.iscomplexobj(b) else np.float64
    make = _as_it_is if by_rows else _block
    if b.ndim == 1:
        column = b.toarray() if sp.issparse(b) else b
        return make(apply, column[:, None], is_complex)[:, 0].astype(kind, copy=False)
    if sp.issparse(b):
        b = b.tocsc()
    width = max(1, min(_COLUMNS, _BYTES // (max(shape) * kind().itemsize)))
    if by_rows and b.shape[1] <= width:
        return make(apply, b.toarray() if sp.issparse(b) else b, is_complex)
    x = np.empty((shape[0], b.shape[1]), kind, order="C" if by_rows else "F")
    for start in range(0, b.shape[1], width):
        block = b[:, start : start + width]
        dense = block.toarray() if sp.issparse(block) else block
        x[:, start : start + width] = make(apply, dense, is_complex)
    return x


def _as_it_is(apply: Solve, b: Array, is_complex: bool) -> Array:
    return apply(np.asarray(b, np.complex128 if np.iscomplexobj(b) else np.float64))


def _block(apply: Solve, b: Array, is_complex: bool) -> Array:
    if is_complex:
        return apply(np.asfortranarray(b, np.complex128))
    if not np.iscomplexobj(b):
        return apply(np.asfortranarray(b, np.float64))
    k = b.shape[1]
    pair = np.empty((len(b), 2 * k), order="F")
    pair[:, :k], pair[:, k:] = b.real, b.imag
    parts = apply(pair)
    x = np.empty((len(parts), k), np.complex128, order="F")
    x.real, x.imag = parts[:, :k], parts[:, k:]
    return x


@dataclass(frozen=True)
class Factor:
    """A factorised positive definite matrix A, symmetric or Hermitian.

    Attributes
    ----------
    backend : str
        "cholmod", "pardiso" or "superlu".
    size : int
        Rows of A.
    is_complex : bool
        Whether A is.
    nonzeros : int or None
        Entries stored in the factors, where the backend counts them.
    """

    backend: str
    size: int
    is_complex: bool
    nonzeros: int | None
    _solve: Solve = field(repr=False)  # A⁻¹ b of a dense (n, k) b of A's kind in Fortran order
    _by_rows: bool = field(default=False, repr=False, kw_only=True)  # or of any kind and order

    def solve(self, b: Any) -> Array:
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

        Notes
        -----
        A single column costs five to seven times as much as one of a block of 32 and more, and
        one of a block of four twice as much: the factors have to come through memory once for
        each block.
        """
        shape = self.size, self.size
        return in_blocks(self._solve, b, shape, self.is_complex, self._by_rows)


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


def cholmod(A: sp.csc_array) -> Factor:
    """Factorise a matrix in canonical form."""
    from sksparse.cholmod import analyze

    with cholmod_errors():
        factor = analyze(A, mode="supernodal").cholesky(A)

    def solve(b: Array) -> Array:
        with cholmod_errors():
            return np.asarray(factor(b))

    return Factor("cholmod", A.shape[0], np.iscomplexobj(A.data), None, solve)


_BYTES_OF_FACTOR, _POWER = 2450.0, 0.1
"""B and P, of the real factor of a definite matrix by CHOLMOD."""
MEMORY_TIMES = {"cholmod": 1.3, "pardiso": 1.9, "superlu": 4.5}
"""Memory while factors are made, over that: docs/benchmarks/factorisation.md."""
SCHUR_TIMES = 3.7
"""The same with a Schur complement, which is read from a copy of the factor."""


def factor_bytes(rows: int, is_complex: bool = False) -> float:
    """Bytes that CHOLMOD's factor of a symmetric matrix of so many rows holds, to about 30 %."""
    return (2 if is_complex else 1) * _BYTES_OF_FACTOR * rows * float((rows / 3e4) ** _POWER)


def require_memory(rows: int, is_complex: bool, times: float) -> None:
    """Refuse a factorisation that takes more memory than is left."""
    process.require(times * factor_bytes(rows, is_complex), f"factorising {rows:,} rows")
