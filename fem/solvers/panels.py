"""Sweeps with a sparse Cholesky factor, panel by panel.

The columns of a sparse Cholesky factor L come in panels of one structure. A panel p of neighbouring
columns with entries in the same rows, or nearly so, is dense: a lower triangle L_pp, and L_bp in
the rows b below. With the right-hand sides in rows, so that all of a row lie side by side,

    L Y = B:     Y_p = L_pp⁻¹ B_p,                    B_b -= L_bp Y_p,     from the first panel on,
    Lᴴ X = Y:    X_p = L_pp⁻ᴴ (Y_p - L_bpᴴ X_b),                           from the last one on.

CHOLMOD does the same with the sides in columns, each row of which it has to gather from far apart;
for blocks of 64 sides and more that takes three to four times as long, for 16 and fewer as long.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.linalg import get_blas_funcs

from vanelock.common.arrays import Array, Integers

_FILLED = 1500
"""Zeros that cost no more than one panel more: half as many panels take 1.1 times the entries."""


class _Supernode(NamedTuple):
    """Columns of one structure."""

    columns: slice  # which
    below: Integers  # (b,), rows under the triangle that have entries, ascending
    inner: int  # how many of them belong to the rows that are not kept
    triangle: Array  # (w, w), L_pp, in Fortran order
    rectangle: Array  # (b, w), L_bp


@dataclass(frozen=True)
class Panels:
    """The first columns of a lower triangular factor."""

    panels: tuple[_Supernode, ...]  # from the first column on
    rows: int  # rows of L, and how many of its columns the panels hold
    columns: int  # rows of L, and how many of its columns the panels hold
    entries: int  # stored entries of L
    dtype: Any  # of L

    def forward(self, X: Array, inner: bool = False) -> None:
        """L⁻¹ X in place, X (rows, k) in C order; what is left of the rows behind the columns.

        With `inner` those rows are left alone.
        """
        X = self._alike(X)
        solve = get_blas_funcs("trsm", dtype=self.dtype)
        for columns, below, some, triangle, rectangle in self.panels:
            x = X[columns]
            solve(1.0, triangle, x.T, side=1, lower=1, trans_a=1, overwrite_b=1)
            if inner:
                below, rectangle = below[:some], rectangle[:some]
            if len(below):
                X[below] -= rectangle @ x

    def backward(self, X: Array, inner: bool = False) -> None:
        """L⁻ᴴ X in place, the rows behind the columns being known; with `inner` they are zero."""
        X = self._alike(X)
        solve, is_complex = get_blas_funcs("trsm", dtype=self.dtype), np.iscomplexobj(X)
        for columns, below, some, triangle, rectangle in reversed(self.panels):
            x = X[columns]
            if inner:
                below, rectangle = below[:some], rectangle[:some]
            if len(below):
                x -= rectangle.conj().T @ X[below]
            if is_complex:  # no BLAS conjugates without transposing
                np.conj(x, out=x)
            solve(1.0, triangle, x.T, side=1, lower=1, trans_a=0, overwrite_b=1)
            if is_complex:
                np.conj(x, out=x)

    def _alike(self, X: Array) -> Array:
        """X in the factor's kind of numbers: for a real one, real and imaginary parts in turn."""
        if np.iscomplexobj(X) and self.dtype == np.float64:
            return X.view(np.float64)
        return X


def panels_of(L: sp.csc_array, columns: int, filled: int = _FILLED) -> Panels:
    """The panels of the first columns of a factor in sorted compressed columns."""
    counts, first = np.diff(L.indptr), L.indptr[:-1]
    # A column's structure without the diagonal lies within that of the next if its first row is it.
    follows = L.indices[np.minimum(first + 1, L.nnz - 1)][:-1] == np.arange(1, L.shape[0])
    alike = follows & (counts[1:] == counts[:-1] - 1)
    starts = 1 + np.flatnonzero(~alike[: columns - 1])
    found: list[_Supernode] = []
    group: list[tuple[int, int]] = []
    below, area = np.empty(0, np.int64), 0
    for start, stop in zip([0, *starts.tolist()], [*starts.tolist(), columns], strict=True):
        own = L.indices[L.indptr[stop - 1] + 1 : L.indptr[stop]].astype(np.int64)
        alone = _area(stop - start, len(own))
        if group:
            union = np.union1d(below[np.searchsorted(below, stop) :], own)
            together = _area(stop - group[0][0], len(union))
            if together - area - alone <= filled:
                group.append((start, stop))
                below, area = union, together
                continue
            found.append(_panel(L, group, below, columns))
        group, below, area = [(start, stop)], own, alone
    found.append(_panel(L, group, below, columns))
    return Panels(tuple(found), L.shape[0], columns, L.nnz, L.dtype)


def _area(width: int, below: int) -> int:
    return width * (width + 1) // 2 + width * below


def _panel(
    L: sp.csc_array, group: list[tuple[int, int]], below: Integers, columns: int
) -> _Supernode:
    """One panel of neighbouring ones, each given by its first and last column."""
    first, last = group[0][0], group[-1][1]
    width = last - first
    rows = np.concatenate([np.arange(first, last), below])
    dense = np.zeros((width, len(rows)), L.dtype)
    for start, stop in group:
        own, entries = stop - start, L.data[L.indptr[start] : L.indptr[stop]]
        at = np.searchsorted(rows, L.indices[L.indptr[start] : L.indptr[start + 1]])
        i, j = np.triu_indices(own, 0, len(at))
        dense[start - first + i, at[j]] = entries
    return _Supernode(
        columns=slice(first, last),
        below=below,
        inner=int(np.searchsorted(below, columns)),
        triangle=np.asfortranarray(dense[:, :width].T),
        rectangle=np.ascontiguousarray(dense[:, width:].T),
    )
