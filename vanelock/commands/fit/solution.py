"""What a fit varies, and what it found: values, errors, and whether they can be believed.

Whether what remains of a fit is noise: tests of significance on its residuals.

Least squares and its standard errors hold if residuals are independent, of one variance after
weighting, and normal. Four tests say where they are not:

- *signs*: of points next to each other each has the other's sign or not with probability 1/2, so
  that the number of changes is binomial (R. C. Geary, Biometrika 57, 1970);
- *neighbours*: Σ (r_{i+1} - r_i)² / Σ r², the scatter between neighbours over the misfit, which is
  near 2 for noise (J. von Neumann, Ann. Math. Stat. 12, 1941; Durbin and Watson, Biometrika 37,
  1950), by its own distribution: that of residuals (I - J J⁺) ε of normal ε;
- *largest*: the externally studentised residual, of Student's distribution with n - p - 1 degrees,
  among n by Bonferroni (Cook and Weisberg, Residuals and Influence in Regression, 1982, ch. 2);
- *size*, where σ is given: Σ r² is that of χ² with n - p degrees.

Each is made at `LEVEL` over their number, so that at most that share of right models is accused.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import binom, chi2, t

from vanelock.commands.fit.parameters import FitParameter, on_bounds, x_of
from vanelock.common.arrays import Booleans, Floats
from vanelock.common.tables import counted

LEVEL = 0.05
"""Share of fits of a right model to noise that all tests together call a miss, at most."""
DRAWS = 9999
"""Of noise, for the distribution of the neighbours' ratio: p to 2e-3 at a hundredth."""
SINGLE = 1e-6
"""Of 1 less a point's leverage, below which only this point determines a direction."""


class _NoiseTest(NamedTuple):
    """A test of residuals: what is tested, how probable by noise alone, the finding in words."""

    name: str
    statistic: float
    p: float
    text: str
    failed: bool = False


def noise_tests(
    left: Floats, J: Floats, lengths: Sequence[int], sigma_known: bool, names: Sequence[str]
) -> tuple[_NoiseTest, ...]:
    """Test residuals for being noise."""
    n, p = J.shape
    # Given σ, what remains can move a value by its norm in standard errors: by less than one here.
    if n - p < 2 or np.linalg.norm(left) <= (1.0 if sigma_known else np.finfo(float).eps):
        return ()
    near = np.diff(np.repeat(np.arange(len(lengths)), lengths)) == 0
    span = np.linalg.svd(J, full_matrices=False)[0][:, : np.linalg.matrix_rank(J)]
    found = [_signs(left, near, names), _neighbours(left, near, span), _largest(left, span, names)]
    if sigma_known:
        square = float(left @ left)
        misfit = np.sqrt(square / (n - p))
        text = f"by {misfit:.3g} times their standard deviations"
        found.append(_NoiseTest("size", square, float(chi2.sf(square, n - p)), text))
    return tuple(each._replace(failed=each.p < LEVEL / len(found)) for each in found)


def _signs(left: Floats, near: Booleans, names: Sequence[str]) -> _NoiseTest:
    positive = left > 0
    changes = int(np.sum((positive[1:] != positive[:-1]) & near))
    ends = np.flatnonzero(np.concatenate([[True], (positive[1:] != positive[:-1]) | ~near, [True]]))
    first = ends[np.argmax(np.diff(ends))]
    last = first + np.diff(ends).max() - 1
    text = (
        f"residuals change sign {counted(changes, 'time')} between {near.sum()} neighbours, "
        f"and keep it from {names[first]} to {names[last]}"
    )
    return _NoiseTest("signs", float(changes), float(binom.cdf(changes, near.sum(), 0.5)), text)


def _neighbours(left: Floats, near: Booleans, span: Floats) -> _NoiseTest:
    def ratio(r: Floats) -> Floats:
        square = np.sum(np.diff(r, axis=0)[near] ** 2, axis=0) / np.sum(r**2, axis=0)
        return np.asarray(square)

    noise = np.random.default_rng(1).standard_normal((len(left), DRAWS))
    own = float(ratio(left))
    below = np.sum(ratio(noise - span @ (span.T @ noise)) <= own)
    scatter = np.sqrt(np.mean(np.diff(left)[near] ** 2) / 2)
    times = float(np.sqrt(np.mean(left**2)) / scatter)
    text = f"residuals are {times:.2g} times as large as the scatter between neighbours"
    return _NoiseTest("neighbours", own, float((1 + below) / (1 + DRAWS)), text)


def _largest(left: Floats, span: Floats, names: Sequence[str]) -> _NoiseTest:
    n, p = span.shape
    free = 1 - np.sum(span**2, axis=1)
    others = left @ left - left**2 / np.maximum(free, SINGLE)
    student = np.abs(left) * np.sqrt((n - p - 1) / np.maximum(others * free, np.finfo(float).tiny))
    student[free < SINGLE] = 0
    worst = int(np.argmax(student))
    chance = min(1.0, 2 * n * float(t.sf(student[worst], n - p - 1)))
    text = (
        f"at {names[worst]} the residual is {student[worst]:.3g} standard deviations of the others "
        "(a jump of the response, an outlier, or scatter that grows with amplitude: give sigma)"
    )
    return _NoiseTest("largest", float(student[worst]), chance, text)


BOUND = 1e-2
"""Of the range: closer to a bound a parameter is said to be held by it."""
UNDETERMINED = 0.3
"""Standard error of x along a direction above which the data are said not to determine it."""
APART = 0.1
"""Difference of x beyond which two fits are not the same."""
RISE = 0.676
"""Of the rise s² of the squared misfit that linear theory has at one standard error: with less, two
standard errors hold the truth in fewer than 90 of 100 cases, (1.645 / 2)², rather than in 95."""


class Direction(NamedTuple):
    """A unit vector (p,) in x, exponents of a product of powers; the standard error along it."""

    along: Floats
    deviation: float


class Start(NamedTuple):
    """Where a fit began and ended: misfits, number of steps and of model evaluations."""

    value: Floats
    fitted: Floats
    before: float
    after: float
    steps: int
    evaluations: int


@dataclass(frozen=True)
class FitSolution:
    """The best fit.

    Attributes
    ----------
    parameters : tuple of FitParameter
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
    sigma_known : bool
        Whether the data had standard deviations.
    scale : float
        s, by which errors from the given σ were multiplied; the scatter itself without σ.
    points : int
        Points n that have a model value.
    lost : int
        Points at which the model had no value at the solution.
    tests : tuple of NoiseTest
        Whether residuals are noise.
    rises : tuple of tuple of float
        Of the squared misfit, over `scale`², one standard error down and up each direction: 1 in
        linear theory. Empty for what is not determined; one value next to a bound.
    starts : tuple of Start
        All attempts.
    remarks : tuple of str
        What the model at the solution says against it: jumps among the points, too few harmonics.
    """

    parameters: tuple[FitParameter, ...]
    value: Floats
    deviation: Floats
    correlation: Floats
    directions: tuple[Direction, ...]
    before: float
    after: float
    sigma_known: bool
    scale: float
    points: int
    lost: int
    tests: tuple[_NoiseTest, ...]
    rises: tuple[tuple[float, ...], ...]
    starts: tuple[Start, ...]
    remarks: tuple[str, ...] = ()

    def interval(self, index: int) -> tuple[float, float]:
        """Two standard errors below and above a fitted value, and about any fit that is as good."""
        parameter, spread = self.parameters[index], 2 * float(self.deviation[index])
        values = [self.value, *(start.fitted for start in self.as_good())]
        x = [parameter.inner(float(each[index])) for each in values]
        return parameter.outer(min(x) - spread), parameter.outer(max(x) + spread)

    @property
    def held(self) -> tuple[bool, ...]:
        """Whether each parameter lies on a bound."""
        return on_bounds(self.parameters, self.value, BOUND)

    @property
    def missed(self) -> tuple[_NoiseTest, ...]:
        """Tests by which the model misses the data."""
        return tuple(each for each in self.tests if each.failed)

    @property
    def flat(self) -> tuple[int, ...]:
        """Directions along which the misfit rises by less than linear theory says."""
        return tuple(i for i, each in enumerate(self.rises) if min(each, default=1.0) < RISE)

    @property
    def carried(self) -> bool:
        """Whether linear theory carries the standard errors."""
        return not self.missed and not self.flat

    def as_good(self) -> tuple[Start, ...]:
        """Attempts that ended elsewhere and meet the data as well, within two standard errors."""
        best = x_of(self.parameters, self.value)
        found = []
        for start in self.starts:
            worse = self.points * (start.after**2 - self.after**2)
            elsewhere = np.abs(x_of(self.parameters, start.fitted) - best).max() > APART
            if elsewhere and worse <= 4 * self.scale**2:
                found.append(start)
        return tuple(found)

    @property
    def undetermined(self) -> tuple[Direction, ...]:
        """Directions that the data do not determine."""
        return tuple(each for each in self.directions if each.deviation > UNDETERMINED)
