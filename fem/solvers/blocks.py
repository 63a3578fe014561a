"""Right-hand sides in blocks: real and complex, dense and sparse."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.fem.solvers.backend import Matrix, Solve

COLUMNS = 128  # right-hand sides at once: beyond that a solver gains nothing more
BYTES = 2**28  # and no more of them than fit in this


def in_blocks(
    apply: Solve, b: Any, shape: tuple[int, int], is_complex: bool, by_rows: bool = False
) -> Matrix:
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


def _as_it_is(apply: Solve, b: Matrix, is_complex: bool) -> Matrix:
    return apply(np.asarray(b, np.complex128 if np.iscomplexobj(b) else np.float64))


def _block(apply: Solve, b: Matrix, is_complex: bool) -> Matrix:
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
