"""Tables of the study file on scatter: keys that vary by chance, each by a distribution."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from vanelock.common.checked import Check
from vanelock.common.quantities import is_number
from vanelock.input.schema.structure.structure import KeyTable, leaves, sequence


def _quantity(value: object) -> object:
    """Pass a number in the key's unit, or text with its own; converted when the key is known."""
    if not is_number(value) and not isinstance(value, str):
        raise ValueError("expected a number, or text with a unit")
    return value


Quantity = Annotated[Any, BeforeValidator(_quantity)]


Pair = Annotated[tuple[Quantity, Quantity], BeforeValidator(sequence)]
LAWS = ("uniform", "normal", "lognormal")


class Distribution(KeyTable):
    """How a key scatters: evenly from low to high, or by mean and standard deviation.

    The mean and the deviation are those of the quantity itself, before it is cut.
    """

    uniform: Pair | None = Field(default=None, description="[low, high]")
    normal: Pair | None = Field(default=None, description="[mean, standard deviation]")
    lognormal: Pair | None = Field(default=None, description="[mean, standard deviation]")
    within: Pair | None = Field(default=None, description="[low, high] where it is cut")

    @property
    def law(self) -> tuple[str, tuple[Any, Any]]:
        """Which one, and its two numbers."""
        return next((name, pair) for name in LAWS if (pair := getattr(self, name)) is not None)

    def _is_one(self) -> Iterator[str]:
        asked = [name for name in LAWS if getattr(self, name) is not None]
        if len(asked) != 1:
            yield f"needs one of {', '.join(LAWS)}, not {' and '.join(asked) or 'none'}"
        elif self.uniform is not None and self.within is not None:
            yield "within: uniform has its ends already"

    checks: ClassVar[tuple[Check, ...]] = (_is_one,)


def _nests(value: Any) -> bool:
    """Whether a value is a table of keys that TOML nests, not a distribution's."""
    return (
        isinstance(value, dict)
        and not Distribution.model_fields.keys() & value
        and any(isinstance(inner, dict) for inner in value.values())
    )


def _flat(value: object) -> object:
    """Keys without quotes, which TOML nests, as dotted ones, down to tables of a distribution."""
    return dict(leaves(value, nests=_nests)) if isinstance(value, dict) else value


class Scatter(KeyTable):
    """A Latin hypercube over keys that scatter, and percentiles of the peaks."""

    samples: int = Field(default=100, ge=2, le=100_000, description="number of samples")
    keys: Annotated[dict[str, Distribution], BeforeValidator(_flat)] = Field(
        min_length=1, max_length=50, description="scattering keys"
    )


def _deviation(value: object) -> object:
    """A standard deviation, or deviations of all segments, relative."""
    each = value if isinstance(value, list | tuple) else (value,)
    if not each or not all(map(is_number, each)):
        raise ValueError("expected a number, such as 0.01 for 1 %, or a list with one a segment")
    if isinstance(value, list | tuple):
        if not all(-1 < v <= 10 for v in each):
            raise ValueError("relative deviations of segments must be > -1 and <= 10")
        return tuple(float(v) for v in each)
    if not 0 <= each[0] <= 1:
        raise ValueError("a relative standard deviation must be >= 0 and <= 1")
    return float(each[0])


Deviation = Annotated[Any, BeforeValidator(_deviation)]
