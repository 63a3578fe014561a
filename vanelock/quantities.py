"""Numbers with units, as a study file writes them: `0.004` is in SI units, `"4 mm"` says its own.

The types here are annotations for pydantic models: `thickness: Length` accepts both forms and
holds metres.
"""

import re
from functools import lru_cache
from typing import Annotated, Any

from pydantic import BeforeValidator

# One number, first of all since pint reads "mm" as one millimetre, and then units alone: pint
# evaluates arithmetic, and a power of a power of a number never ends.
_UNIT = r"(?!(?:squared|cubed)\b)[A-Za-zµμΩÅ_]+(?:\^-?[1-9](?!\d)|⁻?[¹²³⁴])?"
_QUANTITY = re.compile(
    r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
    rf"(?:\s*/?\s*(?:{_UNIT}|%|°C?|\({_UNIT}(?:[*· ]{_UNIT})*\))(?:(?:\s*[*/·]\s*|\s+)"
    rf"(?:{_UNIT}|\({_UNIT}(?:[*· ]{_UNIT})*\)))*)?\s*"
)


@lru_cache(maxsize=1)
def _registry() -> Any:
    from pint import UnitRegistry

    return UnitRegistry()


def si(value: object, unit: str) -> object:
    """Convert text such as `"0.05 mm"` to a number in the SI unit `unit`; pass numbers through.

    Anything that is neither is passed through too, for the model to refuse with its own message.

    Raises
    ------
    ValueError
        If the text is not a quantity of that dimension.
    """
    if not isinstance(value, str):
        return value
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


def rpm(value: object) -> object:
    """Convert text such as `"16000 rpm"` to revolutions a minute; pass numbers through.

    Other units are refused: to a library of units a revolution is 2π, and 1 Hz less than 10 rpm.

    Raises
    ------
    ValueError
        If the text is not a number of rpm.
    """
    if not isinstance(value, str):
        return value
    found = re.fullmatch(r"\s*([+-]?[\d.]+(?:e[+-]?\d+)?)\s*rpm\s*", value, re.IGNORECASE)
    try:
        if found is None:
            raise ValueError
        return float(found[1])
    except ValueError:
        raise ValueError('expected a number in rpm, or text such as "16000 rpm"') from None


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
Bedding = Annotated[float, quantity("N/m^3")]  # a stiffness per area
Revolutions = Annotated[float, BeforeValidator(rpm)]
Unbalance = Annotated[float, quantity("kg*m")]
Wear = Annotated[float, quantity("m^2/N")]  # volume per force and slip distance
