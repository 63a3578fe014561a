"""The linearised balance P = I - (dW/du) R̂, solved directly or, where it is large, by GMRES.

A contact moves far under a unit of deviation only along directions in which the structure is soft
beside its contacts, and those are few: of S_h = K_c^½ R̂_h K_c^-½, some dozen singular values of
hundreds exceed 0.3. With Q_h their left vectors, R̂_h ≈ L_h M_h, L = K_c^-½ Q, M = Qᴴ K_c^½ R̂, and

    P = I - J R̂  ≈  I - J L M,      (I - J L M)⁻¹ = I + J L (I - M J L)⁻¹ M

(Woodbury) needs no factors but those of the small matrix I - M J L.

Along a path of solutions the parameter is one more unknown, and the plane across the path one more
equation; a mode has two more of each. Such a border of k unknowns p and equations is

    [ P    -r ] [ dw ]   [ gap ]
    [ nᵀ    c ] [ dp ] = [ g   ],      r = dW/dp,      n = dg/dw,      c = dg/dp.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray
from scipy.linalg.lapack import dgetrf, dgetrs

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.balance.receptance_columns import passed
from vanelock.nonlinear.contact.law import Deviation
from vanelock.nonlinear.newton.linearised_ring import LinearisedRing, RingBalance
from vanelock.nonlinear.newton.preconditioner import Equations, Kept, Preconditioned

_DIRECT = 150  # unknowns up to which factors are cheaper than an iteration
_IDLE = 1e-14  # of entries of P, of rows and columns that are zero but for rounding


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


def _slope_of(deviation: Deviation, contacts: Integers) -> _Slope:
    """The linearised law of some contacts."""
    m, jacobian = deviation.w.shape[2], deviation.jacobian
    blocks = jacobian if len(contacts) == len(deviation.w) else jacobian[contacts]
    return _Slope(contacts, blocks.reshape(len(contacts), 3 * m, 3, m))


_WEAK = 0.35  # singular values below this are left to the iteration
_SKETCH = 64


@dataclass(frozen=True)
class _Basis:
    """Strong directions of the receptances.

    `left` tuple of (3c, r_h): L_h = K_c^-½ Q_h, h = 0 ... H; `right` tuple of (r_h, 3c): M_h, at
    the frequency where the basis was found.
    """

    left: tuple[Array, ...]
    right: tuple[Array, ...]

    @classmethod
    def strong(cls, balance: Balance, stiffness: Floats) -> "_Basis":
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

    def of(self, components: Integers) -> "_Basis":
        """The basis seen by some components alone."""
        left = tuple(each[components] for each in self.left)
        return _Basis(left, tuple(each[:, components] for each in self.right))

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


@dataclass(frozen=True)
class _KeptBasis(Kept):
    """Strong directions; I - M J L (r, r) of one state, and its LU factors."""

    basis: _Basis
    matrix: Floats
    factors: tuple[Floats, NDArray[np.int32]]


def _distinct(ascending: Integers) -> tuple[Integers, Integers]:
    """The different ones of ascending numbers, and which of them each is."""
    new = np.ones(len(ascending), bool)
    new[1:] = ascending[1:] != ascending[:-1]
    return ascending[new], np.cumsum(new) - 1


def newton_matrix(balance: Balance, deviation: Deviation, rows: Integers) -> Floats:
    """P = I - (dW/du) R̂ on the given components of w."""
    if not len(rows):
        return np.zeros((0, 0))
    m = deviation.w.shape[2]
    component, k = rows // m, rows % m
    wanted, place = _distinct(component)
    contacts, local = _distinct(component // 3)
    slope = _slope_of(deviation, contacts)
    held = balance.columns.part(wanted, slope.components)
    columns = slope.columns([each.T for each in held])
    own = local * 3 * m + rows % (3 * m)
    matrix: Floats = -columns.reshape(-1, columns.shape[2])[own[:, None], k * len(wanted) + place]
    matrix[np.diag_indices_from(matrix)] += 1.0
    return matrix


class _Direct:
    """P factored."""

    def __init__(self, equations: Equations) -> None:
        balance, deviation, rows, self.weight, border, self.reuse, _ = equations
        matrix = newton_matrix(balance, deviation, rows)
        self.unknowns = rows
        if border is not None:
            column = -border.rate[:, rows].T
            matrix = np.block([[matrix, column], [border.normal[:, rows], border.corner]])
            self.unknowns = np.append(rows, deviation.w.size + np.arange(border.count))
        # A slider's mean place that neither a spring nor the structure holds is left where it is.
        size = np.abs(matrix)
        held = np.maximum(size.max(axis=0, initial=0.0), size.max(axis=1, initial=0.0)) > _IDLE
        if not held.all():
            matrix, self.unknowns = matrix[np.ix_(held, held)], self.unknowns[held]
        factors, pivots, info = dgetrf(matrix)
        self.factors = factors, pivots
        self.singular = info != 0 or not np.isfinite(factors.diagonal().sum())

    def solve(self, gap: Floats, tolerance: float) -> Floats | None:
        """(dw, dp); None where P is singular."""
        if self.singular:
            return None
        step = np.zeros_like(gap)
        step[self.unknowns] = dgetrs(*self.factors, gap[self.unknowns])[0]
        return step

    def merit(self, gap: Floats) -> float:
        """‖P⁻¹ gap‖."""
        ahead = gap.copy()  # components outside P count as they are
        ahead[self.unknowns] = dgetrs(*self.factors, gap[self.unknowns])[0]
        return float(np.linalg.norm(ahead * self.weight))

    def orientation(self) -> float:
        """Sign of the determinant."""
        diagonal, pivots = np.diagonal(self.factors[0]), self.factors[1]
        swaps = np.count_nonzero(pivots != np.arange(len(pivots)))
        return float(np.prod(np.sign(diagonal)) * (-1.0) ** swaps)


class _Iterative(Preconditioned):
    """P applied, preconditioned by the strong directions of the receptances."""

    LIMIT, STALE = 60, 6

    def __init__(self, equations: Equations) -> None:
        balance, deviation, rows, _, border, reuse, stiffness = equations
        m = deviation.w.shape[2]
        active = _distinct(rows // m)[0]
        contacts = _distinct(active // 3)[0]
        self.slope = _slope_of(deviation, contacts)
        self.components = self.slope.components
        entries = (self.components[:, None] * m + np.arange(m)).reshape(-1)
        super().__init__(equations, entries)
        self.pick = np.searchsorted(self.components, active)
        self.receptance = balance.columns.part(self.components[self.pick], self.components)
        basis = reuse.basis if isinstance(reuse, _KeptBasis) else _Basis.strong(balance, stiffness)
        self.basis = basis.of(self.components)
        if not isinstance(reuse, _KeptBasis) or reuse.stale:
            matrix = self.basis.small_matrix(self.slope)
            reuse = _KeptBasis(basis, matrix, dgetrf(matrix)[:2])
        self.reuse: _KeptBasis = reuse
        self.factors = reuse.factors
        if border is not None:
            self.factors = dgetrf(self._bordered(reuse.matrix))[:2]

    def _bordered(self, matrix: Floats) -> Floats:
        """The small matrix with the border's unknowns."""
        assert self.border is not None
        forms = (self.slope.transposed(each.reshape(-1, self.m)) for each in self.normal)
        row = np.array([self.basis.gathered(each) for each in forms])
        corner = self.normal @ self.rate.T + self.border.corner
        column = [-self.basis.seen(each.reshape(-1, self.m)) for each in self.rate]
        return np.block([[matrix, np.array(column).T], [row, corner]])

    def _alone(self, x: Floats) -> Floats:
        """P x."""
        x = x.reshape(-1, self.m)
        return np.asarray(x - self.slope(passed(x[self.pick], self.receptance))).reshape(-1)

    def _precondition(self, y: Floats) -> Floats:
        """(I - J L M)⁻¹, bordered."""
        count = len(self.entries)
        x = y[:count].reshape(-1, self.m)
        right = self.basis.seen(x)
        if self.border is not None:
            right = np.append(right, y[count:] - self.normal @ y[:count])
        small = dgetrs(*self.factors, right)[0]
        inner = small[: len(self.reuse.matrix)]
        moved = self.slope(self.basis.spread(inner, self.m))
        out = y.copy()
        out[:count] += moved.reshape(-1)
        if self.border is not None:
            out[count:] = small[len(inner) :]
            out[:count] += out[count:] @ self.rate
        return out

    def orientation(self) -> float:
        """Sign of det P = det(P M⁻¹) det M, M the preconditioner made at this very state."""
        matrix = self.reuse.matrix if self.border is None else self._bordered(self.reuse.matrix)
        return float(np.linalg.slogdet(matrix)[0]) * self._turned()


def linearise(equations: Equations) -> _Direct | Preconditioned:
    """P at a state, ready to be solved; see `_Direct`."""
    if isinstance(equations.balance, RingBalance):
        return LinearisedRing(equations)
    return _Direct(equations) if len(equations.rows) <= _DIRECT else _Iterative(equations)
