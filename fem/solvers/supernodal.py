"""CHOLMOD's factors with some rows ordered last, where their Schur complement stands.

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
from vanelock.fem.solvers.backend import cholmod_errors, pattern_of

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
class _Panels:
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


def _panels_of(L: sp.csc_array, columns: int, filled: int = _FILLED) -> _Panels:
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
    return _Panels(tuple(found), L.shape[0], columns, L.nnz, L.dtype)


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


_FULL = 1.1  # entries of threes of rows over those stored, up to which they are taken for nodes


@dataclass(frozen=True)
class _TrailingAnalysis:
    """Ordering of the rest, and supernodes of the whole, for one pattern and one set of rows."""

    pattern: bytes
    kept_rows: Integers
    order: Integers
    symbolic: Any


@dataclass(frozen=True)
class _TrailingFactor:
    """L of A with the kept rows m last; see `schur` for what it gives.

    Right-hand sides are real or complex, of a complex factor complex throughout.
    """

    schur: Array  # (m, m), S
    order: Integers  # (s,), row of A_ss that each of the first rows of L stands for
    analysis: _TrailingAnalysis
    _panels: _Panels

    @property
    def nonzeros(self) -> int:
        """Entries of L that are stored."""
        return self._panels.entries

    def solve(self, b: Array) -> Array:
        """A_ss⁻¹ b."""
        y = self._ordered(b)
        self._panels.forward(y, inner=True)
        self._panels.backward(y, inner=True)
        return self._unordered(y)

    def down(self, z: Array) -> Array:
        """L_ss⁻¹ z, and Ψᴴ z below it."""
        y = self._ordered(z)
        self._panels.forward(y)
        return y

    def up(self, both: Array) -> Array:
        """L_ss⁻ᴴ y + Ψ v from y and v below it, which is spent."""
        both = np.ascontiguousarray(both, self._kind(both))
        self._panels.backward(both)
        return self._unordered(both)

    def _kind(self, b: Array) -> np.dtype[Any]:
        return np.result_type(b, self._panels.dtype)

    def _ordered(self, b: Array) -> Array:
        y, s = np.empty((self._panels.rows, b.shape[1]), self._kind(b)), len(self.order)
        if b.flags.c_contiguous and b.dtype == y.dtype:
            np.take(b, self.order, axis=0, out=y[:s], mode="clip")
        else:  # which `take` would copy first
            y[:s] = b[self.order]
        y[s:] = 0
        return y

    def _unordered(self, y: Array) -> Array:
        x = np.empty((len(self.order), y.shape[1]), y.dtype)
        x[self.order] = y[: len(self.order)]
        return x


def trailing_factor(
    A: sp.csc_array, kept_rows: Integers, rest: Integers, like: Any = None
) -> _TrailingFactor:
    """Factorise A, in canonical form, with the kept rows last.

    What is added to their diagonal, and taken off S again, lets A be singular there, as a part
    without support is; Ψ does not depend on it.
    """
    from sksparse.cholmod import analyze

    pattern = pattern_of(A) + str(A.dtype).encode()
    analysis = like if isinstance(like, _TrailingAnalysis) and like.pattern == pattern else None
    if analysis is not None and not np.array_equal(analysis.kept_rows, kept_rows):
        analysis = None
    if analysis is not None:
        order = analysis.order
    else:
        order = _fill_reducing(A, rest)
    last = np.concatenate([rest[order], kept_rows])
    size = abs(A.diagonal()[kept_rows])
    added = np.where(size > 0, size, 1.0)
    whole = sp.csc_array(A[last][:, last])
    whole = sp.csc_array(whole + sp.diags_array(np.r_[np.zeros(len(rest)), added], format="csc"))
    with cholmod_errors():
        if analysis is None:
            symbolic = analyze(whole, mode="supernodal", ordering_method="natural")
            analysis = _TrailingAnalysis(pattern, kept_rows, order, symbolic)
        factor = analysis.symbolic.cholesky(whole)
        del whole
        L = sp.csc_array(factor.L())
        del factor
    corner = _corner(L, len(rest))
    S = corner @ corner.conj().T
    S += S.conj().T
    S /= 2
    S[np.diag_indices_from(S)] -= added
    return _TrailingFactor(S, order, analysis, _panels_of(L, len(rest)))


def _fill_reducing(A: sp.csc_array, rest: Integers) -> Integers:
    """An order of some rows for which few entries fill in.

    Where they come in threes, x, y and z of a node, nodes are ordered: a ninth of the entries.
    """
    nodes, xyz = rest[::3] // 3, np.arange(3)
    if A.shape[0] % 3 == 0 and np.array_equal(rest, (3 * nodes[:, None] + xyz).ravel()):
        pattern = sp.csc_array((np.ones(A.nnz), A.indices, A.indptr), shape=A.shape)
        threes = sp.kron(sp.eye_array(A.shape[0] // 3), np.ones((3, 1)), format="csc")
        links = sp.csc_array(threes.T.tocsc() @ (pattern @ threes))
        if 9 * links.nnz < _FULL * A.nnz:
            return np.asarray((3 * _dissected(links, nodes)[:, None] + xyz).ravel())
    return _dissected(A, rest)


def _dissected(A: sp.csc_array, rest: Integers) -> Integers:
    """Order of some rows by nested dissection, which beats minimum degree here."""
    from sksparse.cholmod import analyze

    with cholmod_errors():
        own = sp.csc_array(A[rest][:, rest])
        factor = analyze(own, mode="simplicial", ordering_method="nesdis")
    return np.asarray(factor.P(), np.int64)


def _corner(L: sp.csc_array, start: int) -> Array:
    """L_mm, dense: the last columns of L, which have no rows above theirs."""
    m = L.shape[0] - start
    first = L.indptr[start]
    corner = sp.csc_array(
        (L.data[first:], L.indices[first:] - start, L.indptr[start:] - first), shape=(m, m)
    )
    dense: Array = corner.toarray()
    return dense
