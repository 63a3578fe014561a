"""The linearised law dW/du of contacts that deviate from sticking, and what preconditions it.

A contact moves far under a unit of deviation only along directions in which the structure is soft
beside its contacts, and those are few: of S_h = K_c^½ R̂_h K_c^-½, some dozen singular values of
hundreds exceed 0.3. With Q_h their left vectors, R̂_h ≈ L_h M_h, L = K_c^-½ Q, M = Qᴴ K_c^½ R̂, and

    P = I - J R̂  ≈  I - J L M,      (I - J L M)⁻¹ = I + J L (I - M J L)⁻¹ M

(Woodbury) needs no factors but those of the small matrix I - M J L.

Linearised balances are solved by GMRES in the norm that weights make, on the entries of the
contacts that deviate, and of a border's parameter behind them; the others are their own solution.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import hypot, inf, isfinite, sqrt
from typing import ClassVar, NamedTuple

import numpy as np
import scipy.linalg as la

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.contact.law import Deviation


@dataclass(frozen=True)
class _Slope:
    """J = dW/du by contact: `contacts` (a,) and their `blocks` (a, 3m, 3, m), m = 2H + 1."""

    contacts: Integers
    blocks: Floats

    @property
    def m(self) -> int:
        """Number of coefficients 2H + 1."""
        return int(self.blocks.shape[3])

    @property
    def components(self) -> Integers:
        """(3a,) components of these contacts."""
        return np.asarray(3 * self.contacts[:, None] + np.arange(3)).reshape(-1)

    def __call__(self, u: Floats) -> Floats:
        """J u, (3a, m), of displacements (3a, m)."""
        a, width, _, m = self.blocks.shape
        product = self.blocks.reshape(a, width, 3 * m) @ u.reshape(a, 3 * m, 1)
        return product.reshape(3 * a, m)

    def columns(self, shapes: Sequence[Array]) -> Floats:
        """J times shapes of each harmonic (3a, r_h), complex but for h = 0: (a, 3m, Σ).

        The columns of a harmonic h >= 1 are those of its shapes, then of i times its shapes.
        """
        a = len(self.contacts)
        moved = [self.blocks[:, :, :, 0] @ shapes[0].real.reshape(a, 3, shapes[0].shape[1])]
        for h, shape in enumerate(shapes[1:], 1):
            wide = shape.reshape(a, 3, shape.shape[1])
            real, imaginary = wide.real, wide.imag
            parts = np.concatenate(
                [np.concatenate([real, -imaginary], 2), np.concatenate([imaginary, real], 2)], 1
            )
            both = self.blocks[:, :, :, 2 * h - 1 : 2 * h + 1].transpose(0, 1, 3, 2)
            moved.append(both.reshape(a, 3 * self.m, 6) @ parts)
        return np.concatenate(moved, axis=2)

    def transposed(self, form: Floats) -> Floats:
        """Jᵀ times a linear form (3a, m) of w, as one of u, (3a, m)."""
        a, width, _, m = self.blocks.shape
        product = form.reshape(a, 1, width) @ self.blocks.reshape(a, width, 3 * m)
        return product.reshape(3 * a, m)


def slope_of(deviation: Deviation, contacts: Integers) -> _Slope:
    """The linearised law of some contacts."""
    m, jacobian = deviation.w.shape[2], deviation.jacobian
    blocks = jacobian if len(contacts) == len(deviation.w) else jacobian[contacts]
    return _Slope(contacts, blocks.reshape(len(contacts), 3 * m, 3, m))


def response_to(deviation: Deviation, rows: Integers, moved: Floats) -> Floats:
    """(dW/du) times a displacement (c, 3, 2H + 1), on the given components of w."""
    m = deviation.w.shape[2]
    functionals = deviation.jacobian.reshape(-1, 3 * m)[rows]
    return np.asarray(np.einsum("rk,rk->r", functionals, moved.reshape(-1, 3 * m)[rows // (3 * m)]))


_WEAK = 0.35  # singular values below this are left to the iteration
_SKETCH = 64


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


@dataclass(frozen=True)
class Basis:
    """Strong directions of the receptances.

    `left` tuple of (3c, r_h): L_h = K_c^-½ Q_h, h = 0 ... H; `right` tuple of (r_h, 3c): M_h, at
    the frequency where the basis was found.
    """

    left: tuple[Array, ...]
    right: tuple[Array, ...]

    @classmethod
    def strong(cls, balance: Balance, stiffness: Floats) -> "Basis":
        """That of a balance, by sketches of its receptances (Halko and others, 2011)."""
        root = np.sqrt(stiffness)
        rng = np.random.default_rng(0)
        left, right = [], []
        for h in range((balance.linear.shape[2] + 1) // 2):
            S = root[:, None] * balance.columns.all(h) / root
            if h == 0:
                S = S.real
            sketch = S @ rng.normal(size=(len(S), min(_SKETCH, len(S))))
            for _ in range(2):
                sketch = S @ la.qr(S.conj().T @ sketch, mode="economic")[0]
            Q = la.qr(sketch, mode="economic")[0]
            U, values, V = la.svd(Q.conj().T @ S, full_matrices=False)
            strong = values > min(_WEAK, 0.99 * values[0])  # one at least, if any moves
            left.append((Q @ U[:, strong]) / root[:, None])
            right.append((values[strong, None] * V[strong]) * root)
        return cls(tuple(left), tuple(right))

    def of(self, components: Integers) -> "Basis":
        """The basis seen by some components alone."""
        left = tuple(each[components] for each in self.left)
        return Basis(left, tuple(each[:, components] for each in self.right))

    def small_matrix(self, slope: _Slope) -> Floats:
        """I - M J L, the basis being that of the components of the slope's contacts."""
        columns = slope.columns(self.left)
        matrix = -self.seen(columns.reshape(3 * len(columns), slope.m, columns.shape[2]))
        matrix[np.diag_indices_from(matrix)] += 1.0
        return matrix

    def seen(self, w: Floats) -> Floats:
        """M w, (r,) or (r, p), of w (k, m) or (k, m, p)."""
        return _by_harmonic(self.right, w)

    def gathered(self, form: Floats) -> Floats:
        """Lᵀ form, (r,), of a linear form of displacements (k, m)."""
        return _by_harmonic([left.conj().T for left in self.left], form)

    def spread(self, a: Floats, m: int) -> Floats:
        """L a, (k, m)."""
        out = np.empty((len(self.left[0]), m))
        start = self.left[0].shape[1]
        out[:, 0] = self.left[0].real @ a[:start]
        for h, left in enumerate(self.left[1:], 1):
            r = left.shape[1]
            total = left @ (a[start : start + r] + 1j * a[start + r : start + 2 * r])
            out[:, 2 * h - 1], out[:, 2 * h] = total.real, total.imag
            start += 2 * r
        return out


def _by_harmonic(factors: Sequence[Array], w: Floats) -> Floats:
    """Products of a matrix (r_h, k) of each harmonic with w (k, m, ...), real parts first."""
    parts = [factors[0].real @ w[:, 0]]
    for h, factor in enumerate(factors[1:], 1):
        total = factor @ (w[:, 2 * h - 1] + 1j * w[:, 2 * h])
        parts += [total.real, total.imag]
    return np.concatenate(parts)


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
