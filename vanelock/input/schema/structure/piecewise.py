"""Values given at a few points and straight lines between them, as a study file lists them.

E = [[20, "200 GPa"], [600, "165 GPa"]]
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, TypeAlias

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field

from vanelock.common.quantities import Pressure

Pairs: TypeAlias = tuple[tuple[float, float], ...]


def _tuples(value: object) -> object:
    if isinstance(value, list | tuple):
        return tuple(tuple(item) if isinstance(item, list | tuple) else item for item in value)
    return value


def _ascending(value: Pairs) -> Pairs:
    for (a, _), (b, _) in pairwise(value):
        if a >= b:
            raise ValueError(f"{a:g} and {b:g}: the first number of each pair must ascend")
    return value


Degrees = Annotated[float, Field(ge=-273.15, le=5000, description="temperature [degC]")]
Modulus = Annotated[Pressure, Field(ge=1e3, le=1e15, description="Young's modulus [Pa]")]

ByTemperature = Annotated[
    tuple[tuple[Degrees, Modulus], ...],
    BeforeValidator(_tuples),
    AfterValidator(_ascending),
    Field(min_length=2, max_length=1000),
]
"""Young's modulus at temperatures, ((degC, Pa), ...)."""


def at(pairs: Sequence[tuple[float, float]], x: float) -> float:
    """Value on the line through the pairs; outside of them that of the nearest."""
    known = np.array(pairs)
    return float(np.interp(x, known[:, 0], known[:, 1]))


def ends(pairs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """First and last place."""
    return float(pairs[0][0]), float(pairs[-1][0])
