"""Newton's iteration on the condensed balance, on the contacts that deviate from sticking.

Components of w that are zero on both sides of w = W(u(w)) are no unknowns; one that becomes
active is added on the spot, so that the solution found solves all equations. Steps are judged by
the natural merit ‖P⁻¹r‖ with the current matrix P (Deuflhard), and never made shorter than 1/8: at
the kinks of the law, short steps stall where a long one that raises the residual passes.

The balance may belong to a family, by frequency or load. Its parameter is then held, or free on a
plane across the path of solutions, which is how paths pass folds. A mode's problems have unknowns
beside w, and equations for them.
"""

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.contact.law import Deviation, Law
from vanelock.nonlinear.newton.linearised import linearise
from vanelock.nonlinear.newton.preconditioner import Border, Equations, Kept, response_to

TOLERANCE = 1e-10
_ROUNDING = 1e-5  # of w; times the tolerance a few times the spacing of numbers
CARRIED = 1e8  # w over the largest scale beyond which rounding counts as what is left
_LENGTHS = (1.0, 0.5, 0.25, 0.125)
_FINE = 1e-13
"""Residual that a solution should have, where rounding lets it, for what is derived from it."""


class Family(Protocol):
    """Balances that differ by one parameter."""

    def at(self, parameter: float) -> Balance:
        """The balance at a value of the parameter."""

    def law(self, parameter: float) -> Law:
        """The law of contact at a value of the parameter."""

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """Derivative of W to the parameter at fixed w, on the given components of w."""


@dataclass(frozen=True)
class StepUnits:
    """Inverse of what counts as a step of length 1; of w by harmonic, (2H + 1,)."""

    w: Floats
    parameter: float
    beside: Floats

    def length(self, w: Floats, parameter: float, beside: Floats) -> float:
        """Length of a change."""
        others = np.append(beside * self.beside, parameter * self.parameter)
        return float(np.hypot(np.linalg.norm(w * self.w), np.linalg.norm(others)))


class Bordered(Family):
    """A family with k unknowns y beside w, and k equations g = 0 for them.

    It is made anew at each point of its path, such as that of a mode's shape.
    """

    @property
    @abstractmethod
    def beside(self) -> Floats:
        """The unknowns (k,) as they are."""

    @property
    @abstractmethod
    def longest(self) -> Floats:
        """(k,) what a step of Newton's iteration may change them by, at most."""

    @abstractmethod
    def with_beside(self, beside: Floats) -> Self:
        """The same with the unknowns elsewhere."""

    @abstractmethod
    def left(self, parameter: float, w: Floats) -> Floats:
        """What is left of the equations, g (k,), relative to what they are of."""

    @abstractmethod
    def border(
        self, parameter: float, w: Floats, deviation: Deviation, rows: Integers
    ) -> tuple[Border, Floats]:
        """Derivatives by the unknowns, on the given components of w; and dg/dp (k,)."""

    @abstractmethod
    def units(self, solution: "Solution") -> StepUnits:
        """What a step is measured by at a solution."""

    @abstractmethod
    def carried(self, solution: "Solution") -> "tuple[Self, Solution]":
        """The family from a solution on, and the solution as one of that family's."""

    @abstractmethod
    def holds(self, solution: "Solution") -> bool:
        """Whether a solution is close enough to those that the family was made for."""


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

    `omega`: rad/s; `parameter`: of the family; `w`, `u` (c, 3, 2H + 1): deviation and relative
    displacement, m; `residual`: largest |w - W(u)| of each harmonic over that harmonic's scale;
    `iterations`: Newton steps, of failed attempts at the point too; `converged`: whether the
    residual is below the tolerance; `deviation`: the law at u; `reuse`: preconditioner for the
    solutions that follow; `seconds`: processor time spent, where it was taken; `truncation`: error
    of the displacements by modes that count by their static part alone; `continued`: whether it was
    reached from its neighbour by solutions that nowhere turned back; `beside`: the family's other
    unknowns.
    """

    omega: float
    parameter: float
    w: Floats
    u: Floats
    residual: float
    iterations: int
    converged: bool
    deviation: Deviation
    reuse: Kept | None = None
    seconds: float = 0.0
    truncation: float = 0.0
    continued: bool = True
    beside: tuple[float, ...] = ()


def at_solution(family: Family, solution: Solution) -> Family:
    """A family with its unknowns, if it has any, as a solution has them."""
    if not isinstance(family, Bordered):
        return family
    return family.with_beside(np.array(solution.beside))


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
    deviation, reuse = solution.deviation, solution.reuse
    linear = linearise(Equations(balance, deviation, rows, weight, None, reuse, stiffness))
    right = np.zeros(pushed.size)
    right[rows] = response_to(deviation, rows, pushed)
    step = linear.solve(right, 1e-4)
    return None if step is None else pushed + balance.moved(step.reshape(pushed.shape))


def active_rows(w: Floats, deviation: Deviation) -> Integers:
    """Components of w that are unknown: not zero on either side of w = W."""
    return np.flatnonzero((w != 0) | (deviation.w != 0))


@dataclass(frozen=True)
class _State:
    """One evaluation of the equations."""

    family: Family
    w: Floats
    parameter: float
    balance: Balance
    u: Floats
    deviation: Deviation
    gap: Floats  # (n,) and, on a plane, 1 more, and one for each unknown beside
    left: float  # of the equations of those


def _evaluate(
    family: Family, w: Floats, parameter: float, balance: Balance | None, plane: CuttingPlane | None
) -> _State:
    if balance is None:
        balance = family.at(parameter)
    u = balance.displacement(w)
    deviation = family.law(parameter)(u, balance.omega)
    gap = (w - deviation.w).reshape(-1)
    if plane is not None:
        gap = np.append(gap, plane.distance(w, parameter))
    left = 0.0
    if isinstance(family, Bordered):
        others = family.left(parameter, w)
        gap, left = np.append(gap, others), float(np.abs(others).max())
    return _State(family, w, parameter, balance, u, deviation, gap, left)


def solve(
    family: Family,
    start: Floats,
    parameter: float,
    plane: CuttingPlane | None = None,
    tolerance: float = TOLERANCE,
    limit: int = 15,
    reuse: Kept | None = None,
) -> Solution:
    """Solve w = W(u(w)) from a start, at a parameter or on a plane."""
    bordered = isinstance(family, Bordered)
    held = family.at(parameter) if plane is None and not bordered else None
    state = _evaluate(family, start, parameter, held, plane)
    scale = scales(state.balance.linear)
    clean = np.where((state.deviation.w == 0) & (np.abs(start) <= tolerance * scale), 0.0, start)
    if np.any(clean != start):
        state = _evaluate(family, clean, parameter, held, plane)
    weight = np.broadcast_to(1 / scale, start.shape).reshape(-1)
    if plane is not None:
        weight = np.append(weight, 1.0)
    if isinstance(family, Bordered):
        weight = np.append(weight, 1 / family.longest)
    active = np.zeros(start.size, bool)
    iteration = 0
    while True:
        # Where sliders were carried a million times further than they vibrate, rounding is left.
        carried = np.abs(state.w).max(initial=0.0)
        reach = np.maximum(scale, _ROUNDING * carried)
        gap = state.gap[: start.size].reshape(start.shape)
        residual = max(float(np.abs(gap / reach).max(initial=0.0)), state.left)
        if carried > CARRIED * scale.max():  # nothing holds what flies so far
            residual = max(residual, float(np.finfo(float).eps * carried / scale.max()))
        if residual < tolerance or iteration == limit or not np.isfinite(residual):
            break
        active[active_rows(state.w, state.deviation)] = True
        exact = min(1e-2, max(0.1 * tolerance / residual, residual))
        rows = np.flatnonzero(active)
        following = _step(state, rows, weight, exact, held, plane, reuse)
        if following is None:
            break
        state, reuse = following
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
        reuse=reuse,
        beside=tuple(state.family.beside.tolist()) if isinstance(state.family, Bordered) else (),
    )


def refined(
    family: Family,
    start: Floats,
    parameter: float,
    plane: CuttingPlane | None = None,
    tolerance: float = TOLERANCE,
    reuse: Kept | None = None,
) -> Solution:
    """`solve`, and one more step where it may help: what is derived wants more than others do."""
    found = solve(family, start, parameter, plane, tolerance, reuse=reuse)
    if not found.converged or found.residual <= _FINE:
        return found
    there = at_solution(family, found)
    again = solve(there, found.w, found.parameter, plane, _FINE, 1, found.reuse)
    if not again.residual < found.residual:
        return found
    return replace(again, converged=True, iterations=found.iterations + again.iterations)


def _border(state: _State, rows: Integers, plane: CuttingPlane | None) -> Border | None:
    """What is unknown beside w, and the equations of it."""
    n, family = state.w.size, state.family
    inner = by_parameter = None
    if isinstance(family, Bordered):
        inner, by_parameter = family.border(state.parameter, state.w, state.deviation, rows)
    if plane is None:
        return inner
    rate = np.zeros((1, n))
    rate[0, rows] = family.rate(state.parameter, state.w, state.deviation, rows)
    normal, corner = plane.normal_w.reshape(1, -1), np.full((1, 1), plane.normal_parameter)
    if inner is None or by_parameter is None:
        return Border(rate, normal, corner)
    none = np.zeros((1, inner.count))
    return Border(
        np.vstack([rate, inner.rate]),
        np.vstack([normal, inner.normal]),
        np.block([[corner, none], [by_parameter[:, None], inner.corner]]),
    )


def _step(
    state: _State,
    rows: Integers,
    weight: Floats,
    tolerance: float,
    held: Balance | None,
    plane: CuttingPlane | None,
    reuse: Kept | None,
) -> tuple[_State, Kept | None] | None:
    """One damped Newton step; None where the matrix is singular."""
    n, family = state.w.size, state.family
    border = _border(state, rows, plane)
    stiffness = family.law(state.parameter).stiffness.reshape(-1)
    balance, deviation = state.balance, state.deviation
    linear = linearise(Equations(balance, deviation, rows, weight, border, reuse, stiffness))
    step = linear.solve(-state.gap, tolerance)
    if step is None:
        return None
    others = slice(n + (plane is not None), None)
    if isinstance(family, Bordered):
        step = step / max(1.0, float(np.abs(step[others] / family.longest).max()))
    merit = linear.merit(state.gap)
    best: tuple[float, _State] | None = None
    for length in _LENGTHS:
        w = state.w + length * step[:n].reshape(state.w.shape)
        parameter = state.parameter if plane is None else state.parameter + length * step[n]
        there = family
        if isinstance(family, Bordered):
            there = family.with_beside(family.beside + length * step[others])
        trial = _evaluate(there, w, parameter, held, plane)
        reached = linear.merit(trial.gap)
        if best is None or not best[0] <= reached:
            best = (reached, trial)
        if reached < (1 - length / 4) * merit:
            break
    assert best is not None
    return best[1], linear.reuse
