"""Samples of keys that scatter: a Latin hypercube, mapped by each key's inverse distribution.

Of n samples exactly one lies in each n-th part of every key's probability (McKay, Beckman and
Conover, Technometrics 21 (1979) 239), so that few of them cover each key's range evenly.
"""

import math
from functools import partial
from typing import Any, get_args, get_origin

import numpy as np
from numpy.typing import NDArray
from pydantic.fields import FieldInfo

from vanelock.common.checked import field_at, show, unknown
from vanelock.common.errors import InputError, raised
from vanelock.common.quantities import bounds, number
from vanelock.input.cases.values import Given, path_of
from vanelock.input.schema.distributions import Distribution

DIGITS = 9
"""Of a sample, so that it can be written down and run again."""
MIDDLE = np.array([0.5])
LEAST = 1e-3
"""Probability that a distribution must leave between its ends."""


def samples(given: Given) -> dict[str, list[float]]:
    """Values of each scattering key, in the order of the samples."""
    from scipy.stats import qmc  # takes longer to load than the rest of this package

    scatter = given.scatter
    assert scatter is not None
    if wrong := sample_mistakes(given):
        raise InputError("\n".join(wrong))
    random = np.random.default_rng(given.seed)
    cube = qmc.LatinHypercube(len(scatter.keys), rng=random).random(scatter.samples)
    return {
        key: [
            float(f"{value:.{DIGITS}g}")
            for value in _mapped(key, each, cube[:, i], field_at(path_of(key), type(given)))
        ]
        for i, (key, each) in enumerate(scatter.keys.items())
    }


def sample_mistakes(given: Given) -> list[str]:
    """What is wrong with the keys that scatter and with their distributions."""
    if given.scatter is None:
        return []
    found: list[str] = []
    if given.sweep or given.rows:
        found.append("scatter: give either this, or sweep and rows, not both")
    for key, each in given.scatter.keys.items():
        field = field_at(path_of(key), type(given))
        found += _mistakes(key, field, type(given)) or raised(
            partial(_mapped, key, each, MIDDLE, field)
        )
    return found


def _mistakes(key: str, field: FieldInfo | None, schema: type[Given]) -> list[str]:
    where = f'scatter.keys."{key}"'
    if field is None:
        return [f"{where}: {unknown(path_of(key), schema)}"]
    if float not in _types(field) or key.startswith(("outputs.", "scatter.")):
        return [f"{where}: only keys that hold a number with a fraction can scatter"]
    return []


@np.errstate(all="ignore")  # what overflows is refused
def _mapped(
    key: str, given: Distribution, probability: NDArray[np.float64], field: FieldInfo | None
) -> Any:
    """Quantiles of a key's distribution, cut where it is cut."""
    from scipy import stats

    where = f'scatter.keys."{key}"'
    assert field is not None
    low, high, mean, deviation = (
        _number(f"{where}.{name}", getattr(given, name), field)
        for name in ("low", "high", "mean", "deviation")
    )
    if low is not None and high is not None and low >= high:
        raise InputError(f"{where}.high = {show(given.high)}: must be above low")
    if given.distribution == "uniform":
        assert low is not None
        assert high is not None
        found = stats.uniform(low, high - low)
    else:
        assert mean is not None
        assert deviation is not None
        if deviation <= 0:
            raise InputError(f"{where}.deviation = {show(given.deviation)}: must be > 0")
        if given.distribution == "normal":
            found = stats.norm(mean, deviation)
        else:
            if mean <= 0:
                raise InputError(f"{where}.mean = {show(given.mean)}: must be > 0")
            spread = np.sqrt(np.log1p(np.square(deviation / mean)))
            found = stats.lognorm(spread, scale=mean * np.exp(-0.5 * spread**2))
    ends = (-math.inf if low is None else low, math.inf if high is None else high)
    if given.truncate:
        schema = bounds(field)
        ends = (max(ends[0], schema.low), min(ends[1], schema.high))
    first, last = found.cdf(ends[0]), found.cdf(ends[1])
    if last - first < LEAST:
        raise InputError(f"{where}: leaves nothing between low and high")
    values = np.clip(found.ppf(first + probability * (last - first)), ends[0], ends[1])
    if not np.isfinite(values).all():
        shape = given.distribution
        raise InputError(f"{where}: numbers too large or too small for a {shape} distribution")
    return values


def _number(where: str, value: float | str | None, field: FieldInfo) -> float | None:
    """In the key's unit."""
    if value is None:
        return None
    try:
        found = number(value, field)
        if not math.isfinite(found):
            raise ValueError("expected a finite number")
    except ValueError as error:
        raise InputError(f"{where} = {show(value)}: {error}") from None
    return found


def _types(field: FieldInfo) -> list[Any]:
    options = [field.annotation, *get_args(field.annotation)]
    return options + [get_args(each)[0] for each in options if get_origin(each) and get_args(each)]
