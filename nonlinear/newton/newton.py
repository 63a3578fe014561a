"""Newton's iteration on the condensed balance, on the contacts that deviate from sticking.

Components of w that are zero on both sides of w = W(u(w)) are no unknowns; one that becomes
active is added on the spot, so that the solution found solves all equations. Steps are judged by
the natural merit ‖P⁻¹r‖ with the current matrix P (Deuflhard), and never made shorter than 1/8: at
the kinks of the law, short steps stall where a long one that raises the residual passes.

The balance may belong to a family, by frequency or load. Its parameter is then held, or free on a
plane across the path of solutions, which is how arcs pass folds.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.contact.law import Deviation, Law
from vanelock.nonlinear.newton.law_jacobian import response_to
from vanelock.nonlinear.newton.linearised import Border, linearise
from vanelock.nonlinear.newton.preconditioner import Kept

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

TOLERANCE = 1e-10
ROUNDING = 1e-5  # of w; times the tolerance a few times the spacing of numbers
CARRIED = 1e8  # w over the largest scale beyond which rounding counts as what is left
LENGTHS = (1.0, 0.5, 0.25, 0.125)


class Family(Protocol):
    """Balances that differ by one parameter."""

    def at(self, parameter: float) -> Balance:
        """The balance at a value of the parameter."""

    def law(self, parameter: float) -> Law:
        """The law of contact at a value of the parameter."""

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Rows) -> Floats:
        """Derivative of W to the parameter at fixed w, on the given components of w."""


@dataclass(frozen=True)
class CuttingPlane:
    """The plane normal·(w - w₀, parameter - parameter₀) = 0, for a parameter that is free."""

    w: Floats
    parameter: float
    normal_w: Floats
    normal_parameter: float

    def distance(self, w: Floats, parameter: float) -> float:
        """Distance of a point along the normal."""
        along = np.vdot(self.normal_w, w - self.w)
        return float(along + self.normal_parameter * (parameter - self.parameter))


@dataclass(frozen=True)
class Solution:
    """A state of the balance, converged or the best that was reached.

    Attributes
    ----------
    omega : float
        rad/s.
    parameter : float
        Of the family.
    w, u : (c, 3, 2H + 1) float
        Deviation and relative displacement, m.
    residual : float
        Largest |w - W(u)| of each harmonic over that harmonic's scale.
    iterations : int
        Newton steps, of failed attempts at the point too.
    converged : bool
        Whether the residual is below the tolerance.
    deviation : Deviation
        The law at u.
    kept : Kept or None
        Preconditioner for the solutions that follow.
    seconds : float
        Processor time spent, where it was taken.
    truncation : float
        Error of the displacements by modes that count by their static part alone.
    continued : bool
        Whether it was reached from its neighbour by solutions that nowhere turned back.
    """

    omega: float
    parameter: float
    w: Floats
    u: Floats
    residual: float
    iterations: int
    converged: bool
    deviation: Deviation
    kept: Kept | None = None
    seconds: float = 0.0
    truncation: float = 0.0
    continued: bool = True


def scales(linear: Floats) -> Floats:
    """(2H + 1,) displacements, m, to which the residual of each harmonic is referred.

    The mean is measured against the largest displacement; harmonics h >= 1 against the largest of
    theirs, but not more finely than rounding of the mean allows.
    """
    every = np.abs(linear).max(axis=(0, 1), initial=0.0)
    largest = every.max()
    moving = max(every[1:].max(initial=0.0), 1e-4 * largest)
    scale = np.full(linear.shape[2], moving if moving > 0 else 1.0)
    scale[0] = largest if largest > 0 else 1.0
    return scale


def sensitivity(
    balance: Balance, solution: Solution, pushed: Floats, stiffness: Floats
) -> Floats | None:
    """How u changes if a displacement (c, 3, 2H + 1) is added to ũ; None where P is singular."""
    rows = active_rows(solution.w, solution.deviation)
    if not len(rows):
        return pushed
    weight = np.broadcast_to(1 / scales(balance.linear), pushed.shape).reshape(-1)
    linear = linearise(balance, solution.deviation, rows, weight, None, solution.kept, stiffness)
    right = np.zeros(pushed.size)
    right[rows] = response_to(solution.deviation, rows, pushed)
    step = linear.solve(right, 1e-4)
    return None if step is None else pushed + balance.moved(step.reshape(pushed.shape))


def active_rows(w: Floats, deviation: Deviation) -> Rows:
    """Components of w that are unknown: not zero on either side of w = W."""
    return np.flatnonzero((w != 0) | (deviation.w != 0))


@dataclass(frozen=True)
class _State:
    """One evaluation of the equations."""

    w: Floats
    parameter: float
    balance: Balance
    u: Floats
    deviation: Deviation
    gap: Floats  # (n,) or, on a plane, (n + 1,)


def _evaluate(
    family: Family,
    w: Floats,
    parameter: float,
    balance: Balance | None,
    plane: CuttingPlane | None,
) -> _State:
    if balance is None:
        balance = family.at(parameter)
    u = balance.displacement(w)
    deviation = family.law(parameter)(u, balance.omega)
    gap = (w - deviation.w).reshape(-1)
    if plane is not None:
        gap = np.append(gap, plane.distance(w, parameter))
    return _State(w, parameter, balance, u, deviation, gap)


def solve(
    family: Family,
    start: Floats,
    parameter: float,
    plane: CuttingPlane | None = None,
    tolerance: float = TOLERANCE,
    limit: int = 15,
    kept: Kept | None = None,
) -> Solution:
    """Solve w = W(u(w)) from a start, at a parameter or on a plane."""
    held = family.at(parameter) if plane is None else None
    state = _evaluate(family, start, parameter, held, plane)
    scale = scales(state.balance.linear)
    clean = np.where((state.deviation.w == 0) & (np.abs(start) <= tolerance * scale), 0.0, start)
    if np.any(clean != start):
        state = _evaluate(family, clean, parameter, held, plane)
    weight = np.broadcast_to(1 / scale, start.shape).reshape(-1)
    if plane is not None:
        weight = np.append(weight, 1.0)
    active = np.zeros(start.size, bool)
    iteration = 0
    while True:
        # Where sliders were carried a million times further than they vibrate, rounding is left.
        carried = np.abs(state.w).max(initial=0.0)
        reach = np.maximum(scale, ROUNDING * carried)
        gap = state.gap[: start.size].reshape(start.shape)
        residual = float(np.abs(gap / reach).max(initial=0.0))
        if carried > CARRIED * scale.max():  # nothing holds what flies so far
            residual = max(residual, float(np.finfo(float).eps * carried / scale.max()))
        if residual < tolerance or iteration == limit or not np.isfinite(residual):
            break
        active[active_rows(state.w, state.deviation)] = True
        exact = min(1e-2, max(0.1 * tolerance / residual, residual))
        rows = np.flatnonzero(active)
        following = _step(family, state, rows, weight, exact, held, plane, kept)
        if following is None:
            break
        state, kept = following
        iteration += 1
    return Solution(
        omega=state.balance.omega,
        parameter=state.parameter,
        w=state.w,
        u=state.u,
        residual=residual,
        iterations=iteration,
        converged=residual < tolerance,
        deviation=state.deviation,
        kept=kept,
    )


def _step(
    family: Family,
    state: _State,
    rows: Rows,
    weight: Floats,
    tolerance: float,
    held: Balance | None,
    plane: CuttingPlane | None,
    kept: Kept | None,
) -> tuple[_State, Kept | None] | None:
    """One damped Newton step; None where the matrix is singular."""
    n, border = state.w.size, None
    if plane is not None:
        rate = np.zeros(n)
        rate[rows] = family.rate(state.parameter, state.w, state.deviation, rows)
        border = Border(rate, plane.normal_w.reshape(-1), plane.normal_parameter)
    stiffness = family.law(state.parameter).stiffness.reshape(-1)
    linear = linearise(state.balance, state.deviation, rows, weight, border, kept, stiffness)
    step = linear.solve(-state.gap, tolerance)
    if step is None:
        return None
    merit = linear.merit(state.gap)
    best: tuple[float, _State] | None = None
    for length in LENGTHS:
        w = state.w + length * step[:n].reshape(state.w.shape)
        parameter = state.parameter if plane is None else state.parameter + length * step[n]
        trial = _evaluate(family, w, parameter, held, plane)
        reached = linear.merit(trial.gap)
        if best is None or not best[0] <= reached:
            best = (reached, trial)
        if reached < (1 - length / 4) * merit:
            break
    assert best is not None
    return best[1], linear.kept
