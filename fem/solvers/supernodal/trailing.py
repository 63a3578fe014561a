"""CHOLMOD's factors with some rows ordered last, where their Schur complement stands."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.fem.solvers.backend import Matrix
from vanelock.fem.solvers.cholmod import cholmod_errors, pattern_of
from vanelock.fem.solvers.supernodal.panels import Panels, panels_of

FULL = 1.1
"""Entries of threes of rows over those stored, up to which they are taken for nodes."""


@dataclass(frozen=True)
class TrailingAnalysis:
    """Ordering of the rest, and supernodes of the whole, for one pattern and one set of rows."""

    pattern: bytes
    kept: NDArray[np.int64]
    order: NDArray[np.int64]
    symbolic: Any


@dataclass(frozen=True)
class TrailingFactor:
    """L of A with the kept rows m last; see `schur` for what it gives.

    Right-hand sides are real or complex, of a complex factor complex throughout.

    Attributes
    ----------
    schur : (m, m) array
        S.
    order : (s,) int
        Row of A_ss that each of the first rows of L stands for.
    """

    schur: Matrix
    order: NDArray[np.int64]
    analysis: TrailingAnalysis
    _panels: Panels

    @property
    def nonzeros(self) -> int:
        """Entries of L that are stored."""
        return self._panels.entries

    def solve(self, b: Matrix) -> Matrix:
        """A_ss⁻¹ b."""
        y = self._ordered(b)
        self._panels.forward(y, inner=True)
        self._panels.backward(y, inner=True)
        return self._unordered(y)

    def down(self, z: Matrix) -> Matrix:
        """L_ss⁻¹ z, and Ψᴴ z below it."""
        y = self._ordered(z)
        self._panels.forward(y)
        return y

    def up(self, both: Matrix) -> Matrix:
        """L_ss⁻ᴴ y + Ψ v from y and v below it, which is spent."""
        both = np.ascontiguousarray(both, self._kind(both))
        self._panels.backward(both)
        return self._unordered(both)

    def _kind(self, b: Matrix) -> np.dtype[Any]:
        return np.result_type(b, self._panels.dtype)

    def _ordered(self, b: Matrix) -> Matrix:
        y, s = np.empty((self._panels.rows, b.shape[1]), self._kind(b)), len(self.order)
        if b.flags.c_contiguous and b.dtype == y.dtype:
            np.take(b, self.order, axis=0, out=y[:s], mode="clip")
        else:  # which `take` would copy first
            y[:s] = b[self.order]
        y[s:] = 0
        return y

    def _unordered(self, y: Matrix) -> Matrix:
        x = np.empty((len(self.order), y.shape[1]), y.dtype)
        x[self.order] = y[: len(self.order)]
        return x


def trailing_factor(
    A: sp.csc_array, kept: NDArray[np.int64], rest: NDArray[np.int64], like: Any = None
) -> TrailingFactor:
    """Factorise A, in canonical form, with the kept rows last.

    What is added to their diagonal, and taken off S again, lets A be singular there, as a part
    without support is; Ψ does not depend on it.
    """
    from sksparse.cholmod import analyze

    pattern = pattern_of(A) + str(A.dtype).encode()
    analysis = like if isinstance(like, TrailingAnalysis) and like.pattern == pattern else None
    if analysis is not None and not np.array_equal(analysis.kept, kept):
        analysis = None
    if analysis is not None:
        order = analysis.order
    else:
        order = _fill_reducing(A, rest)
    last = np.concatenate([rest[order], kept])
    size = abs(A.diagonal()[kept])
    added = np.where(size > 0, size, 1.0)
    whole = sp.csc_array(A[last][:, last])
    whole = sp.csc_array(whole + sp.diags_array(np.r_[np.zeros(len(rest)), added], format="csc"))
    with cholmod_errors():
        if analysis is None:
            symbolic = analyze(whole, mode="supernodal", ordering_method="natural")
            analysis = TrailingAnalysis(pattern, kept, order, symbolic)
        factor = analysis.symbolic.cholesky(whole)
        del whole
        L = sp.csc_array(factor.L())
        del factor
    corner = _corner(L, len(rest))
    S = corner @ corner.conj().T
    S += S.conj().T
    S /= 2
    S[np.diag_indices_from(S)] -= added
    return TrailingFactor(S, order, analysis, panels_of(L, len(rest)))


def _fill_reducing(A: sp.csc_array, rest: NDArray[np.int64]) -> NDArray[np.int64]:
    """An order of some rows for which few entries fill in.

    Where they come in threes, x, y and z of a node, nodes are ordered: a ninth of the entries.
    """
    nodes, xyz = rest[::3] // 3, np.arange(3)
    if A.shape[0] % 3 == 0 and np.array_equal(rest, (3 * nodes[:, None] + xyz).ravel()):
        pattern = sp.csc_array((np.ones(A.nnz), A.indices, A.indptr), shape=A.shape)
        threes = sp.kron(sp.eye_array(A.shape[0] // 3), np.ones((3, 1)), format="csc")
        links = sp.csc_array(threes.T.tocsc() @ (pattern @ threes))
        if 9 * links.nnz < FULL * A.nnz:
            return np.asarray((3 * _dissected(links, nodes)[:, None] + xyz).ravel())
    return _dissected(A, rest)


def _dissected(A: sp.csc_array, rest: NDArray[np.int64]) -> NDArray[np.int64]:
    """Order of some rows by nested dissection, which beats minimum degree here."""
    from sksparse.cholmod import analyze

    with cholmod_errors():
        own = sp.csc_array(A[rest][:, rest])
        factor = analyze(own, mode="simplicial", ordering_method="nesdis")
    return np.asarray(factor.P(), np.int64)


def _corner(L: sp.csc_array, start: int) -> Matrix:
    """L_mm, dense: the last columns of L, which have no rows above theirs."""
    m = L.shape[0] - start
    first = L.indptr[start]
    corner = sp.csc_array(
        (L.data[first:], L.indices[first:] - start, L.indptr[start:] - first), shape=(m, m)
    )
    dense: Matrix = corner.toarray()
    return dense
