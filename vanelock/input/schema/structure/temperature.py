"""Temperature of each part, uniform in it, by rotor speed: Young's modulus and thermal growth.

    K_part(n) = K_part · E(T_part(n)) / E(T_ref)

with Poisson's ratio, density and the contacts' stiffness as given; growth where the materials have
an expansion, at the temperatures of the response. Temperatures that differ within the vane act on
its growth alone.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from vanelock.common.checked import Check
from vanelock.common.errors import InputError
from vanelock.common.quantities import Revolutions, is_number
from vanelock.input.schema.structure.structure import KeyTable, at, ends

PARTS = ("vane", "casing")


COLDEST, HOTTEST = -273.15, 5000.0


def _temperature(value: object) -> object:
    """A temperature in degC, or pairs of rotor speed and temperature."""
    if value is None:
        return None
    if is_number(value) and COLDEST <= value <= HOTTEST:
        return float(value)
    if isinstance(value, list | tuple) and len(value) > 1:
        pairs = tuple(tuple(each) if isinstance(each, list | tuple) else () for each in value)
        if all(
            len(each) == 2
            and all(map(is_number, each))
            and 0 <= each[0] <= 1e6
            and COLDEST <= each[1] <= HOTTEST
            for each in pairs
        ):
            for (a, _), (b, _) in pairwise(pairs):
                if a >= b:
                    raise ValueError(f"{a:g} and {b:g} rpm: speeds must ascend")
            return tuple((float(a), float(b)) for a, b in pairs)
    raise ValueError(
        "temperature must be a number, degC, or at least two pairs [[rpm, degC], [rpm, degC], ...]"
    )


ByRotorSpeed = Annotated[Any, BeforeValidator(_temperature)]


class Temperature(KeyTable):
    """Temperatures of the parts against rotor speed, and the speed of the response."""

    vane: ByRotorSpeed = Field(default=None, description="temperature [degC]")
    casing: ByRotorSpeed = Field(default=None, description="temperature [degC]")
    field: str | None = Field(
        default=None, min_length=1, max_length=4096, description="file of the vane's temperature"
    )
    reference: Annotated[float, Field(ge=COLDEST, le=HOTTEST)] = Field(
        default=20.0, description="temperature at which nothing has grown [degC]"
    )
    speed: Revolutions | None = Field(default=None, gt=0, le=1e6, description="rotor speed [rpm]")

    @property
    def given(self) -> bool:
        """Whether any part has a temperature."""
        return self.vane is not None or self.casing is not None

    @property
    def varies(self) -> bool:
        """Whether a part's temperature depends on the rotor's speed."""
        return any(isinstance(getattr(self, part), tuple) for part in PARTS)

    @property
    def speeds(self) -> tuple[float, float]:
        """Lowest and highest speed at which all temperatures are known, rpm."""
        found = [ends(each) for part in PARTS if isinstance(each := getattr(self, part), tuple)]
        low = max((each[0] for each in found), default=0.0)
        return low, min((each[1] for each in found), default=float("inf"))

    def of(self, part: str, speed: float) -> float | None:
        """Temperature of a part at a speed, rpm, degC; None where it has none."""
        found = getattr(self, part)
        if isinstance(found, tuple):
            low, high = self.speeds
            if not low <= speed <= high:
                raise InputError(
                    f"temperature.{part}: given from {low:g} to {high:g} rpm, needed at {speed:g}"
                )
            return at(found, speed)
        return None if found is None else float(found)


def _is_used(study: Any) -> Iterator[str]:
    heat = study.temperature
    if heat.speed is not None and not heat.given:
        yield f"temperature.speed = {heat.speed:g}: needs temperature.vane or temperature.casing"


def _has_the_moduli(study: Any) -> Iterator[str]:
    for part in PARTS:
        heat, metal = study.temperature, getattr(study.material, part)
        known = getattr(heat, part)
        if not metal.moduli:
            if known is not None and not metal.expansion:  # which acts at the modulus as given
                yield f"temperature.{part}: needs pairs of degC and modulus in material.{part}.E"
            continue
        low, high = ends(metal.moduli)
        name, known = ("reference", heat.reference) if known is None else (part, known)
        for each in [pair[1] for pair in known] if isinstance(known, tuple) else [known]:
            if not low <= each <= high:
                yield (
                    f"temperature.{name}: {each:g} degC is outside material.{part}.E, "
                    f"{low:g} to {high:g} degC"
                )


def _has_the_speed(study: Any) -> Iterator[str]:
    heat = study.temperature
    low, high = heat.speeds
    if low >= high:
        yield "temperature.vane and temperature.casing: no speed is within both"
    elif heat.speed is not None and not low <= heat.speed <= high:
        yield (
            f"temperature.speed = {heat.speed:g}: temperatures are given from {low:g} to "
            f"{high:g} rpm"
        )
    if study.accuracy is not None and heat.varies and heat.speed is None:
        yield (
            f"accuracy = {study.accuracy:g}: needs temperature.speed, the rotor speed at which the "
            "response has its temperatures"
        )


TEMPERATURE_CHECKS: tuple[Check, ...] = (_is_used, _has_the_moduli, _has_the_speed)
"""Of a `Study`."""
