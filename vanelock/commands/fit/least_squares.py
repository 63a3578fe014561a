"""Nonlinear least squares of a few parameters, with an honest account of what the data determine.

    minimise Σ ((model_i(θ) - data_i) / σ_i)²

over x = ln θ, or θ over its largest bound where that may be zero or negative. With the Jacobian J
of the weighted residuals at the solution, the covariance of x is s² (JᵀJ)⁻¹, s² = Σ r² / (n - p):
the scatter, estimated from what remains, where no σ is given. Where σ is given s is 1, or the same
estimate where that is larger, since a model that misses its data by more than their scatter cannot
be trusted to the scatter (the scale factor of the Particle Data Group, Review of Particle Physics,
section 5.2.2). The singular vectors of J show which products of powers of parameters the data
determine, and how well.

The covariance is worth something only if residuals are noise (`commands.fit.solution`) and the
model is linear as far as its own errors reach: Σ r² must rise by s² one standard error away along
each singular vector, which is evaluated.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from vanelock.commands.fit.parameters import (
    FitParameter,
    Progress,
    bounds_of,
    in_words,
    starts_of,
    values_of,
)
from vanelock.commands.fit.solution import UNDETERMINED, Direction, FitSolution, Start, noise_tests
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.common.tables import counted
from vanelock.pipeline.progress import Listener, Notice, silent

Predict = Callable[[Floats], Floats]
"""Model values (n,) at parameters θ (p,), or their (n, p) slopes θ dA/dθ; NaN where not known."""
STEP = 2e-4
"""Of x, for differences: forward on the way, to both sides for the errors. A modulus moves a peak
by half as much, a few hundredths of its width; responses are solved to 1e-10."""
STOP = 1e-5
"""Relative change of misfit or parameters at which a fit ends."""
MOST = 60
"""Steps of a fit."""
USUAL = 8
"""Of them, before any is known."""
UNKNOWN = 100.0
"""Standard error of x that stands for any larger one, and for none at all."""
LOST = 0.5
"""Share of points without a model value above which a trial is refused."""


def fit(
    predict: Predict,
    data: Floats,
    sigma: Floats,
    parameters: Sequence[FitParameter],
    starts: int = 1,
    sigma_known: bool = True,
    listener: Listener = silent,
    curves: Sequence[Sequence[str]] | None = None,
    slopes: Predict | None = None,
) -> FitSolution:
    """Fit parameters to data of standard deviations, or, not `sigma_known`, of about such sizes."""
    n, p = len(data), len(parameters)
    enough(n, p)
    unit, scale = (
        ("standard deviations", 1.0) if sigma_known else ("% of the largest amplitude", 100.0)
    )
    progress = Progress(listener, 0, "misfit", unit, scale)
    problem = _Problem(predict, slopes, data, sigma, tuple(parameters), sigma_known, progress)
    curves = curves or [[f"point {i + 1}" for i in range(n)]]
    found: list[tuple[Start, Floats]] = []
    for number, x in enumerate(problem.begins(starts), 1):
        begun = progress.trials
        problem.expect(starts - number + 1, [start.evaluations for start, _ in found])
        before, value = problem.misfit(x), values_of(parameters, x)
        start = Start(value, value, before, before, 0, 1)
        if np.isfinite(before):
            size = before * np.sqrt(n) or 1.0  # least_squares takes a small gradient for none
            run = least_squares(
                lambda x, size=size: problem.residuals(x) / size,
                x,
                lambda x, size=size: problem.jacobian(x) / size,
                problem.bounds,
                x_scale=1.0,
                xtol=STOP,
                ftol=STOP,
                max_nfev=MOST,
            )
            ends = values_of(parameters, run.x), before, problem.misfit(run.x)
            start = Start(value, *ends, int(run.nfev), progress.trials - begun)
            found.append((start, run.x))
        where = in_words(parameters, value)
        done = f"{counted(start.steps, 'step')}, {counted(start.evaluations, 'response')}"
        misfits = f"misfit {start.before:.3g} to {start.after:.3g}"
        listener(Notice(f"start {number} of {starts} ({where}): {misfits}, {done}"))
    if not found:
        raise InputError("fit: the model has no solution at any start: change the start or bounds")
    best = min(found, key=lambda pair: pair[0].after)[1]
    problem.expect(0, [])
    return _assessed(problem, best, curves, tuple(start for start, _ in found))


def enough(points: int, parameters: int) -> None:
    """Refuse fewer points than determine parameters and a scatter."""
    if points <= parameters:
        raise InputError(
            f"fit: {points} measured points for {parameters} parameters: more are needed"
        )


@dataclass
class _Problem:
    """Weighted residuals and their derivatives by x."""

    predict: Predict
    slopes: Predict | None
    data: Floats
    sigma: Floats
    parameters: tuple[FitParameter, ...]
    sigma_known: bool
    progress: Progress
    _known: dict[bytes, Floats] = field(default_factory=dict)
    _sloped: dict[bytes, Floats] = field(default_factory=dict)

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """(p,) lowest and highest x."""
        return bounds_of(self.parameters)

    def model(self, x: Floats) -> Floats:
        """Model values, NaN where there are none."""
        key = np.asarray(x).tobytes()
        if key not in self._known:
            self._known[key] = np.asarray(self.predict(values_of(self.parameters, x)), float)
            self.progress.tried(self.misfit(x))
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
        """(n, p) derivatives of the residuals; 0 where there is none.

        By the model's slopes, else by differences, forward or `central`.
        """
        base, columns, known = self.model(x), [], self._slopes(x)
        for i in range(len(x)):
            if np.isfinite(known[:, i]).any():
                columns.append(np.nan_to_num(known[:, i] / self.sigma))
                continue
            step = np.zeros(len(x))
            step[i] = STEP if x[i] + STEP <= self.bounds[1][i] else -STEP
            other = x - step if central else x
            behind = self.model(other) if central and self.allowed(other) else base
            span = step[i] if behind is base else 2 * step[i]
            columns.append(np.nan_to_num((self.model(x + step) - behind) / span / self.sigma))
        return np.column_stack(columns)

    def _slopes(self, x: Floats) -> Floats:
        """(n, p) derivatives of model values by x; NaN where they are not known."""
        if self.slopes is None:
            return np.full((len(self.data), len(x)), np.nan)
        key = np.asarray(x).tobytes()
        if key not in self._sloped:
            values = values_of(self.parameters, x)
            stretch = [q.stretch(float(v)) for q, v in zip(self.parameters, values, strict=True)]
            self._sloped[key] = np.asarray(self.slopes(values) * stretch)
        return self._sloped[key]

    def expect(self, starts: int, counts: Sequence[int]) -> None:
        """Estimate evaluations: of so many more starts like those known, and of the errors."""
        p = len(self.parameters)
        usual = float(np.mean(counts)) if counts else USUAL * (1 if self.slopes else 1 + p)
        self.progress.likely = self.progress.trials + round(starts * usual) + 2 * p

    def allowed(self, x: Floats) -> bool:
        """Whether it lies within the bounds."""
        return bool(np.all(x >= self.bounds[0]) and np.all(x <= self.bounds[1]))

    def begins(self, count: int) -> list[Floats]:
        """The parameters' own starts, and the best of points spread over the bounds."""
        low, high = self.bounds
        own = starts_of(self.parameters).clip(low, high)
        if count < 2:
            return [own]
        exponent = int(np.ceil(np.log2(2 * count + 2 * len(own))))
        spread = qmc.Sobol(len(own), seed=1).random_base2(exponent)
        self.expect(count, [])
        self.progress.likely += len(spread)
        tried = low + (high - low) * spread
        order = np.argsort([self.misfit(x) for x in tried], kind="stable")
        return [own, *tried[order[: count - 1]]]


def _assessed(
    problem: _Problem,
    x: Floats,
    curves: Sequence[Sequence[str]],
    starts: tuple[Start, ...],
) -> FitSolution:
    """Errors and correlations at a solution, and whether they hold."""
    J, lost = problem.jacobian(x, central=True), np.isnan(problem.model(x))
    sigma_known = problem.sigma_known
    n, p = int(np.sum(~lost)), len(x)
    left = problem.residuals(x)[~lost]
    square = float(left @ left) / max(n - p, 1)
    scale = max(1.0, np.sqrt(square)) if sigma_known else float(np.sqrt(square))
    _, singular, Vh = np.linalg.svd(J, full_matrices=False)
    spread = np.minimum(scale / np.maximum(singular, np.finfo(float).tiny), UNKNOWN)
    covariance = (Vh.T * spread**2) @ Vh
    deviation = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(deviation, deviation)
    ends = np.cumsum([len(names) for names in curves])
    lengths = [int(np.sum(~each)) for each in np.split(lost, ends[:-1])]
    named = [name for curve in curves for name in curve]
    names = [name for name, gone in zip(named, lost, strict=True) if not gone]
    directions = tuple(
        Direction(v * np.sign(v[np.argmax(np.abs(v))]), float(each))
        for v, each in zip(Vh, spread, strict=True)
    )
    return FitSolution(
        parameters=problem.parameters,
        value=values_of(problem.parameters, x),
        deviation=deviation,
        correlation=np.nan_to_num(correlation),
        directions=directions,
        before=problem.misfit(starts_of(problem.parameters)),
        after=problem.misfit(x),
        sigma_known=sigma_known,
        scale=float(scale),
        points=n,
        lost=int(lost.sum()),
        tests=noise_tests(left, J[~lost], lengths, sigma_known, names),
        rises=tuple(_rises(problem, x, each, float(scale)) for each in directions),
        starts=starts,
    )


def _rises(problem: _Problem, x: Floats, way: Direction, scale: float) -> tuple[float, ...]:
    """Of the squared misfit over s², a standard error down and up a direction, within bounds."""
    if way.deviation > UNDETERMINED:
        return ()
    step = way.deviation * way.along
    base = float(np.sum(problem.residuals(x) ** 2))
    ends = [end for end in (x - step, x + step) if problem.allowed(end)]
    floor = max(scale**2, np.finfo(float).tiny)
    return tuple(float(np.sum(problem.residuals(end) ** 2) - base) / floor for end in ends)
