"""Numbers with units, as a study file writes them: `0.004` is in SI units, `"4 mm"` says its own.

The types here are annotations for pydantic models: `thickness: Length` accepts both forms and
holds metres.
"""

import math
import re
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, TypeGuard, get_args

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BeforeValidator
from pydantic.fields import FieldInfo

# One number, first of all since pint reads "mm" as one millimetre, and then units alone: pint
# evaluates arithmetic, and a power of a power of a number never ends.
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
_UNIT = r"(?!(?:squared|cubed)\b)[A-Za-zµμΩÅ_]+(?:\^-?[1-9](?!\d)|⁻?[¹²³⁴])?"
_QUANTITY = re.compile(
    rf"\s*{_NUMBER}(?:\s*/?\s*(?:{_UNIT}|%|°C?|\({_UNIT}(?:[*· ]{_UNIT})*\))(?:(?:\s*[*/·]\s*|\s+)"
    rf"(?:{_UNIT}|\({_UNIT}(?:[*· ]{_UNIT})*\)))*)?\s*"
)


@lru_cache(maxsize=1)
def _registry() -> Any:
    from pint import UnitRegistry

    return UnitRegistry()


def si(value: object, unit: str) -> object:
    """Convert text such as `"0.05 mm"` to a number in the SI unit `unit`; pass numbers through.

    Anything that is neither is passed through too, for the model to refuse with its own message.
    """
    return _si(value, unit) if isinstance(value, str) else value


@lru_cache(maxsize=10_000)
def _si(value: str, unit: str) -> float:
    from pint.errors import PintError

    try:
        if len(value) > 40 or not _QUANTITY.fullmatch(value):
            raise ValueError
        quantity = _registry().Quantity(value.strip())
        converted = quantity.m if quantity.dimensionless and not unit else quantity.m_as(unit)
        return float(f"{converted:.15g}")  # 4.5 mm is 0.0045 m, as its digits say
    except (PintError, ValueError, TypeError, ArithmeticError, AttributeError, AssertionError):
        example = f'"1 {unit}"' if unit else '"1"'
        raise ValueError(
            f"expected a number in {unit}, or text with a unit such as {example}"
        ) from None


def _rpm(value: object) -> object:
    """Convert text such as `"16000 rpm"` to revolutions a minute; pass numbers through.

    Other units are refused: to a library of units a revolution is 2π, and 1 Hz less than 10 rpm.
    """
    if not isinstance(value, str):
        return value
    found = re.fullmatch(rf"\s*({_NUMBER})\s*rpm\s*", value, re.IGNORECASE)
    if found is None:
        raise ValueError('expected a number in rpm, or text such as "16000 rpm"')
    return float(found[1])


def factor(unit: str, to: str) -> float:
    """What one unit is in another, or `ValueError`."""
    return _si(f"1 {unit}", to)


def quantity(unit: str) -> BeforeValidator:
    """Pydantic validator that accepts a number in `unit`, or text with its own unit."""
    return BeforeValidator(lambda value: si(value, unit))


Length = Annotated[float, quantity("m")]
Angle = Annotated[float, quantity("deg")]  # degrees at the user's side
Pressure = Annotated[float, quantity("Pa")]
Density = Annotated[float, quantity("kg/m^3")]
Force = Annotated[float, quantity("N")]
Frequency = Annotated[float, quantity("Hz")]
Stiffness = Annotated[float, quantity("N/m")]
Revolutions = Annotated[float, BeforeValidator(_rpm)]
Unbalance = Annotated[float, quantity("kg*m")]
Wear = Annotated[float, quantity("m^2/N")]  # volume per force and slip distance


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value is a number; true is none, though Python counts with it."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def is_whole(value: object) -> TypeGuard[int]:
    """Whether a value is a whole number; true is none."""
    return isinstance(value, int) and not isinstance(value, bool)


def number_within(value: object, unit: str, low: float, high: float, needed: str) -> float:
    """A number in `unit`, or text with its own, between bounds; or `needed` as a `ValueError`."""
    with suppress(ValueError):
        size = si(value, unit)
        if is_number(size) and low <= size <= high:
            return float(size)
    raise ValueError(needed)


def number(value: object, field: FieldInfo) -> float:
    """A number of a field in the field's unit, from text with its own unit too."""
    for each in metadata(field):
        if isinstance(each, BeforeValidator):
            value = each.func(value)  # type: ignore[call-arg]
    if not is_number(value):
        raise ValueError("expected a number")
    return float(value)


@dataclass(frozen=True)
class _Bounds:
    """What the schema lets a key be: from `low`, or `above` it, to `high`."""

    low: float
    high: float
    above: bool = False


def bounds(field: FieldInfo) -> _Bounds:
    """Smallest and largest value that the schema lets a key have."""
    low, high, above = -math.inf, math.inf, False
    for each in metadata(field):
        match each:
            case Ge(ge=bound) | Gt(gt=bound):
                low = max(low, float(bound))  # type: ignore[arg-type]
                above = isinstance(each, Gt)
            case Le(le=bound) | Lt(lt=bound):
                high = min(high, float(bound))  # type: ignore[arg-type]
    return _Bounds(low, high, above)


def metadata(field: FieldInfo) -> list[Any]:
    """What limits and converts a field's number, be it optional."""
    found = list(field.metadata)
    for option in get_args(field.annotation):
        found += getattr(option, "__metadata__", ())
    return [inner for each in found for inner in getattr(each, "metadata", None) or [each]]


class Usual(_Bounds):
    """Of a field's metadata: between which values it nearly always lies, in its unit."""


OTHERS = {
    "m": ("mm", "um", "cm"),
    "Pa": ("MPa", "GPa", "kPa"),
    "kg/m^3": ("g/cm^3", "kg/mm^3", "t/mm^3"),
    "N": ("kN", "mN"),
    "Hz": ("kHz",),
    "N/m": ("N/mm", "N/um", "kN/um"),
    "N/m^3": ("N/mm^3", "kN/mm^3"),
    "kg m": ("g*mm", "kg*mm", "t*mm"),
    "m^2/N": ("mm^2/N",),
}
"""Units that a number was meant in where it makes no sense in the one of its key."""


def meant(value: float, unit: str, allowed: _Bounds, field: FieldInfo) -> str:
    """A field's number with the unit in which it lies within bounds, "" if there is none.

    Of several, the unit in which it is nearest to the default, or the first number of that.
    """
    near, found = field.default, []
    while isinstance(near, tuple) and near:
        near = near[0]
    for other in OTHERS.get(unit, ()):
        size = factor(other, unit) * value
        if 0 < size and allowed.low <= size <= allowed.high:
            distance = abs(math.log(size / near)) if is_number(near) and near > 0 else 0.0
            found.append((distance, f"{value:.12g} {other}"))
    return min(found, key=lambda pair: pair[0])[1] if found else ""
