"""GMRES for real systems that are close to the identity, with what its subspace knows of them."""

from collections.abc import Callable
from dataclasses import dataclass
from math import hypot, inf, isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Reached:
    """What GMRES found.

    Attributes
    ----------
    solution : (n,) float
    residual : float
        Norm of what is left, over that of the right-hand side.
    iterations : int
        Dimension of the subspace.
    hessenberg : (k, k) float
        The operator restricted to the subspace.
    """

    solution: Floats
    residual: float
    iterations: int
    hessenberg: Floats


def gmres(
    operator: Callable[[Floats], Floats], right: Floats, tolerance: float, limit: int
) -> Reached:
    """Solve A x = b by minimal residuals, from zero, without restart (Saad and Schultz, 1986)."""
    size = sqrt(right @ right)
    if size == 0.0:
        return Reached(np.zeros_like(right), 0.0, 0, np.empty((0, 0)))
    basis = np.empty((limit + 1, len(right)))
    basis[0] = right / size
    hessenberg = np.zeros((limit + 1, limit))
    upper = np.zeros((limit, limit))  # of the QR factors of the Hessenberg matrix
    turns: list[tuple[float, float]] = []
    left = np.zeros(limit + 1)
    left[0] = size
    k = 0
    while k < limit:
        following = operator(basis[k])
        norm, before = sqrt(following @ following), inf
        while norm < 1e-2 * before:  # once more, where rounding may have left something
            before = norm
            along = basis[: k + 1] @ following
            following = following - along @ basis[: k + 1]
            hessenberg[: k + 1, k] += along
            norm = sqrt(following @ following)
        hessenberg[k + 1, k] = norm
        column = hessenberg[: k + 2, k].copy()
        for i, (c, s) in enumerate(turns):
            column[i], column[i + 1] = (
                c * column[i] + s * column[i + 1],
                c * column[i + 1] - s * column[i],
            )
        radius = hypot(column[k], column[k + 1])
        if not isfinite(radius) or radius == 0.0:
            break
        c, s = column[k] / radius, column[k + 1] / radius
        turns.append((c, s))
        upper[:k, k], upper[k, k] = column[:k], radius
        left[k], left[k + 1] = c * left[k], -s * left[k]
        k += 1
        if abs(left[k]) <= tolerance * size or norm <= 1e-14 * radius:
            break
        basis[k] = following / norm
    if k == 0:
        return Reached(np.zeros_like(right), 1.0, 0, np.empty((0, 0)))
    shares = np.linalg.solve(upper[:k, :k], left[:k])
    return Reached(shares @ basis[:k], abs(left[k]) / size, k, hessenberg[:k, :k])
