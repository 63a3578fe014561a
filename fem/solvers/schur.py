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
    hermitian,
    in_blocks,
    require_memory,
)
from vanelock.fem.solvers.factor import backends, factorise
from vanelock.fem.solvers.singular import is_singular, scale_of
from vanelock.fem.solvers.supernodal import trailing_factor


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
        both = in_blocks(self._down, z, (self._size, len(self.rest)), self.is_complex)
        return both[: len(self.rest)], both[len(self.rest) :]

    def up(self, half: Array, v: Array) -> Array:
        """Second sweep: A_ss⁻¹ z + Ψ v from what `down` left of z, and from v."""
        both = np.concatenate([half, v])
        return in_blocks(self._up, both, (len(self.rest), self._size), self.is_complex)

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
        factor = trailing_factor(A, kept, rest)
    except BreakdownError:
        return _by_solves(A, kept, rest, backend)  # which says why, or bears it
    interior = Interior(
        "cholmod",
        len(rest),
        np.iscomplexobj(A.data),
        factor.nonzeros,
        factor.solve,
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
