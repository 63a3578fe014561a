"""Nonlinear least squares of a few parameters, with an honest account of what the data determine.

    minimise Σ ((model_i(θ) - data_i) / σ_i)²

over x = ln θ, or θ over its largest bound where that may be zero or negative. With the Jacobian J
of the weighted residuals at the solution, the covariance of x is s² (JᵀJ)⁻¹, s² = Σ r² / (n - p):
the scatter, estimated from what remains, where no σ is given. Where σ is given s is 1, or the same
estimate where that is larger, since a model that misses its data by more than their scatter cannot
be trusted to the scatter (the scale factor of the Particle Data Group, Review of Particle Physics,
section 5.2.2). The singular vectors of J tell which products of powers of parameters the data
determine, and how well.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc

from vanelock.errors import InputError

Floats = NDArray[np.float64]
Predict = Callable[[Floats], Floats]
"""Model values (n,) at parameters θ (p,); NaN where there is none."""

STEP = 2e-4
"""Of x, for differences: forward on the way, to both sides for the errors. A modulus moves a peak
by half as much, a few hundredths of its width; responses are solved to 1e-10."""
STOP = 1e-5
"""Relative change of misfit or parameters at which a fit ends."""
MOST = 60
"""Steps of a fit."""
UNDETERMINED = 0.3
"""Standard error of x along a direction above which the data are said not to determine it."""
UNKNOWN = 100.0
"""Standard error of x that stands for any larger one, and for none at all."""
BOUND = 1e-2
"""Of the range: closer to a bound a parameter is said to be held by it."""
APART = 0.1
"""Difference of x beyond which two fits are not the same."""
LOST = 0.5
"""Share of points without a model value above which a trial is refused."""


@dataclass(frozen=True)
class Parameter:
    """What is fitted: its key, where it begins, its bounds."""

    key: str
    start: float
    low: float
    high: float

    @property
    def logarithmic(self) -> bool:
        """Whether x is its logarithm."""
        return self.low > 0

    def inner(self, value: float) -> float:
        """The x of a value."""
        return float(np.log(value)) if self.logarithmic else value / self._unit

    def outer(self, x: float) -> float:
        """Value of an x."""
        return float(np.exp(x)) if self.logarithmic else x * self._unit

    @property
    def _unit(self) -> float:
        return max(abs(self.low), abs(self.high))


@dataclass(frozen=True)
class Direction:
    """A direction of the parameters and how well the data determine it.

    Attributes
    ----------
    along : (p,) float
        Unit vector in x: the exponents of a product of powers.
    deviation : float
        Standard error of x along it.
    """

    along: Floats
    deviation: float


@dataclass(frozen=True)
class Start:
    """Where a fit began and ended: misfits, number of steps and of model evaluations."""

    value: Floats
    found: Floats
    before: float
    after: float
    steps: int
    evaluations: int


@dataclass(frozen=True)
class Solution:
    """The best fit.

    Attributes
    ----------
    parameters : tuple of Parameter
    value : (p,) float
        Fitted values.
    deviation : (p,) float
        Standard error of x: relative where x is a logarithm; 100 where nothing determines it.
    correlation : (p, p) float
        Between the parameters' x.
    directions : tuple of Direction
        From the best determined to the worst.
    before, after : float
        Root mean square of the weighted residuals at the start, and at the solution.
    given : bool
        Whether the data had standard deviations.
    scale : float
        s, by which errors from the given σ were multiplied; the scatter itself without σ.
    held : tuple of bool
        Whether each parameter lies on a bound.
    points : int
        Points n that have a model value.
    lost : int
        Points at which the model had no value at the solution.
    starts : tuple of Start
        All attempts.
    """

    parameters: tuple[Parameter, ...]
    value: Floats
    deviation: Floats
    correlation: Floats
    directions: tuple[Direction, ...]
    before: float
    after: float
    given: bool
    scale: float
    held: tuple[bool, ...]
    points: int
    lost: int
    starts: tuple[Start, ...]

    def interval(self, place: int) -> tuple[float, float]:
        """Two standard errors below and above a fitted value."""
        parameter, x = self.parameters[place], self.parameters[place].inner(self.value[place])
        spread = 2 * float(self.deviation[place])
        return parameter.outer(x - spread), parameter.outer(x + spread)

    def rivals(self) -> tuple[Start, ...]:
        """Attempts that ended elsewhere and meet the data as well, within two standard errors."""
        best = self._inner(self.value)
        found = []
        for start in self.starts:
            worse = self.points * (start.after**2 - self.after**2)
            elsewhere = np.abs(self._inner(start.found) - best).max() > APART
            if elsewhere and worse <= 4 * self.scale**2:
                found.append(start)
        return tuple(found)

    def _inner(self, values: Floats) -> Floats:
        pairs = zip(self.parameters, values, strict=True)
        return np.array([parameter.inner(float(value)) for parameter, value in pairs])

    @property
    def undetermined(self) -> tuple[Direction, ...]:
        """Directions that the data do not determine."""
        return tuple(each for each in self.directions if each.deviation > UNDETERMINED)


def fit(
    predict: Predict,
    data: Floats,
    sigma: Floats | None,
    parameters: Sequence[Parameter],
    starts: int = 1,
    weights: Floats | None = None,
    told: Callable[[int, Start], None] = lambda number, start: None,
) -> Solution:
    """Fit parameters to data.

    Parameters
    ----------
    predict : callable
        The model.
    data : (n,) float
        What it is to meet.
    sigma : (n,) float or None
        Standard deviations; None: unknown.
    parameters : sequence of Parameter
        What varies.
    starts : int
        The first at the parameters' own starts, the others at the best of several points spread
        over the bounds.
    weights : (n,) float, optional
        Without `sigma`: what stands in its place, up to a factor.
    told : callable
        Told of each start when it has ended.

    Raises
    ------
    InputError
        If there are fewer points than parameters, or the model has no value at any start.
    """
    n, p = len(data), len(parameters)
    enough(n, p)
    spread = np.asarray(sigma if sigma is not None else np.ones(n) if weights is None else weights)
    problem = _Problem(predict, data, spread, tuple(parameters))
    found: list[tuple[Start, Floats]] = []
    for number, x in enumerate(problem.begins(starts), 1):
        begun = problem.evaluations
        before = problem.misfit(x)
        if not np.isfinite(before):
            told(number, Start(problem.outer(x), problem.outer(x), before, before, 0, 1))
            continue
        run = least_squares(
            problem.residuals,
            x,
            problem.jacobian,
            problem.bounds,
            x_scale=1.0,
            xtol=STOP,
            ftol=STOP,
            gtol=1e-10,
            max_nfev=MOST,
        )
        after = problem.misfit(run.x)
        used = problem.evaluations - begun
        ended = problem.outer(run.x)
        start = Start(problem.outer(x), ended, before, after, int(run.nfev), used)
        told(number, start)
        found.append((start, run.x))
    if not found:
        raise InputError("fit: the model has no solution at any start: change the start or bounds")
    best = min(found, key=lambda each: each[0].after)[1]
    return _judged(problem, best, sigma is not None, tuple(start for start, _ in found))


def enough(points: int, parameters: int) -> None:
    """Refuse fewer points than determine parameters and a scatter.

    Raises
    ------
    InputError
        Telling both numbers.
    """
    if points <= parameters:
        raise InputError(
            f"fit: {points} measured points for {parameters} parameters: more are needed"
        )


class _Problem:
    """Weighted residuals and their derivatives by x."""

    def __init__(
        self, predict: Predict, data: Floats, sigma: Floats, parameters: tuple[Parameter, ...]
    ) -> None:
        self.predict, self.data, self.sigma, self.parameters = predict, data, sigma, parameters
        self.evaluations = 0
        self._known: dict[bytes, Floats] = {}
        low = [each.inner(each.low) for each in parameters]
        high = [each.inner(each.high) for each in parameters]
        self.bounds = np.array(low), np.array(high)

    def outer(self, x: Floats) -> Floats:
        """θ of x."""
        pairs = zip(self.parameters, x, strict=True)
        return np.array([parameter.outer(float(each)) for parameter, each in pairs])

    def model(self, x: Floats) -> Floats:
        """Model values, NaN where there are none."""
        key = np.asarray(x).tobytes()
        if key not in self._known:
            self.evaluations += 1
            self._known[key] = np.asarray(self.predict(self.outer(x)), float)
        return self._known[key]

    def residuals(self, x: Floats) -> Floats:
        """Weighted residuals; all huge where the model mostly has no value.

        A point without a value counts as the worst one that has: losing points must not pay.
        """
        left = (self.model(x) - self.data) / self.sigma
        lost = np.isnan(left)
        if lost.mean() > LOST:
            return np.full(len(left), 1e3 * float(np.abs(self.data / self.sigma).max()))
        return np.where(lost, np.abs(left[~lost]).max(), left) if lost.any() else left

    def misfit(self, x: Floats) -> float:
        """Root mean square of the weighted residuals; infinite where most have no value."""
        if np.isnan(self.model(x)).mean() > LOST:
            return float("inf")
        return float(np.sqrt(np.mean(self.residuals(x) ** 2)))

    def jacobian(self, x: Floats, central: bool = False) -> Floats:
        """(n, p) derivatives of the residuals; 0 where either has no value."""
        base, columns = self.model(x), []
        for i in range(len(x)):
            step = np.zeros(len(x))
            step[i] = STEP if x[i] + STEP <= self.bounds[1][i] else -STEP
            other = x - step if central else x
            behind = self.model(other) if central and self._allowed(other) else base
            span = step[i] if behind is base else 2 * step[i]
            columns.append(np.nan_to_num((self.model(x + step) - behind) / span / self.sigma))
        return np.column_stack(columns)

    def _allowed(self, x: Floats) -> bool:
        return bool(np.all(x >= self.bounds[0]) and np.all(x <= self.bounds[1]))

    def begins(self, count: int) -> list[Floats]:
        """The parameters' own starts, and the best of points spread over the bounds."""
        low, high = self.bounds
        own = np.array([each.inner(each.start) for each in self.parameters]).clip(low, high)
        if count < 2:
            return [own]
        exponent = int(np.ceil(np.log2(2 * count + 2 * len(own))))
        spread = qmc.Sobol(len(own), seed=1).random_base2(exponent)
        tried = low + (high - low) * spread
        order = np.argsort([self.misfit(x) for x in tried], kind="stable")
        return [own, *tried[order[: count - 1]]]


def _judged(problem: _Problem, x: Floats, known: bool, starts: tuple[Start, ...]) -> Solution:
    """Errors and correlations at a solution."""
    J, lost = problem.jacobian(x, central=True), np.isnan(problem.model(x))
    n, p = int(np.sum(~lost)), len(x)
    square = float(np.sum(problem.residuals(x)[~lost] ** 2)) / max(n - p, 1)
    scale = max(1.0, np.sqrt(square)) if known else float(np.sqrt(square))
    _, singular, Vh = np.linalg.svd(J, full_matrices=False)
    spread = np.minimum(scale / np.maximum(singular, np.finfo(float).tiny), UNKNOWN)
    covariance = (Vh.T * spread**2) @ Vh
    deviation = np.sqrt(np.diag(covariance))
    low, high = problem.bounds
    margin = BOUND * (high - low)
    held = tuple((x < low + margin) | (x > high - margin))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(deviation, deviation)
    own = np.array([each.start for each in problem.parameters])
    return Solution(
        parameters=problem.parameters,
        value=problem.outer(x),
        deviation=deviation,
        correlation=np.nan_to_num(correlation),
        directions=tuple(
            Direction(_pointed(v), float(each)) for v, each in zip(Vh, spread, strict=True)
        ),
        before=problem.misfit(
            np.array([q.inner(v) for q, v in zip(problem.parameters, own, strict=True)])
        ),
        after=problem.misfit(x),
        given=known,
        scale=float(scale),
        held=tuple(bool(each) for each in held),
        points=n,
        lost=int(lost.sum()),
        starts=starts,
    )


def _pointed(v: Floats) -> Floats:
    """The direction with its largest component positive."""
    return np.asarray(v * np.sign(v[np.argmax(np.abs(v))]))
