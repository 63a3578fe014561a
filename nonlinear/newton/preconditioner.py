"""What linearised balances are made of, and how they are solved by iteration.

Linearised balances are solved by GMRES in the norm that weights make, on the entries of the
contacts that deviate, and of a border's parameter behind them; the others are their own solution.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import hypot, inf, isfinite, sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.contact.law import Deviation


def response_to(deviation: Deviation, rows: Integers, moved: Floats) -> Floats:
    """(dW/du) times a displacement (c, 3, 2H + 1), on the given components of w."""
    m = deviation.w.shape[2]
    functionals = deviation.jacobian.reshape(-1, 3 * m)[rows]
    return np.asarray(np.einsum("rk,rk->r", functionals, moved.reshape(-1, 3 * m)[rows // (3 * m)]))


@dataclass(frozen=True)
class Border:
    """k unknowns beside w, and as many equations.

    `rate` (k, n): dW/dp; `normal` (k, n): dg/dw, of a plane its normal; `corner` (k, k): dg/dp.
    """

    rate: Floats
    normal: Floats
    corner: Floats

    @property
    def count(self) -> int:
        """Number of unknowns k."""
        return len(self.corner)


@dataclass(frozen=True, kw_only=True)
class Kept:
    """What preconditions large balances, kept over steps and frequencies until it is `stale`."""

    stale: bool = False


class Equations(NamedTuple):
    """A balance and its law at a state, to be linearised on the components `rows` of w.

    `weight` (n,): of each component in the norm, a border's, too; `reuse`: what an earlier one
    left; `stiffness` (3c,): K_c.
    """

    balance: Balance
    deviation: Deviation
    rows: Integers
    weight: Floats
    border: Border | None
    reuse: Kept | None
    stiffness: Floats


def _gmres(
    operator: Callable[[Floats], Floats], right: Floats, tolerance: float, limit: int
) -> tuple[Floats, float, int, Floats]:
    """Solve A x = b by minimal residuals, from zero, without restart (Saad and Schultz, 1986).

    Returns x, what is left over the size of b, the dimension k of the subspace, and A (k, k) in it.
    """
    size = sqrt(right @ right)
    if size == 0.0:
        return np.zeros_like(right), 0.0, 0, np.empty((0, 0))
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
        return np.zeros_like(right), 1.0, 0, np.empty((0, 0))
    shares = np.linalg.solve(upper[:k, :k], left[:k])
    return shares @ basis[:k], abs(left[k]) / size, k, hessenberg[:k, :k]


class Preconditioned(ABC):
    """P and what it is preconditioned by, on the `entries` of the contacts that deviate.

    `weight` (n,): of each component in the norm; `places` (k,): components that P is of, a border's
    behind the entries; `reuse`: what preconditions; None where P is singular; `hessenberg` (j, j):
    P M⁻¹ in the subspace of the last solution.
    """

    LIMIT: ClassVar[int]
    """Dimension of GMRES' subspace, at most."""
    STALE: ClassVar[int]
    """Iterations for each digit after which what is kept is made anew."""
    reuse: Kept | None
    hessenberg: Floats

    def __init__(self, equations: Equations, entries: Integers) -> None:
        _, deviation, _, self.weight, self.border, *_ = equations
        self.m, self.entries, self.places = deviation.w.shape[2], entries, entries
        if (border := self.border) is not None:
            self.places = np.append(entries, deviation.w.size + np.arange(border.count))
            self.rate, self.normal = border.rate[:, entries], border.normal[:, entries]

    @abstractmethod
    def _alone(self, x: Floats) -> Floats:
        """P x, without a border."""

    @abstractmethod
    def _precondition(self, y: Floats) -> Floats:
        """M⁻¹ y, (k,), M close to P."""

    @abstractmethod
    def orientation(self) -> float:
        """Sign of the determinant, border and all, after a solution."""

    def _operator(self, y: Floats) -> Floats:
        """P y, (k,)."""
        x, p = np.split(y, [len(self.entries)])
        top = self._alone(x)
        if self.border is None:
            return top
        return np.append(top - p @ self.rate, self.normal @ x + self.border.corner @ p)

    def solve(self, gap: Floats, tolerance: float) -> Floats | None:
        """(dw, dp); None where the iteration does not get there."""
        inner: Floats = gap[self.places]
        weight: Floats = self.weight[self.places]

        def scaled(z: Floats) -> Floats:
            return self._operator(self._precondition(z / weight)) * weight

        with np.errstate(all="ignore"):
            found = _gmres(scaled, inner * weight, tolerance, self.LIMIT)
        solution, residual, iterations, self.hessenberg = found
        if not residual < max(tolerance, 0.1):
            return None
        if iterations > self.STALE * max(1.0, -np.log10(tolerance)):
            assert self.reuse is not None
            self.reuse = replace(self.reuse, stale=True)
        step = np.zeros_like(gap)
        step[self.places] = self._precondition(solution / weight)
        return step

    def merit(self, gap: Floats) -> float:
        """Preconditioned size of a gap."""
        outside = gap * self.weight
        outside[self.places] = 0.0  # components outside P count as they are
        inside = self._precondition(gap[self.places]) * self.weight[self.places]
        return float(np.hypot(np.linalg.norm(inside), np.linalg.norm(outside)))

    def _turned(self) -> float:
        """Sign of det P M⁻¹, after a solution.

        P M⁻¹ is close to the identity: what eigenvalues have crossed zero lie apart from the
        others, and GMRES has found those to solve with them.
        """
        values = np.linalg.eigvals(self.hessenberg)
        real = np.abs(values.imag) <= 1e-8 * np.abs(values)
        return (-1.0) ** int(np.count_nonzero(real & (values.real < 0)))
