"""Arc length: follow a path of solutions, through folds, to a given value of its parameter.

The tangent (z, 1) solves P z = (dW/du) du/dp. Its direction along the path follows from
sign(ṗ) · sign det P = const, which holds through folds and, unlike the angle with the last
tangent, across the kinks of the law.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.nonlinear.law import Law
from vanelock.nonlinear.newton import (
    TOLERANCE,
    Family,
    Plane,
    Solution,
    active_rows,
    newton_matrix,
    response_to,
    scales,
    solve,
)

Floats = NDArray[np.float64]

ROUGH = 1e-7  # residual of the points on the way
SHORTEST = 2e-3


@dataclass(frozen=True)
class Arc:
    """Where a path led.

    Attributes
    ----------
    solution : Solution or None
        The state at the target, None if the path did not get there.
    folds : tuple of float
        Parameters at which the path turned back.
    steps : int
    iterations : int
    """

    solution: Solution | None
    folds: tuple[float, ...]
    steps: int
    iterations: int


@dataclass(frozen=True)
class _Tangent:
    """dw/dp and the sign of det P at a point of the path."""

    z: Floats
    orientation: float


def _tangent(family: Family, law: Law, point: Solution) -> _Tangent | None:
    balance = family.at(point.parameter)
    rows = active_rows(point.w, point.deviation)
    z = np.zeros(point.w.size)
    if not len(rows):
        return _Tangent(z.reshape(point.w.shape), 1.0)
    matrix = newton_matrix(balance, point.deviation, rows)
    factors, pivots = la.lu_factor(matrix, check_finite=False)
    diagonal = np.diagonal(factors)
    if not np.all(np.isfinite(diagonal)) or not np.all(diagonal):
        return None
    swaps = np.count_nonzero(pivots != np.arange(len(pivots)))
    sign = np.prod(np.sign(diagonal)) * (-1.0) ** swaps
    rates = response_to(point.deviation, rows, family.slope(point.parameter, point.w))
    z[rows] = la.lu_solve((factors, pivots), rates, check_finite=False)
    return _Tangent(z.reshape(point.w.shape), float(sign))


def follow(
    family: Family,
    law: Law,
    start: Solution,
    target: float,
    tolerance: float = TOLERANCE,
    limit: int = 200,
) -> Arc:
    """Follow the path of solutions from a converged point until the parameter passes `target`.

    Parameters
    ----------
    family : Family
    law : Law
    start : Solution
        Converged, at another value of the parameter.
    target : float
        Value of the parameter wanted.
    tolerance : float
        Relative residual at the target.
    limit : int
        Most points of the path.
    """
    span = target - start.parameter
    weight = 1 / scales(family.at(start.parameter).linear)
    here, folds, iterations = start, [], 0
    length, constant, last_sign = 0.2, 0.0, np.sign(span)
    for step in range(limit):
        tangent = _tangent(family, law, here)
        if tangent is None:
            break
        if constant == 0.0:
            constant = np.sign(span) * tangent.orientation
        sign = constant * tangent.orientation
        if sign != last_sign:
            folds.append(here.parameter)
            last_sign = sign
        # In the scaled space (w/scale, p/span) the tangent has length one.
        size = np.hypot(np.linalg.norm(tangent.z * weight) * abs(span), 1.0)
        rate = sign * abs(span) / size
        ahead, spent = _advance(family, law, here, tangent.z, rate, length, weight, span)
        iterations += spent
        if ahead is None:
            break
        following, taken = ahead
        length = taken * np.clip(3.5 / max(following.iterations, 1), 0.5, 2.0)
        if (following.parameter - target) * np.sign(span) >= 0:
            ratio = (target - here.parameter) / (following.parameter - here.parameter)
            for begin in (here.w + ratio * (following.w - here.w), following.w, here.w):
                landed = solve(family, law, begin, target, tolerance=tolerance)
                iterations += landed.iterations
                if landed.converged:
                    landed = replace(landed, iterations=iterations)
                    return Arc(landed, tuple(folds), step + 1, iterations)
            if taken < 4 * SHORTEST:
                break
            length = 0.25 * taken  # come closer before landing
            continue
        here = following
    return Arc(None, tuple(folds), step + 1, iterations)


def _advance(
    family: Family,
    law: Law,
    here: Solution,
    z: Floats,
    rate: float,
    length: float,
    weight: Floats,
    span: float,
) -> tuple[tuple[Solution, float] | None, int]:
    """The next point, its step halved until Newton converges; and the iterations spent."""
    spent = 0
    normal = (z * weight**2 * rate, rate / span**2)
    while True:
        w, parameter = here.w + length * rate * z, here.parameter + length * rate
        plane = Plane(w, parameter, *normal)
        found = solve(family, law, w, parameter, plane, ROUGH, 12)
        spent += found.iterations
        moved = np.hypot(
            np.linalg.norm((found.w - w) * weight), (found.parameter - parameter) / span
        )
        if found.converged and moved < max(length, 10 * SHORTEST):
            return (found, length), spent
        if length <= SHORTEST:
            return None, spent
        length *= 0.5
