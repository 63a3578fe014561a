"""Dense Schur complement of a sparse matrix, from one factorisation.

With the kept rows m ordered behind the rest s,

    [A_ss A_sm]   [L_ss      ] [L_ssᴴ L_msᴴ]
    [A_ms A_mm] = [L_ms  L_mm] [      L_mmᴴ],    S = A_mm - A_ms A_ss⁻¹ A_sm = L_mm L_mmᴴ,

and the same factors solve with A_ss and apply Ψ = -A_ss⁻¹ A_sm in one sweep instead of two.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array, Integers
from vanelock.common.errors import InputError
from vanelock.fem.solvers.backend import (
    SCHUR_TIMES,
    BreakdownError,
    Factor,
    Solve,
    Sparse,
    cholmod_errors,
    hermitian,
    in_blocks,
    require_memory,
)
from vanelock.fem.solvers.factor import backends, factorise
from vanelock.fem.solvers.panels import Panels, panels_of
from vanelock.fem.solvers.singular import is_singular, scale_of


@dataclass(frozen=True)
class Interior(Factor):
    """Factors of the block A_ss that a Schur complement leaves, and what ties it to the rows kept.

    Attributes
    ----------
    kept_rows, rest : (m,) int and (s,) int
        The rows of A that were kept, as given, and all others, ascending.
    half_is_root : bool
        Whether `energy` needs only what `down` leaves.
    """

    kept_rows: Integers = field(kw_only=True)
    rest: Integers = field(kw_only=True)
    _down: Solve = field(kw_only=True, repr=False)
    _up: Solve = field(kw_only=True, repr=False)
    half_is_root: bool = field(kw_only=True, repr=False)

    @property
    def _size(self) -> int:
        return len(self.rest) + len(self.kept_rows)

    def extend(self, v: Any) -> Array:
        """Ψ v = -A_ss⁻¹ A_sm v, (s,) or (s, k): how the rest follows the kept rows statically."""
        v = np.asarray(v)
        return self.up(np.zeros((len(self.rest), *v.shape[1:]), v.dtype), v)

    def restrict(self, z: Any) -> Array:
        """Ψᴴ z, (m,) or (m, k): what acts on the rest, carried to the kept rows."""
        return self.down(z)[1]

    def down(self, z: Any) -> tuple[Array, Array]:
        """First sweep of a solution: what `up` goes on from, (s,) or (s, k), and Ψᴴ z."""
        shape = self._size, len(self.rest)
        both = in_blocks(self._down, z, shape, self.is_complex, self._by_rows)
        return both[: len(self.rest)], both[len(self.rest) :]

    def up(self, half: Array, v: Array) -> Array:
        """Second sweep: A_ss⁻¹ z + Ψ v from what `down` left of z, and from v."""
        both = np.concatenate([half, v])
        shape = len(self.rest), self._size
        return in_blocks(self._up, both, shape, self.is_complex, self._by_rows)

    def energy(self, z: Array, half: Array, other: Array | None = None) -> Array:
        """zᴴ A_ss⁻¹ y, (k, l), from z, (s, k), what `down` left of it, and of another y than z."""
        root = half if self.half_is_root else z
        return np.asarray(root.conj().T @ (half if other is None else other))


def schur_complement(
    A: Sparse | Array, rows: Sequence[int] | Integers, backend: str | None = None
) -> tuple[Array, Interior]:
    """Dense Schur complement of some rows of a sparse matrix, and the factors of the rest.

    Parameters
    ----------
    A : (n, n) sparse
        Real symmetric or complex Hermitian. Its block A_ss must be positive definite; A itself
        may be singular or indefinite.
    rows : (m,) int
        Rows to keep, without repetition, at most n - 1.
    backend : str, optional
        One of `backends()`; CHOLMOD if installed. The others take a solve for each row kept.

    Returns
    -------
    S : (m, m) array
        A_mm - A_ms A_ss⁻¹ A_sm, in the order of `rows`, Hermitian to the last bit.
    interior : Interior
        Factors of A_ss.

    Raises
    ------
    SingularError, InputError
        As `factorise` does for A_ss; `rows` of the error count within A_ss.
    """
    A = hermitian(A)
    n = A.shape[0]
    kept = np.asarray(rows, np.int64).ravel()
    if len(np.unique(kept)) != len(kept) or (len(kept) and not 0 <= kept.min() <= kept.max() < n):
        raise InputError(f"rows to keep: they must be different, and 0 to {n - 1}")
    if len(kept) == n:
        raise InputError(f"rows to keep: all {n}; at least one must be left")
    rest = np.setdiff1d(np.arange(n), kept)
    if (backend or backends()[0]) != "cholmod":
        return _by_solves(A, kept, rest, backend)
    require_memory(n, np.iscomplexobj(A.data), SCHUR_TIMES)
    try:
        factor = _trailing_factor(A, kept, rest)
    except BreakdownError:
        return _by_solves(A, kept, rest, backend)  # which says why, or bears it
    interior = Interior(
        "cholmod",
        len(rest),
        np.iscomplexobj(A.data),
        factor.nonzeros,
        factor.solve,
        _by_rows=True,
        kept_rows=kept,
        rest=rest,
        _down=factor.down,
        _up=factor.up,
        half_is_root=True,
    )
    if is_singular(interior.solve, scale_of(A)[rest]):
        factorise(A[rest][:, rest], backend)  # says why
    return factor.schur, interior


def _by_solves(
    A: sp.csc_array, kept_rows: Integers, rest: Integers, backend: str | None
) -> tuple[Array, Interior]:
    """The same by one solve for each row that is kept."""
    A_sm = A[rest][:, kept_rows].tocsc()
    A_ms = A_sm.conj().T.tocsr()
    factor = factorise(A[rest][:, rest], backend)
    S = A[kept_rows][:, kept_rows].toarray() - A_ms @ factor.solve(A_sm)
    size = len(rest)

    def down(z: Array) -> Array:
        solved = factor.solve(z)
        return np.concatenate([solved, -(A_ms @ solved)])

    interior = Interior(
        **vars(factor),
        kept_rows=kept_rows,
        rest=rest,
        _down=down,
        _up=lambda both: both[:size] - factor.solve(A_sm @ both[size:]),
        half_is_root=False,
    )
    return (S + S.conj().T) / 2, interior


_FULL = 1.1  # entries of threes of rows over those stored, up to which they are taken for nodes


@dataclass(frozen=True)
class _TrailingFactor:
    """L of A with the kept rows m last; see `schur` for what it gives.

    Right-hand sides are real or complex, of a complex factor complex throughout.
    """

    schur: Array  # (m, m), S
    order: Integers  # (s,), row of A_ss that each of the first rows of L stands for
    _panels: Panels

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


def _trailing_factor(A: sp.csc_array, kept_rows: Integers, rest: Integers) -> _TrailingFactor:
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
        del factor, whole
    # Its last columns have no rows above theirs.
    corner = L[:, len(rest) :][len(rest) :].toarray()
    S = corner @ corner.conj().T
    S += S.conj().T
    S /= 2
    S[np.diag_indices_from(S)] -= added
    return _TrailingFactor(S, order, panels_of(L, len(rest)))


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
