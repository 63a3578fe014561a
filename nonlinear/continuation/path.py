"""Continuation: a path of solutions, point by point and through folds, by its arc length.

The tangent (z, 1) solves P z = (dW/du) du/dp. Its direction along the path follows from
sign(ṗ) · sign det P = const, which holds through folds and, unlike the angle with the last
tangent, across the kinks of the law. Unknowns beside w, with their equations, border P.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.newton.linearised import linearise
from vanelock.nonlinear.newton.newton import (
    Bordered,
    CuttingPlane,
    Family,
    Solution,
    StepUnits,
    active_rows,
    at_solution,
    scales,
    solve,
)
from vanelock.nonlinear.newton.preconditioner import Equations

_ROUGH = 1e-7  # residual of the points on the way
SHORTEST = 2e-3
_GROWTH = 3.0  # of a step, at most
_EXACT = 1e-9  # of tangents
_BOUNCE = -0.98
"""Cosine of the angle between a step and where the tangent leads from its end, below which it leads
straight back: no fold, of which even a sharp one turns w, but a point where branches cross."""
_ACROSS, _ROUNDS = 1e-3, 60
"""Of the parameter: how far beyond an onset that has no tangent a point is looked for, after so
many rounds of the law, half a step each."""


@dataclass(frozen=True)
class Tangent:
    """How solutions move with the parameter, z = dw/dp and the unknowns beside; sign of det P."""

    z: Floats
    orientation: float
    beside: Floats


@dataclass(frozen=True)
class PathPoint:
    """A point of a path, converged to `_ROUGH` at least, and where the path goes on from there.

    `along` is dw/ds, m, `rate` dp/ds, `beside` that of the unknowns beside, s in `units`.
    """

    solution: Solution
    tangent: Tangent
    along: Floats
    rate: float
    beside: Floats
    units: StepUnits

    def plane(self, length: float = 0.0) -> CuttingPlane:
        """The plane across the path's tangent, a length further on."""
        return CuttingPlane(
            self.solution.w + length * self.along,
            self.solution.parameter + length * self.rate,
            self.along * self.units.w**2,
            self.rate * self.units.parameter**2,
        )


def tangent_at(family: Family, point: Solution, balance: Balance | None = None) -> Tangent | None:
    """Tangent of the path at a point of it, its balance known or not; None where P is singular."""
    family = at_solution(family, point)
    balance = balance or family.at(point.parameter)
    rows, n, border = active_rows(point.w, point.deviation), point.w.size, None
    right = np.zeros(n)
    weight = np.broadcast_to(1 / scales(balance.linear), point.w.shape).reshape(-1)
    if isinstance(family, Bordered):
        border, by_parameter = family.border(point.parameter, point.w, point.deviation, rows)
        right = np.append(right, -by_parameter)
        weight = np.append(weight, 1 / family.longest)
    elif not len(rows):
        return Tangent(right.reshape(point.w.shape), 1.0, right[:0])
    reuse = None if point.reuse is None else replace(point.reuse, stale=True)
    stiffness = family.law(point.parameter).stiffness.reshape(-1)
    deviation = point.deviation
    linear = linearise(Equations(balance, deviation, rows, weight, border, reuse, stiffness))
    right[rows] = family.rate(point.parameter, point.w, point.deviation, rows)
    moved = linear.solve(right, _EXACT)
    if moved is None:
        return None
    return Tangent(moved[:n].reshape(point.w.shape), linear.orientation(), moved[n:])


class SolutionPath:
    """A path of solutions, point by point, from a converged one towards a value of the parameter.

    Iterated it gives points without end; what lands on the way takes `ahead` and `go`.

    `family`: as it is from `here` on; `here`: where the path is; None where it has no tangent;
    `drawn`: whether its points draw a curve, by steps up to the longest; else it only leads
    somewhere; `near`: how far a point may lie from where its tangent led, in steps; at kinks, too;
    `length`, `taken`: of the next step, and of the last one; `iterations`, `failed`: Newton's
    iterations and failed steps so far.
    """

    def __init__(
        self,
        family: Family,
        start: Solution,
        target: float,
        longest: float | None = None,
        shortest: float = SHORTEST,
        near: float | None = None,
    ) -> None:
        self.family, self.target = family, target
        self.span = target - start.parameter
        self.drawn = longest is not None
        self.longest, self.shortest, self.near = longest or np.inf, shortest, near
        self.length = self.taken = min(0.2, self.longest)
        self.iterations = self.failed = 0
        self.here: PathPoint | None = None
        self._constant = 0.0
        if not isinstance(family, Bordered):
            ends = [scales(family.at(p).linear) for p in (start.parameter, target)]
            self.weight = 1 / np.maximum(*ends)
        self.go(start)

    def __iter__(self) -> Iterator[PathPoint]:
        while self.here is not None:
            yield self.here
            ahead = self.ahead()
            if ahead is None:
                return
            self.go(ahead)

    def go(self, solution: Solution, stepped: bool = True) -> None:
        """Have the path go on from a solution on it, a step ahead or anywhere between."""
        came, self.here = self.here, None
        if isinstance(self.family, Bordered):
            self.family, solution = self.family.carried(solution)
        tangent = tangent_at(self.family, solution)
        if tangent is None:
            return
        units = self._units(solution)
        self._constant = self._constant or float(np.sign(self.span)) * tangent.orientation
        here = self._directed(solution, tangent, units)
        if stepped and came is not None and _cosine(came.solution, here) < _BOUNCE:
            self._constant *= -1
            here = self._directed(solution, tangent, units)
        self.here = here

    def ahead(self) -> Solution | None:
        """The next point, its step halved until Newton converges; None if there is none.

        Where even the shortest step fails, a contact changes its state right here, and the path
        goes on in the direction that the other state gives it, which may be backwards.
        """
        assert self.here is not None
        length = self.length
        while True:
            found = self._step(self.here, length)
            if found is not None:
                return found
            if length <= self.shortest:
                break
            length *= 0.5
        for push in (2.0, 8.0, 32.0):
            little = push * self.shortest
            turned = self._beyond(self.here, little)
            if turned is None or (self.near is not None and _is_back(self.here, turned)):
                continue
            for longer in (1, 4, 16, 64):
                found = self._step(turned, longer * little)
                if found is not None:
                    return found
        return self._across(self.here) if isinstance(self.family, Bordered) else None

    def _units(self, solution: Solution) -> StepUnits:
        """What is measured at a point: what is drawn by w as it is there, if more than stuck."""
        if isinstance(self.family, Bordered):
            return self.family.units(solution)
        weight = self.weight
        if self.drawn and solution.w.any():
            weight = np.minimum(weight, 1 / scales(solution.w))
        return StepUnits(weight, 1 / abs(self.span), np.zeros(0))

    def _directed(self, solution: Solution, tangent: Tangent, units: StepUnits) -> PathPoint:
        """A point with the direction of the path, of length 1."""
        rate = self._constant * tangent.orientation
        rate = rate / units.length(tangent.z, 1.0, tangent.beside)
        return PathPoint(solution, tangent, tangent.z * rate, rate, tangent.beside * rate, units)

    def _beyond(self, here: PathPoint, length: float) -> PathPoint | None:
        """A point, its direction as the state of the contacts a little further has it."""
        plane, beside = here.plane(length), here.solution.beside + length * here.beside
        further = replace(
            here.solution, w=plane.w, parameter=plane.parameter, beside=tuple(beside.tolist())
        )
        family = at_solution(self.family, further)
        balance = family.at(plane.parameter)
        u = balance.displacement(plane.w)
        deviation = family.law(plane.parameter)(u, balance.omega)
        tangent = tangent_at(family, replace(further, u=u, deviation=deviation), balance)
        return None if tangent is None else self._directed(here.solution, tangent, here.units)

    def _step(self, here: PathPoint, length: float) -> Solution | None:
        """The point at a distance along the direction of the path, if Newton finds one there."""
        begin, plane = here.solution, here.plane(length)
        beside = np.asarray(begin.beside) + length * here.beside
        family = self.family
        if isinstance(family, Bordered):
            family = family.with_beside(beside)
        found = solve(family, plane.w, plane.parameter, plane, _ROUGH, 12, begin.reuse)
        self.iterations += found.iterations
        moved = here.units.length(
            found.w - plane.w, found.parameter - plane.parameter, found.beside - beside
        )
        # A path may bend by 45 degrees in a step, and sharply at a kink, which short steps single
        # out.
        if self.near is None:
            near = moved < length or moved < 3 * length < 0.25
        else:
            near = moved < self.near * length
        if not (found.converged and near and self._continues(begin, found)):
            self.failed += 1
            return None
        self._take(length, found)
        return found

    def _continues(self, begin: Solution, solution: Solution) -> bool:
        """Whether a point is not too far from the last one."""
        if isinstance(self.family, Bordered):
            return self.family.holds(solution)
        # Where the path leads away from the target, steps grow with the distance from there.
        far = max(abs(begin.parameter - self.target), abs(self.span))
        return abs(solution.parameter - begin.parameter) <= 0.3 * far

    def _take(self, length: float, solution: Solution) -> None:
        """Note a step, and how long the next one is."""
        growth = float(np.clip(3.5 / max(solution.iterations, 1), 0.5, _GROWTH))
        self.taken, self.length = length, min(length * growth, self.longest)

    def _across(self, here: PathPoint) -> Solution | None:
        """The point a little beyond a value at which sliders begin to move all the way round.

        On a circle |w| grows there as a root, to which no derivative leads, but the law itself.
        """
        parameter, w = here.solution.parameter * (1 + _ACROSS), here.solution.w
        family = at_solution(self.family, here.solution)
        balance, law = family.at(parameter), family.law(parameter)
        for _ in range(_ROUNDS):
            w = 0.5 * (w + law(balance.displacement(w), balance.omega).w)
        found = solve(family, w, parameter, tolerance=_ROUGH, reuse=here.solution.reuse)
        self.iterations += found.iterations
        length = here.units.length(found.w - here.solution.w, _ACROSS * parameter, np.zeros(1))
        if not (found.converged and length < 1.0 and self._continues(here.solution, found)):
            return None
        self._take(length, found)
        return found


def _cosine(came: Solution, here: PathPoint) -> float:
    """Of the angle between a step and the direction in which the path goes on."""
    units = here.units
    w, parameter = here.solution.w - came.w, here.solution.parameter - came.parameter
    back = np.vdot(here.along * units.w**2, w) + here.rate * parameter * units.parameter**2
    return float(back / np.hypot(np.linalg.norm(w * units.w), parameter * units.parameter))


def _is_back(here: PathPoint, turned: PathPoint) -> bool:
    """Whether a direction leads straight back."""
    units = here.units
    along = np.vdot(here.along * units.w, turned.along * units.w)
    others = np.vdot(here.beside * units.beside, turned.beside * units.beside)
    return float(along + others + here.rate * turned.rate * units.parameter**2) < _BOUNCE
