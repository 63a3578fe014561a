"""The linearised balance P = I - (dW/du) R̂, solved directly or, where it is large, by GMRES.

Along a path of solutions the parameter is one more unknown, and the plane across the path one more
equation; a mode has two more of each. Such a border of k unknowns p and equations is

    [ P    -r ] [ dw ]   [ gap ]
    [ nᵀ    c ] [ dp ] = [ g   ],      r = dW/dp,      n = dg/dw,      c = dg/dp.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgetrf, dgetrs

from vanelock.common.arrays import Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.balance.receptance_columns import passed
from vanelock.nonlinear.contact.law import Deviation
from vanelock.nonlinear.newton.linearised_ring import LinearisedRing, RingBalance
from vanelock.nonlinear.newton.preconditioner import (
    Basis,
    Equations,
    Kept,
    Preconditioned,
    slope_of,
)

_DIRECT = 150  # unknowns up to which factors are cheaper than an iteration
_IDLE = 1e-14  # of entries of P, of rows and columns that are zero but for rounding


@dataclass(frozen=True)
class KeptBasis(Kept):
    """Strong directions and the small matrix of one state.

    `matrix` (r, r): I - M J L of `preconditioner`; `factors`: its LU factors.
    """

    basis: Basis
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
    slope = slope_of(deviation, contacts)
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
        self.slope = slope_of(deviation, contacts)
        self.components = self.slope.components
        entries = (self.components[:, None] * m + np.arange(m)).reshape(-1)
        super().__init__(equations, entries)
        self.pick = np.searchsorted(self.components, active)
        self.receptance = balance.columns.part(self.components[self.pick], self.components)
        basis = reuse.basis if isinstance(reuse, KeptBasis) else Basis.strong(balance, stiffness)
        self.basis = basis.of(self.components)
        if not isinstance(reuse, KeptBasis) or reuse.stale:
            matrix = self.basis.small_matrix(self.slope)
            reuse = KeptBasis(basis, matrix, dgetrf(matrix)[:2])
        self.reuse: KeptBasis = reuse
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
