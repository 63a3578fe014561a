"""Tables of the study file on scatter: keys that vary by chance, each by a distribution."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from vanelock.common.checked import Check
from vanelock.input.schema.structure.structure import KeyTable


def _quantity(value: object) -> object:
    """Pass a number in the key's unit, or text with its own; converted when the key is known."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError("expected a number, or text with a unit")
    return value


Quantity = Annotated[Any, BeforeValidator(_quantity)]


class Distribution(KeyTable):
    """How a key scatters: evenly from low to high, or about a mean, cut at low and high if given.

    The mean and the deviation are those of the quantity itself, before it is cut.
    """

    distribution: Literal["uniform", "normal", "lognormal"] = Field(
        default="uniform", description="distribution"
    )
    low: Quantity | None = Field(default=None, description="smallest value")
    high: Quantity | None = Field(default=None, description="largest value")
    mean: Quantity | None = Field(default=None, description="mean")
    deviation: Quantity | None = Field(default=None, description="standard deviation")
    truncate: bool = Field(default=False, description="whether cut to what the key allows")

    def _is_whole(self) -> Iterator[str]:
        """Each kind needs two numbers."""
        uniform = self.distribution == "uniform"
        needed = ("low", "high") if uniform else ("mean", "deviation")
        for name in needed:
            if getattr(self, name) is None:
                yield f"a {self.distribution} distribution needs {' and '.join(needed)}"
        if uniform and (self.mean is not None or self.deviation is not None):
            yield "a uniform distribution takes low and high, no mean or deviation"

    checks: ClassVar[tuple[Check, ...]] = (_is_whole,)


def _flat(value: object) -> object:
    """Keys without quotes, which TOML nests, as dotted ones, down to tables of a distribution."""
    if not isinstance(value, dict):
        return value
    found: dict[str, Any] = {}

    def descend(table: dict[str, Any], prefix: str) -> None:
        for name, inner in table.items():
            if (
                isinstance(inner, dict)
                and not Distribution.model_fields.keys() & inner
                and any(isinstance(each, dict) for each in inner.values())
            ):
                descend(inner, f"{prefix}{name}.")
            else:
                found[f"{prefix}{name}"] = inner

    descend(value, "")
    return found


class Scatter(KeyTable):
    """A Latin hypercube over keys that scatter, and percentiles of the peaks."""

    samples: int = Field(default=100, ge=2, le=100_000, description="number of samples")
    keys: Annotated[dict[str, Distribution], BeforeValidator(_flat)] = Field(
        min_length=1, max_length=50, description="scattering keys"
    )


def _deviation(value: object) -> object:
    """A standard deviation, or deviations of all segments, relative."""
    each = value if isinstance(value, list | tuple) else (value,)
    if not each or any(isinstance(v, bool) or not isinstance(v, int | float) for v in each):
        raise ValueError("expected a number, such as 0.01 for 1 %, or a list with one a segment")
    if isinstance(value, list | tuple):
        if not all(-1 < v <= 10 for v in each):
            raise ValueError("relative deviations of segments must be > -1 and <= 10")
        return tuple(float(v) for v in each)
    if not 0 <= each[0] <= 1:
        raise ValueError("a relative standard deviation must be >= 0 and <= 1")
    return float(each[0])


Deviation = Annotated[Any, BeforeValidator(_deviation)]


class JointDeviations(KeyTable):
    """By how much the segments of a ring differ in a joint, relative to the joint's own values."""

    interference: Deviation | None = Field(default=None, description="deviation of interference")
    mu: Deviation | None = Field(default=None, description="deviation of the friction coefficient")
    kn: Deviation | None = Field(default=None, description="deviation of the normal stiffness")
    kt: Deviation | None = Field(default=None, description="deviation of the tangential stiffness")
    slider: Annotated[float, Field(ge=0, le=1)] | None = Field(
        default=None, description="deviation of static friction, of its limit"
    )
