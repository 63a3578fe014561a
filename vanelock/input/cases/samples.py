"""Samples of keys that scatter: a Latin hypercube, mapped by each key's inverse distribution.

Of n samples exactly one lies in each n-th part of every key's probability (McKay, Beckman and
Conover, Technometrics 21 (1979) 239), so that few of them cover each key's range evenly.
"""

import math
from functools import partial
from typing import Any

import numpy as np
from pydantic.fields import FieldInfo

from vanelock.common.arrays import Floats
from vanelock.common.checked import field_at, kinds_of, show, unknown
from vanelock.common.errors import InputError, raised
from vanelock.common.quantities import number
from vanelock.input.cases.values import Problem, path_of
from vanelock.input.schema.distributions import Distribution

DIGITS = 9
"""Of a sample, so that it can be written down and run again."""
MIDDLE = np.array([0.5])
LEAST = 1e-3
"""Probability that a distribution must leave between its ends."""


def samples(problem: Problem) -> dict[str, list[float]]:
    """Values of each scattering key, in the order of the samples."""
    from scipy.stats import qmc  # takes longer to load than the rest of this package

    scatter = problem.scatter
    assert scatter is not None
    if wrong := sample_mistakes(problem):
        raise InputError("\n".join(wrong))
    random = np.random.default_rng(problem.seed)
    cube = qmc.LatinHypercube(len(scatter.keys), rng=random).random(scatter.samples)
    return {
        key: [
            float(f"{value:.{DIGITS}g}")
            for value in _mapped(key, each, cube[:, i], field_at(path_of(key), type(problem)))
        ]
        for i, (key, each) in enumerate(scatter.keys.items())
    }


def sample_mistakes(problem: Problem) -> list[str]:
    """What is wrong with the keys that scatter and with their distributions."""
    if problem.scatter is None:
        return []
    found: list[str] = []
    if problem.sweep or problem.rows:
        found.append("scatter: give either this, or sweep and rows, not both")
    for key, each in problem.scatter.keys.items():
        field, where = field_at(path_of(key), type(problem)), f'scatter.keys."{key}"'
        if field is None:
            found.append(f"{where}: {unknown(path_of(key), type(problem))}")
        elif float not in kinds_of(field) or key.startswith(("outputs.", "scatter.")):
            found.append(f"{where}: only keys that hold a number with a fraction can scatter")
        else:
            found += raised(partial(_mapped, key, each, MIDDLE, field))
    return found


@np.errstate(all="ignore")  # what overflows is refused
def _mapped(key: str, keys: Distribution, probability: Floats, field: FieldInfo | None) -> Any:
    """Quantiles of a key's distribution, cut where it is cut."""
    from scipy import stats

    where, (name, pair) = f'scatter.keys."{key}"', keys.law
    assert field is not None
    one, other = _numbers(f"{where}.{name}", pair, field)
    low, high = (-math.inf, math.inf)
    if keys.within is not None:
        low, high = _numbers(f"{where}.within", keys.within, field)
    elif name == "uniform":
        low, high = one, other
    if low >= high:
        cut = name if keys.within is None else "within"
        ends = show(getattr(keys, cut))
        raise InputError(f"{where}.{cut} = {ends}: must be [low, high] with low < high")
    if name != "uniform" and other <= 0:
        raise InputError(f"{where}.{name} = {show(pair)}: standard deviation must be > 0")
    if name == "uniform":
        law = stats.uniform(low, high - low)
    elif name == "normal":
        law = stats.norm(one, other)
    else:
        if one <= 0:
            raise InputError(f"{where}.{name} = {show(pair)}: mean must be > 0")
        spread = np.sqrt(np.log1p(np.square(other / one)))
        law = stats.lognorm(spread, scale=one * np.exp(-0.5 * spread**2))
    first, last = law.cdf(low), law.cdf(high)
    if last - first < LEAST:
        raise InputError(f"{where}.within = {show(keys.within)}: leaves nothing of it")
    values = np.clip(law.ppf(first + probability * (last - first)), low, high)
    if not np.isfinite(values).all():
        raise InputError(f"{where}: numbers too large or too small for a {name} distribution")
    return values


def _numbers(where: str, pair: tuple[Any, Any], field: FieldInfo) -> tuple[float, float]:
    """In the key's unit."""
    try:
        one, other = (number(value, field) for value in pair)
        if math.isnan(one) or math.isnan(other):
            raise ValueError("expected numbers")
    except ValueError as error:
        raise InputError(f"{where} = {show(pair)}: {error}") from None
    return one, other
