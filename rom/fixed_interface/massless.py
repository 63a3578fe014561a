"""Lowest modes of K x = ω² M x where some coordinates may have no mass.

Massless coordinates follow the others without inertia. With M = Y m Yᴴ, m > 0, and the columns of
Z without mass,

    x = X y,    X = Y - Z (Zᴴ K Z)⁻¹ Zᴴ K Y,    Xᴴ K X y = ω² m y.

Y, m and Z are of D M D with D = diag(M)^-1/2, times D, so that kg stand beside kg m².
"""

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Array, Floats
from vanelock.common.errors import InputError

NONE = 1e-11
"""A scaled mass below this is none."""
NEGATIVE = 1e-7
"""Negative scaled mass that is no longer round-off of what wrote the matrix."""


def lowest(K: Array, M: Array, count: int) -> tuple[Floats, Array]:
    """Lowest modes of Hermitian matrices; fewer than `count` if fewer coordinates have a mass."""
    if _definite(M):
        omega2, shapes = sl.eigh(K, M, subset_by_index=[0, count - 1])
        return omega2, shapes
    refuse_negative_mass(M)
    d = _scale(M)
    mass, U = sl.eigh(d[:, None] * M * d)
    heavy = mass > NONE
    Y, Z = d[:, None] * U[:, heavy], d[:, None] * U[:, ~heavy]
    try:
        follow = sl.cho_solve(sl.cho_factor(Z.conj().T @ K @ Z), Z.conj().T @ K @ Y)
    except sl.LinAlgError:
        raise InputError("a coordinate without mass is held by nothing") from None
    X = (Y - Z @ follow) / np.sqrt(mass[heavy])
    reduced = X.conj().T @ K @ X
    last = min(count, reduced.shape[0]) - 1
    omega2, shapes = sl.eigh((reduced + reduced.conj().T) / 2, subset_by_index=[0, last])
    return omega2, X @ shapes


def refuse_negative_mass(M: Array) -> None:
    """Raise InputError if some motion has a negative mass, which no structure has."""
    d = _scale(M)
    scaled = d[:, None] * M * d
    try:
        sl.cholesky(scaled + NEGATIVE * np.eye(len(M)), check_finite=False)
    except sl.LinAlgError:
        values = np.linalg.eigvalsh(scaled)
        raise InputError(
            f"the mass matrix is not positive: scaled to a diagonal of ones its smallest "
            f"eigenvalue is {values[0]:.2g}, where 0 or more is needed"
        ) from None


def _scale(M: Array) -> Floats:
    own = M.diagonal().real
    largest = max(float(own.max(initial=0.0)), np.finfo(float).tiny)
    return np.asarray(1 / np.sqrt(np.where(own > 0, own, largest)))


def _definite(M: Array) -> bool:
    """Whether every scaled pivot is a mass."""
    own = M.diagonal().real
    if not np.all(own > 0):
        return False
    d = _scale(M)
    try:
        L = sl.cholesky(d[:, None] * M * d, lower=True, check_finite=False)
    except sl.LinAlgError:
        return False
    return bool(np.all(L.diagonal().real ** 2 > NONE))
