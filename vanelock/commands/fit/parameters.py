"""What a fit varies: keys of a study, where each begins, and between which bounds.

Apart from the fit itself, so that checking a study need not load it.
"""

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydantic import ValidationError

from vanelock.common.arrays import Floats
from vanelock.common.checked import explain
from vanelock.common.errors import InputError
from vanelock.input.cases.values import value_at, with_values
from vanelock.input.schema.comparison import Varied
from vanelock.input.schema.study import Study
from vanelock.pipeline.progress import Listener, Trial

DECADE = 10.0
"""Bounds unless the study gives any: the study's value over and times this."""
UNITS = {"kn": "N/m", "kt": "N/m", "interference": "m", "force": "N", "E": "Pa"}


@dataclass(frozen=True)
class FitParameter:
    """What is fitted: its key, where it begins, its bounds."""

    key: str
    start: float
    low: float
    high: float

    @property
    def name(self) -> str:
        """Its key as tables show it."""
        return self.key.removeprefix("joints.").removeprefix("excitation.")

    @property
    def unit(self) -> str:
        """That of its values."""
        return UNITS.get(self.key.rpartition(".")[2], "-")

    @property
    def span(self) -> str:
        """Its bounds in words."""
        return f"{self.low:.3g} to {self.high:.3g}"

    def record(self, value: float) -> dict[str, Any]:
        """A value for machines, and what it is of."""
        bounds = [self.low, self.high]
        return {"key": self.key, "start": self.start, "bounds": bounds, "value": float(value)}

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

    def stretch(self, value: float) -> float:
        """D ln θ / dx at a value: what θ dA/dθ is multiplied by; NaN at θ = 0."""
        if self.logarithmic:
            return 1.0
        return self._unit / value if value else float("nan")

    @property
    def _unit(self) -> float:
        return max(abs(self.low), abs(self.high))


def x_of(parameters: Sequence[FitParameter], values: Iterable[float]) -> Floats:
    """(p,) x of values."""
    return np.array([each.inner(float(v)) for each, v in zip(parameters, values, strict=True)])


def values_of(parameters: Sequence[FitParameter], x: Iterable[float]) -> Floats:
    """(p,) values of x."""
    return np.array([each.outer(float(v)) for each, v in zip(parameters, x, strict=True)])


def starts_of(parameters: Sequence[FitParameter]) -> Floats:
    """(p,) x where they begin."""
    return x_of(parameters, (each.start for each in parameters))


def bounds_of(parameters: Sequence[FitParameter]) -> tuple[Floats, Floats]:
    """(p,) lowest and highest x."""
    low, high = (each.low for each in parameters), (each.high for each in parameters)
    return x_of(parameters, low), x_of(parameters, high)


def on_bounds(parameters: Sequence[FitParameter], values: Floats, share: float) -> tuple[bool, ...]:
    """Whether each value is closer to a bound than a share of the range."""
    x, (low, high) = x_of(parameters, values), bounds_of(parameters)
    margin = share * (high - low)
    return tuple(((x < low + margin) | (x > high - margin)).tolist())


def by_key(parameters: Sequence[FitParameter], values: Floats) -> dict[str, float]:
    """Values as those of a study's keys."""
    return dict(zip((each.key for each in parameters), values.tolist(), strict=True))


def in_words(parameters: Sequence[FitParameter], values: Floats, sign: str = " ") -> str:
    """All values in a line."""
    pairs = zip(parameters, values, strict=True)
    return ", ".join(f"{each.name}{sign}{value:.4g}" for each, value in pairs)


@dataclass
class Progress:
    """Counts the places that a search tries, and reports them to a listener.

    Attributes
    ----------
    listener : callable
    likely : int
        How many places there will be, as far as is known.
    name, unit, scale : str, str, float
        What is to be small, the unit it is reported in, and how many of these one of it is.
    trials : int
        Those so far.
    least : float
        The smallest so far.
    """

    listener: Listener
    likely: int
    name: str = "largest peak"
    unit: str = "um"
    scale: float = 1e6
    trials: int = 0
    least: float = np.inf
    _began: float = field(default_factory=time.perf_counter)

    def tried(self, size: float) -> None:
        """Report a place."""
        self.trials, self.least = self.trials + 1, min(self.least, size)
        total = max(self.trials, self.likely)
        left = (time.perf_counter() - self._began) / self.trials * (total - self.trials)
        sizes = self.scale * size, self.scale * self.least
        self.listener(Trial(self.trials, *sizes, self.unit, total, left, self.name))


def varied_parameters(study: Study, table: str) -> list[FitParameter]:
    """Start and bounds of each key that `fit` or `optimise` varies, values the study could have."""
    varied: Varied | None = getattr(study, table)
    assert varied is not None
    found = []
    for key in varied.parameters:
        start = value_at(study, key)
        start = study.excitation.force_per_node if start is None else float(start)
        given = varied.bounds.get(key)
        if given is None and start <= 0:
            text = f'"{key}" starts at {start:g}: give its bounds in {table}.parameters'
            raise InputError(f"{table}: {text}")
        low, high = given or _bounds(study, key, start)
        for bound in (low, high):
            try:
                with_values(study, {key: bound})
            except ValidationError as error:
                why = explain(error, {}, Study)[0]
                raise InputError(f'{table}.parameters."{key}": {why}') from None
        if not low <= start <= high:
            raise InputError(
                f'{table}: "{key}" starts at {start:g}, outside of its bounds {low:g} to {high:g}'
            )
        found.append(FitParameter(key, start, low, high))
    return found


def _bounds(study: Study, key: str, start: float) -> tuple[float, float]:
    """A decade to either side, as far as the study may go."""
    found = []
    for factor in (1 / DECADE, DECADE):
        while factor != 1:
            try:
                with_values(study, {key: start * factor})
                break
            except ValidationError:
                factor = factor**0.5 if abs(np.log(factor)) > 1e-3 else 1.0
        found.append(start * factor)
    return found[0], found[1]
