"""Receptances seen through their few strong directions, which precondition large balances.

A contact moves far under a unit of deviation only along directions in which the structure is soft
beside its contacts, and those are few: of S_h = K_c^½ R̂_h K_c^-½, some dozen singular values of
hundreds exceed 0.3. With Q_h their left vectors, R̂_h ≈ L_h M_h, L = K_c^-½ Q, M = Qᴴ K_c^½ R̂, and

    P = I - J R̂  ≈  I - J L M,      (I - J L M)⁻¹ = I + J L (I - M J L)⁻¹ M

(Woodbury) needs no factors but those of the small matrix I - M J L.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Array, Balance
from vanelock.nonlinear.newton.law_jacobian import Slope

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

WEAK = 0.35  # singular values below this are left to the iteration
SKETCH = 64


@dataclass(frozen=True, kw_only=True)
class Kept:
    """What preconditions large balances, kept over steps and frequencies while it serves.

    Attributes
    ----------
    stale : bool
        Whether it serves no longer.
    """

    stale: bool = False


@dataclass(frozen=True)
class Basis:
    """Strong directions of the receptances.

    Attributes
    ----------
    left : tuple of (3c, r_h)
        L_h = K_c^-½ Q_h, h = 0 ... H.
    right : tuple of (r_h, 3c)
        M_h, at the frequency where the basis was found.
    """

    left: tuple[Array, ...]
    right: tuple[Array, ...]

    def of(self, components: Rows) -> "Basis":
        """The basis seen by some components alone."""
        left = tuple(each[components] for each in self.left)
        return Basis(left, tuple(each[:, components] for each in self.right))


def strong_directions(balance: Balance, stiffness: Floats) -> Basis:
    """Strong directions of a balance, by sketches of its receptances (Halko and others, 2011)."""
    root = np.sqrt(stiffness)
    rng = np.random.default_rng(0)
    left, right = [], []
    for h in range((balance.linear.shape[2] + 1) // 2):
        S = root[:, None] * balance.columns.all(h) / root
        if h == 0:
            S = S.real
        sketch = S @ rng.normal(size=(len(S), min(SKETCH, len(S))))
        for _ in range(2):
            sketch = S @ la.qr(S.conj().T @ sketch, mode="economic")[0]
        Q = la.qr(sketch, mode="economic")[0]
        U, values, V = la.svd(Q.conj().T @ S, full_matrices=False)
        strong = values > min(WEAK, 0.99 * values[0])  # one at least, if any moves
        left.append((Q @ U[:, strong]) / root[:, None])
        right.append((values[strong, None] * V[strong]) * root)
    return Basis(tuple(left), tuple(right))


def small_matrix(basis: Basis, slope: Slope) -> Floats:
    """I - M J L, of a basis restricted to the components of the slope's contacts."""
    columns = slope.columns(basis.left)
    columns = columns.reshape(3 * len(columns), slope.m, columns.shape[2])
    rows: list[Floats] = []
    for h, right in enumerate(basis.right):
        if h == 0:
            rows.append(right.real @ columns[:, 0])
            continue
        k = 2 * h - 1
        total = right @ (columns[:, k] + 1j * columns[:, k + 1])
        rows += [total.real, total.imag]
    matrix = -np.concatenate(rows)
    matrix[np.diag_indices_from(matrix)] += 1.0
    return matrix


def seen(basis: Basis, flat: Floats) -> Floats:
    """M w of w (k, m), (r,)."""
    parts: list[Floats] = []
    for h, right in enumerate(basis.right):
        if h == 0:
            parts.append(right.real @ flat[:, 0])
            continue
        total = right @ (flat[:, 2 * h - 1] + 1j * flat[:, 2 * h])
        parts += [total.real, total.imag]
    return np.concatenate(parts)


def spread_out(basis: Basis, a: Floats, m: int) -> Floats:
    """L a, (k, m)."""
    out = np.empty((len(basis.left[0]), m))
    start = 0
    for h, left in enumerate(basis.left):
        r = left.shape[1]
        if h == 0:
            out[:, 0] = left.real @ a[:r]
            start = r
            continue
        total = left @ (a[start : start + r] + 1j * a[start + r : start + 2 * r])
        out[:, 2 * h - 1], out[:, 2 * h] = total.real, total.imag
        start += 2 * r
    return out


def gathered(basis: Basis, form: Floats) -> Floats:
    """Lᵀ form, (r,), of a linear form of displacements (k, m)."""
    parts: list[Floats] = []
    for h, left in enumerate(basis.left):
        if h == 0:
            parts.append(form[:, 0] @ left.real)
            continue
        total = (form[:, 2 * h - 1] - 1j * form[:, 2 * h]) @ left
        parts += [total.real, -total.imag]
    return np.concatenate(parts)
