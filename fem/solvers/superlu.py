"""SciPy's SuperLU: always there, several times slower than the others."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.fem.solvers.backend import BreakdownError, Numeric


def superlu(A: sp.csc_array, definite: bool, like: Any = None, threshold: float = 0.0) -> Numeric:
    """Factorise a matrix in canonical form.

    With a threshold of 0 the pivots stay on the diagonal unless they vanish, so that their signs
    are those of the eigenvalues. Above, a pivot smaller than that part of its column is changed
    for another, which bears any regular matrix and loses the inertia. `like` is not used.
    """
    from scipy.sparse.linalg import splu

    try:
        factor = splu(
            A,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=threshold,
            options={"SymmetricMode": True},
        )
    except RuntimeError:
        raise BreakdownError from None
    negative = None
    if np.array_equal(factor.perm_r, factor.perm_c):
        negative = int(np.sum(factor.U.diagonal().real <= 0))
    if definite and negative != 0:
        raise BreakdownError
    return Numeric(lambda b: np.asarray(factor.solve(b)), negative, factor.nnz)
