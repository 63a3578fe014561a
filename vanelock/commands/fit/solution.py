"""What a fit varies, and what it found: values, errors, and whether they can be believed."""

from dataclasses import dataclass

import numpy as np

from vanelock.commands.fit.parameters import FitParameter
from vanelock.commands.fit.residuals import NoiseTest
from vanelock.common.arrays import Floats

UNDETERMINED = 0.3
"""Standard error of x along a direction above which the data are said not to determine it."""
APART = 0.1
"""Difference of x beyond which two fits are not the same."""
RISE = 0.676
"""Of the rise s² of the squared misfit that linear theory has at one standard error: with less, two
standard errors hold the truth in fewer than 90 of 100 cases, (1.645 / 2)², rather than in 95."""


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
    given: bool
    scale: float
    held: tuple[bool, ...]
    points: int
    lost: int
    tests: tuple[NoiseTest, ...]
    rises: tuple[tuple[float, ...], ...]
    starts: tuple[Start, ...]
    remarks: tuple[str, ...] = ()

    def interval(self, place: int) -> tuple[float, float]:
        """Two standard errors below and above a fitted value, and about any fit that is as good."""
        parameter, spread = self.parameters[place], 2 * float(self.deviation[place])
        values = [self.value, *(start.found for start in self.as_good())]
        x = [parameter.inner(float(each[place])) for each in values]
        return parameter.outer(min(x) - spread), parameter.outer(max(x) + spread)

    @property
    def missed(self) -> tuple[NoiseTest, ...]:
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
