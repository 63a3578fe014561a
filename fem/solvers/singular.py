"""The motions that a singular matrix leaves free."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.solvers.backend import Solve

# All thresholds are on eigenvalues of the matrix scaled to a unit diagonal.
SINGULAR = 1e-16
"""Below it the matrix is singular. Round-off leaves some 1e-17 where a rigid-body motion is free;
thin flat elements come down to 1e-15."""
FREE = 1e-14
"""Below it a motion of a matrix that is singular counts as free."""
LIFT = 1e-10
"""Added to a matrix that has no factors, so that it has some."""
SOUGHT = 12
"""Motions that are looked for."""
MOVING = 1e-3
"""Of the largest motion: a row that moves more takes part."""


class SingularError(InputError):
    """A matrix that leaves motions free.

    Attributes
    ----------
    rows : (k,) int
        Rows that move in them, the one that moves most first.
    count : int
        Number of free motions; twelve stands for twelve or more.
    motions : (n, count)
        Orthonormal basis of them.
    """

    def __init__(self, motions: Array, definite: bool = True) -> None:
        self.motions = motions
        self.count = motions.shape[1]
        share = np.linalg.norm(motions, axis=1)
        order = np.argsort(-share, kind="stable")
        self.rows: Integers = order[share[order] > MOVING * share.max()]
        free = "a motion is free" if self.count == 1 else f"{self.count} motions are free"
        where = f"{free}, in {_listed(self.rows)}"
        if definite:
            super().__init__(
                f"the matrix is not positive definite: {where}; a part that is free to move as a "
                "rigid body needs a clamped set or a negative shift"
            )
        else:
            super().__init__(
                f"the matrix is singular: {where}; the shift is an eigenvalue, or a part is free "
                "to move as a rigid body"
            )


def _listed(rows: Integers) -> str:
    if len(rows) == 1:
        return f"row {rows[0]}"
    few = ", ".join(str(row) for row in rows[:4])
    return f"rows {few}" + (f" and {len(rows) - 4} others" if len(rows) > 4 else "")


def scale_of(A: sp.csc_array, definite: bool) -> Floats:
    """Square roots of the diagonal; of the rows' largest entries where A may be indefinite."""
    size = A.diagonal().real if definite else abs(A).max(axis=1).toarray().ravel()
    scale: Floats = np.sqrt(np.where(size > 0, size, 1.0))
    return scale


def is_singular(solve: Solve, scale: Floats) -> bool:
    """Whether two steps of inverse iteration find an eigenvalue below the threshold."""
    x = np.random.default_rng(0).standard_normal((len(scale), 1))
    for _ in range(2):
        x = x / np.linalg.norm(x)
        x = scale[:, None] * solve(scale[:, None] * x)
        if not np.linalg.norm(x) * SINGULAR < 1:
            return True
    return False


def lifted(A: sp.csc_array, scale: Floats) -> sp.csc_array:
    """A with a little added to its diagonal."""
    return sp.csc_array(A + sp.diags_array(LIFT * scale**2))


def free_motions(A: sp.csc_array, solve: Solve, scale: Floats) -> tuple[Array, Floats]:
    """Motions that a matrix leaves free, and eigenvalues of the scaled one, ascending.

    Block inverse iteration with the factors of A, or of the lifted A.
    """
    scaled = sp.diags_array(1 / scale) @ A @ sp.diags_array(1 / scale)
    n = len(scale)
    x: Array = np.random.default_rng(0).standard_normal((n, min(SOUGHT, n)))
    for _ in range(4):
        x = np.linalg.qr(x)[0]
        x = scale[:, None] * solve(scale[:, None] * x)
    x = np.linalg.qr(x)[0]
    values, turns = np.linalg.eigh(x.conj().T @ (scaled @ x))
    free = abs(values) < FREE
    free[abs(values).argmin()] = True
    motions = np.linalg.qr((x @ turns[:, free]) / scale[:, None])[0]
    return motions, values


def empty_rows(A: sp.csc_array, definite: bool) -> SingularError | None:
    """Error for rows that hold nothing, if there are any."""
    rows = np.flatnonzero(abs(A).max(axis=1).toarray().ravel() == 0)
    if not len(rows):
        return None
    motions: Any = np.zeros((A.shape[0], len(rows)))
    motions[rows, np.arange(len(rows))] = 1
    return SingularError(motions, definite)
