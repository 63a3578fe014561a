"""What every solver behind `factorise` takes and returns; right-hand sides go in blocks."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array
from vanelock.common.errors import InputError

Sparse = sp.sparray | sp.spmatrix
Solve = Callable[[Array], Array]


@dataclass(frozen=True)
class Numeric:
    """A numerical factorisation.

    Attributes
    ----------
    solve : callable
        A⁻¹ b for a dense (n, k) array b of A's kind in Fortran order.
    negative : int or None
        Number of negative eigenvalues of A (Sylvester's law of inertia), where the pivots give it.
    nonzeros : int or None
        Entries stored in the factors, where the solver counts them.
    analysis : object
        What a later factorisation with the same pattern may begin from; None if nothing.
    """

    solve: Solve
    negative: int | None = None
    nonzeros: int | None = None
    analysis: Any = None


class BreakdownError(Exception):
    """A pivot that is zero, or negative where none may be."""


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


COLUMNS = 128  # right-hand sides at once: beyond that a solver gains nothing more
BYTES = 2**28  # and no more of them than fit in this


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
    width = max(1, min(COLUMNS, BYTES // (max(shape) * kind().itemsize)))
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
