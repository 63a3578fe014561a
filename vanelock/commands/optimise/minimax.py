"""The smallest largest of several functions with gradients, within bounds.

Sequential quadratic programming (Powell; Vardi, "New minimax algorithm", J. Optim. Theory Appl. 75
(1992) 613): of functions f_j with gradients g_j at x, the step d solves

    minimise t + ½ dᵀ B d,      f_j + g_jᵀ d <= t,      within the bounds,      |d| <= Δ,

B an estimate of the curvature of Σ λ_j f_j (damped BFGS), λ the multipliers. Where the largest is
smooth this is a quasi-Newton method; where several are equal it goes along their ridge, without a
derivative that does not exist. Δ follows how well the steps are predicted.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize, nnls

from vanelock.common.arrays import Floats

WIDEST, FIRST, LEAST = 1.0, 0.5, 1e-4
"""Of the step: at most, at first, and where the search ends."""
NEARLY = 0.25
"""Of the predicted fall, what is less than expected."""
EQUAL = 1e-6
"""Relative difference of functions that bind alike."""


@dataclass(frozen=True)
class Functions:
    """Values of several functions at x, and their gradients.

    Attributes
    ----------
    value : (j,) float
    gradient : (j, p) float
    """

    value: Floats
    gradient: Floats

    @property
    def largest(self) -> float:
        """The largest value."""
        return float(self.value.max())


@dataclass(frozen=True)
class TriedPlace:
    """A place that was tried.

    Attributes
    ----------
    x : (p,) float
    largest : float
        Infinite where there is no value.
    """

    x: Floats
    largest: float


@dataclass(frozen=True)
class Minimax:
    """Where the largest of the functions is smallest.

    Attributes
    ----------
    x : (p,) float
    functions : Functions
        There.
    trials : tuple of TriedPlace
        All places, in their order.
    settled : bool
        Whether no step promised more than the tolerance.
    """

    x: Floats
    functions: Functions
    trials: tuple[TriedPlace, ...]
    settled: bool


def minimax(
    evaluate: Callable[[Floats], Functions | None],
    start: Floats,
    bounds: tuple[Floats, Floats],
    tolerance: float = 1e-4,
    most: int = 40,
) -> Minimax | None:
    """Find it from a start; None where there is no value at the start."""
    low, high = bounds
    x, here = np.asarray(start, float), evaluate(np.asarray(start, float))
    trials = [TriedPlace(x, np.inf if here is None else here.largest)]
    if here is None:
        return None
    B, reach = here.largest * np.eye(len(x)), FIRST
    settled = False
    while len(trials) < most:
        d, fall = _step(here, B, np.maximum(low - x, -reach), np.minimum(high - x, reach))
        if fall < tolerance * here.largest:
            settled = True
            break
        there = evaluate(x + d)
        trials.append(TriedPlace(x + d, np.inf if there is None else there.largest))
        gained = -np.inf if there is None else here.largest - there.largest
        length = float(np.abs(d).max())
        if there is not None:
            B = _updated(B, here, there, d)
        if gained > 0:
            assert there is not None
            x, here = x + d, there
        if gained > 3 * NEARLY * fall and length > 0.99 * reach:
            reach = min(2 * reach, WIDEST)
        elif gained < NEARLY * fall:
            reach = 0.4 * length
        if reach < LEAST:
            settled = True
            break
    return Minimax(x, here, tuple(trials), settled)


def _step(here: Functions, B: Floats, low: Floats, high: Floats) -> tuple[Floats, float]:
    """The step, and by how much the largest value falls as predicted."""
    top, p = here.largest, len(low)
    value, gradient = here.value / top - 1, here.gradient / top
    curve = B / top

    def model(z: Floats) -> float:
        return float(z[p] + 0.5 * z[:p] @ curve @ z[:p])

    found = minimize(
        model,
        np.zeros(p + 1),
        jac=lambda z: np.append(curve @ z[:p], 1.0),
        bounds=[*zip(low, high, strict=True), (None, None)],
        constraints={
            "type": "ineq",
            "fun": lambda z: z[p] - value - gradient @ z[:p],
            "jac": lambda z: np.column_stack([-gradient, np.ones(len(value))]),
        },
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 200},
    )
    d = np.clip(found.x[:p], low, high)
    reached = float((value + gradient @ d).max() + 0.5 * d @ curve @ d)
    return d, -top * reached


def _updated(B: Floats, here: Functions, there: Functions, d: Floats) -> Floats:
    """The curvature after a step, by damped BFGS; as it was where functions come and go."""
    count = len(here.value)
    if count != len(there.value):
        return B
    model = here.value + here.gradient @ d
    binds = np.flatnonzero(model > model.max() - EQUAL * here.largest)
    rows = np.vstack([here.gradient[binds].T, np.full(len(binds), here.largest)])
    weight = np.zeros(count)
    weight[binds] = nnls(rows, np.append(-B @ d, here.largest))[0]
    if not weight.sum() > 0:
        return B
    weight /= weight.sum()
    y, Bd = weight @ (there.gradient - here.gradient), B @ d
    curved = float(d @ Bd)
    if not curved > 0:
        return B
    share = 1.0
    if d @ y < 0.2 * curved:
        share = 0.8 * curved / (curved - float(d @ y))
    y = share * y + (1 - share) * Bd
    return np.asarray(B - np.outer(Bd, Bd) / curved + np.outer(y, y) / float(d @ y))
