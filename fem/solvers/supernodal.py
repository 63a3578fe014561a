"""CHOLMOD's factor with some rows ordered last, where their Schur complement stands."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array, Integers
from vanelock.fem.solvers.backend import cholmod_errors

_FULL = 1.1  # entries of threes of rows over those stored, up to which they are taken for nodes


@dataclass(frozen=True)
class _TrailingFactor:
    """L of A with the kept rows m last; see `schur` for what it gives."""

    schur: Array  # (m, m), S
    order: Integers  # (s,), row of A_ss that each of the first rows of L stands for
    nonzeros: int  # entries of L
    _corner: Array  # (m, m), L_mm
    _factor: Any  # CHOLMOD's

    def solve(self, b: Array) -> Array:
        """A_ss⁻¹ b."""
        y = self._forward(b)
        y[len(self.order) :] = 0
        return self._backward(y)

    def down(self, z: Array) -> Array:
        """L_ss⁻¹ z, and Ψᴴ z below it."""
        y, s = self._forward(z), len(self.order)
        y[s:] = self._corner @ y[s:]
        return y

    def up(self, both: Array) -> Array:
        """L_ss⁻ᴴ y + Ψ v from y and v below it."""
        y, s = np.array(both, order="F"), len(self.order)
        y[s:] = self._corner.conj().T @ y[s:]
        return self._backward(y)

    def _forward(self, b: Array) -> Array:
        y = np.zeros((len(self.order) + len(self._corner), b.shape[1]), b.dtype, order="F")
        y[: len(self.order)] = b[self.order]
        with cholmod_errors():
            return np.asarray(self._factor.solve_L(y, use_LDLt_decomposition=False))

    def _backward(self, y: Array) -> Array:
        with cholmod_errors():
            solved = self._factor.solve_Lt(y, use_LDLt_decomposition=False)
        x = np.empty((len(self.order), y.shape[1]), y.dtype, order="F")
        x[self.order] = solved[: len(self.order)]
        return x


def trailing_factor(A: sp.csc_array, kept_rows: Integers, rest: Integers) -> _TrailingFactor:
    """Factorise A, in canonical form, with the kept rows last.

    What is added to their diagonal, and taken off S again, lets A be singular there, as a part
    without support is; Ψ does not depend on it.
    """
    from sksparse.cholmod import analyze

    order = _fill_reducing(A, rest)
    last = np.concatenate([rest[order], kept_rows])
    size = abs(A.diagonal()[kept_rows])
    added = np.where(size > 0, size, 1.0)
    whole = sp.csc_array(A[last][:, last])
    whole = sp.csc_array(whole + sp.diags_array(np.r_[np.zeros(len(rest)), added], format="csc"))
    with cholmod_errors():
        factor = analyze(whole, mode="supernodal", ordering_method="natural").cholesky(whole)
        L = sp.csc_array(factor.L())
    # Its last columns have no rows above theirs.
    corner, nonzeros = L[:, len(rest) :][len(rest) :].toarray(), L.nnz
    S = corner @ corner.conj().T
    S += S.conj().T
    S /= 2
    S[np.diag_indices_from(S)] -= added
    return _TrailingFactor(S, order, nonzeros, corner, factor)


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
