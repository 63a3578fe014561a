"""What a fit varies: keys of a study, where each begins, and between which bounds.

Apart from the fit itself, so that checking a study need not load it.
"""

from dataclasses import dataclass

import numpy as np
from pydantic import ValidationError

from vanelock.common.checked import explain
from vanelock.common.errors import InputError
from vanelock.input.cases.values import value_at, with_values
from vanelock.input.schema.comparison import Varied
from vanelock.input.schema.study import Study

DECADE = 10.0
"""Bounds unless the study gives any: the study's value over and times this."""


@dataclass(frozen=True)
class FitParameter:
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

    def stretch(self, value: float) -> float:
        """D ln θ / dx at a value: what θ dA/dθ is multiplied by; NaN at θ = 0."""
        if self.logarithmic:
            return 1.0
        return self._unit / value if value else float("nan")

    @property
    def _unit(self) -> float:
        return max(abs(self.low), abs(self.high))


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
