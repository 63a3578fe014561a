"""Arc length: follow a path of solutions, through folds, to a given value of its parameter.

The tangent (z, 1) solves P z = (dW/du) du/dp. Its direction along the path follows from
sign(ṗ) · sign det P = const, which holds through folds and, unlike the angle with the last
tangent, across the kinks of the law.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.newton.linearised import linearise
from vanelock.nonlinear.newton.newton import (
    CARRIED,
    TOLERANCE,
    CuttingPlane,
    Family,
    Solution,
    active_rows,
    scales,
    solve,
)

Floats = NDArray[np.float64]

ROUGH = 1e-7  # residual of the points on the way
SHORTEST = 2e-3
GROWTH = 3.0  # of a step, at most
EXACT = 1e-9  # of tangents
BOUNCE = -0.98
"""Cosine of the angle between a step and where the tangent leads from its end, below which it leads
straight back: no fold, of which even a sharp one turns w, but a point where branches cross."""


@dataclass(frozen=True)
class Arc:
    """Where a path led: the state at the target, None if not there; parameters where it turned."""

    solution: Solution | None
    folds: tuple[float, ...]
    iterations: int


@dataclass(frozen=True)
class Tangent:
    """How solutions move with the parameter, z = dw/dp; the sign of det P."""

    z: Floats
    orientation: float


@dataclass(frozen=True)
class ArcStep:
    """A point of a path, converged to `ROUGH` at least, and the plane through it, across the path.

    `along` is dw/ds in the direction of the path, m, `rate` dp/ds, in (w·weight, p/span).
    """

    solution: Solution
    tangent: Tangent
    along: Floats
    rate: float
    plane: CuttingPlane


def tangent_at(family: Family, point: Solution, balance: Balance | None = None) -> Tangent | None:
    """Tangent of the path at a point of it, its balance known or not; None where P is singular."""
    balance = balance or family.at(point.parameter)
    rows = active_rows(point.w, point.deviation)
    z = np.zeros(point.w.size)
    if not len(rows):
        return Tangent(z.reshape(point.w.shape), 1.0)
    weight = np.broadcast_to(1 / scales(balance.linear), point.w.shape).reshape(-1)
    kept = None if point.kept is None else replace(point.kept, stale=True)
    stiffness = family.law(point.parameter).stiffness.reshape(-1)
    linear = linearise(balance, point.deviation, rows, weight, None, kept, stiffness)
    z[rows] = family.rate(point.parameter, point.w, point.deviation, rows)
    moved = linear.solve(z, EXACT)
    if moved is None:
        return None
    return Tangent(moved.reshape(point.w.shape), linear.orientation())


def follow(
    family: Family,
    start: Solution,
    target: float,
    tolerance: float = TOLERANCE,
    limit: int = 200,
    effort: int = 2000,
    shortest: float = SHORTEST,
    away: float = np.inf,
) -> Arc:
    """Follow the path of solutions from a converged point until the parameter passes `target`."""
    if target == start.parameter:
        return Arc(start, (), 0)
    here, folds, iterations, length = start, [], 0, 0.2
    course: Course | None = None
    last_sign = np.sign(target - start.parameter)
    for _ in range(limit):
        tangent = tangent_at(family, here)
        if tangent is None:
            break
        course = course or _course(family, start, target, tangent, shortest)
        sign = course.constant * tangent.orientation
        if sign != last_sign:
            folds.append(here.parameter)
            last_sign = sign
        ahead, spent = _advance(family, here, tangent, course, length)
        iterations += spent
        if ahead is None or iterations > effort:
            break
        following, taken = ahead
        length = taken * np.clip(3.5 / max(following.iterations, 1), 0.5, GROWTH)
        if (following.parameter - target) / course.span >= 0:
            ratio = (target - here.parameter) / (following.parameter - here.parameter)
            for begin in (here.w + ratio * (following.w - here.w), following.w, here.w):
                landed = solve(family, begin, target, tolerance=tolerance, kept=here.kept)
                iterations += landed.iterations
                if landed.converged:
                    landed = replace(landed, iterations=iterations)
                    return Arc(landed, tuple(folds), iterations)
            if taken < 4 * shortest:
                break
            length = 0.25 * taken  # come closer before landing
            continue
        here = following
        flown = np.abs(here.w * course.weight).max(initial=0.0) > CARRIED  # nothing holds it
        if flown or (start.parameter - here.parameter) / course.span > away:
            break
    return Arc(None, tuple(folds), iterations)


def path(family: Family, start: Solution, target: float, longest: float = 1.0) -> Iterator[ArcStep]:
    """Points of the path of solutions, from a converged one towards a parameter, without end."""
    here, length = start, min(0.2, longest)
    aim: Course | None = None
    came: Solution | None = None
    while True:
        tangent = tangent_at(family, here)
        if tangent is None:
            return
        aim = aim or _course(family, start, target, tangent)
        course = _measured_at(here, aim)
        if came is not None and _cosine(came, here, tangent, course) < BOUNCE:
            aim, course = (replace(each, constant=-each.constant) for each in (aim, course))
        along, rate = _arrow(tangent, course)
        plane = CuttingPlane(
            here.w, here.parameter, along * course.weight**2, rate / course.span**2
        )
        yield ArcStep(here, tangent, along, rate, plane)
        ahead, _ = _advance(family, here, tangent, course, length)
        if ahead is None:
            return
        came, (here, taken) = here, ahead
        length = min(taken * np.clip(3.5 / max(here.iterations, 1), 0.5, 2.0), longest)


@dataclass(frozen=True)
class Course:
    """Where a path is headed, `span` from its start, and how its length is measured.

    `weight` is of the coefficients of w, 1/m, `constant` sign(ṗ) sign det P of the path; the
    shortest step is in units of the span.
    """

    target: float
    span: float
    weight: Floats
    constant: float
    shortest: float


def _course(
    family: Family,
    start: Solution,
    target: float,
    tangent: Tangent,
    shortest: float = SHORTEST,
) -> Course:
    """The course from a point, where its tangent is known, to a value of the parameter."""
    span = target - start.parameter
    ends = [scales(family.at(p).linear) for p in (start.parameter, target)]
    constant = float(np.sign(span) * tangent.orientation)
    return Course(target, span, 1 / np.maximum(*ends), constant, shortest)


def _measured_at(here: Solution, course: Course) -> Course:
    """The course with w measured by what it is at a point, where that is more than when stuck."""
    if not here.w.any():
        return course
    return replace(course, weight=np.minimum(course.weight, 1 / scales(here.w)))


def _advance(
    family: Family,
    here: Solution,
    tangent: Tangent,
    course: Course,
    length: float,
) -> tuple[tuple[Solution, float] | None, int]:
    """The next point, its step halved until Newton converges; and the iterations spent.

    Where even the shortest step fails, a contact changes its state right here, and the path goes
    on in the direction that the other state gives it, which may be backwards.
    """
    spent = 0
    while True:
        found, iterations = _step(family, here, tangent, course, length)
        spent += iterations
        if found is not None:
            return (found, length), spent
        if length <= course.shortest:
            break
        length *= 0.5
    for push in (2.0, 8.0, 32.0):
        along, rate = _arrow(tangent, course)
        little = push * course.shortest
        w, parameter = here.w + little * along, here.parameter + little * rate
        balance = family.at(parameter)
        u = balance.displacement(w)
        deviation = family.law(parameter)(u, balance.omega)
        beyond = replace(here, w=w, parameter=parameter, u=u, deviation=deviation)
        turned = tangent_at(family, beyond)
        if turned is None:
            continue
        for length in (little, 4 * little):
            found, iterations = _step(family, here, turned, course, length)
            spent += iterations
            if found is not None:
                return (found, length), spent
    return None, spent


def _arrow(tangent: Tangent, course: Course) -> tuple[Floats, float]:
    """Unit vector along the path in the scaled space (w·weight, p/span), in physical units."""
    span = abs(course.span)
    size = np.hypot(np.linalg.norm(tangent.z * course.weight) * span, 1.0)
    rate = float(course.constant * tangent.orientation * span / size)
    return tangent.z * rate, rate


def _cosine(came: Solution, here: Solution, tangent: Tangent, course: Course) -> float:
    """Of the angle between a step and the direction in which the path goes on."""
    along, rate = _arrow(tangent, course)
    w, parameter = (here.w - came.w) * course.weight, (here.parameter - came.parameter)
    back = np.vdot(along * course.weight, w) + rate * parameter / course.span**2
    return float(back / np.hypot(np.linalg.norm(w), parameter / course.span))


def _step(
    family: Family,
    here: Solution,
    tangent: Tangent,
    course: Course,
    length: float,
) -> tuple[Solution | None, int]:
    """The point at a distance along the tangent, if Newton finds one near there."""
    along, rate = _arrow(tangent, course)
    w, parameter = here.w + length * along, here.parameter + length * rate
    weight, span = course.weight, course.span
    plane = CuttingPlane(w, parameter, along * weight**2, rate / span**2)
    found = solve(family, w, parameter, plane, ROUGH, 12, here.kept)
    moved = np.hypot(np.linalg.norm((found.w - w) * weight), (found.parameter - parameter) / span)
    # A path may bend by 45 degrees in a step, and sharply at a kink, which short steps single out.
    near = moved < length or moved < 3 * length < 0.25
    # Where the path leads away from the target, steps grow with the distance from there.
    far = max(abs(here.parameter - course.target), abs(span))
    jumped = abs(found.parameter - here.parameter) > 0.3 * far
    return found if found.converged and near and not jumped else None, found.iterations
