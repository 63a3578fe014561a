"""Tables of the study file on what is compared: Campbell diagram, measured curves, fit."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, field_validator

from vanelock.common.checked import OTHER, PLAIN, Check
from vanelock.common.quantities import Force, Frequency, Revolutions, is_number, si
from vanelock.input.schema.structure.structure import KeyTable, Listed, ascending, flat, sequence

if TYPE_CHECKING:
    from vanelock.input.schema.study import Study

_OF_JOINTS = [
    f"joints.{joint}.{key}"
    for joint in ("interlock", "hook")
    for key in ("mu", "kn", "kt", "interference")
]
FITTED = (
    *_OF_JOINTS,
    "excitation.force",
    "damping.ratio",
    "material.vane.E",
    "material.casing.E",
)
"""Keys that may be fitted: those that need no new reduction."""
UNITS = {"kn": "N/m", "kt": "N/m", "interference": "m", "force": "N", "E": "Pa"}


Speed = Annotated[Revolutions, Field(ge=0, le=1e6, description="rotor speed [rpm]")]
Hertz = Annotated[Frequency, Field(gt=0, le=1e6, description="frequency [Hz]")]
FrequencyRange = Annotated[
    Listed[Hertz],
    Field(min_length=2, max_length=2),
    AfterValidator(ascending),
]
Newtons = Annotated[Force, Field(gt=0, le=1e9, description="force [N]")]
Positive = Annotated[int, Field(ge=1, le=1000, description="engine order")]


class CampbellKeys(KeyTable):
    """Campbell diagram: natural frequencies against rotor speed, and engine orders."""

    speeds: Listed[Speed] | None = Field(
        default=None, min_length=2, max_length=2, description="[low, high] rotor speed [rpm]"
    )
    engine_orders: Listed[Positive] = Field(
        default=(1, 2, 3, 4), min_length=1, max_length=20, description="engine orders"
    )
    modes: int = Field(default=4, ge=1, le=40, description="number of modes of a nodal diameter")

    _low_high = field_validator("speeds")(ascending)

    @field_validator("engine_orders")
    @classmethod
    def _distinct(cls, value: tuple[int, ...]) -> tuple[int, ...]:
        if len(set(value)) < len(value):
            raise ValueError("engine orders must differ from each other")
        return value


class MeasuredCurve(KeyTable):
    """A measured response from a CSV file or a Universal File."""

    file: str = Field(min_length=1, max_length=4096, description="CSV file, or Universal File")
    name: str | None = Field(default=None, min_length=1, max_length=100, description="name")
    engine_order: Positive | None = Field(default=None, description="engine order")
    gauge: int | None = Field(default=None, ge=1, le=100, description="number of the strain gauge")
    direction: Literal["up", "down"] = Field(default="up", description="direction of the sweep")
    load: float = Field(default=1.0, gt=0, le=1e6, description="load over that of the study")
    sigma: float | None = Field(default=None, gt=0, description="standard deviation")
    range: Listed[Hertz] | None = Field(
        default=None, min_length=2, max_length=2, description="[low, high] frequency [Hz]"
    )
    unit: str | None = Field(
        default=None, min_length=1, max_length=40, description="unit of a Universal File's record"
    )
    force: Newtons | None = Field(
        default=None, description="force that a response per force is multiplied by [N]"
    )

    _low_high = field_validator("range")(ascending)


def curves(value: object) -> object:
    """One table, or a list of them."""
    if isinstance(value, dict | MeasuredCurve):
        return (value,)
    return tuple(value) if isinstance(value, list) else value


Bounds = Annotated[Listed[Any], Field(min_length=2, max_length=2)]


class Varied(KeyTable):
    """Keys that are varied, between which bounds, and from how many starts."""

    parameters: Annotated[
        Annotated[tuple[str, ...], Field(min_length=1), Tag(PLAIN)]
        | Annotated[dict[str, Bounds], Field(min_length=1), Tag(OTHER)],
        Discriminator(lambda value: OTHER if isinstance(value, dict) else PLAIN),
        BeforeValidator(flat),
        BeforeValidator(sequence),
    ] = Field(default=("joints.interlock.mu",), description="varied keys")
    starts: int = Field(default=3, ge=1, le=100, description="number of starts")

    allowed: ClassVar[tuple[str, ...]] = ()
    verb: ClassVar[str] = ""

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """[low, high] of keys that have them."""
        return self.parameters if isinstance(self.parameters, dict) else {}

    @field_validator("parameters")
    @classmethod
    def _known(cls, value: tuple[str, ...] | dict[str, Any]) -> Any:
        for key in value:
            if key not in cls.allowed:
                raise ValueError(
                    f'"{key}" cannot be {cls.verb}; what can: {", ".join(cls.allowed)}'
                )
        if len(set(value)) < len(value):
            raise ValueError(f"{cls.verb} keys must differ from each other")
        if isinstance(value, tuple):
            return value
        return {key: cls._low_high(key, pair) for key, pair in value.items()}

    @staticmethod
    def _low_high(key: str, pair: tuple[Any, Any]) -> tuple[float, float]:
        """Bounds in the key's unit."""
        try:
            low, high = (si(each, UNITS.get(key.rpartition(".")[2], "")) for each in pair)
        except ValueError as error:
            raise ValueError(f'"{key}" = {list(pair)}: {error}') from None
        if not is_number(low) or not is_number(high) or not low < high:
            raise ValueError(f'"{key}" = {list(pair)}: expected [low, high] with low < high')
        return float(low), float(high)


class Fit(Varied):
    """What `vanelock fit` varies so that the response meets the measured curves."""

    allowed: ClassVar[tuple[str, ...]] = FITTED
    verb: ClassVar[str] = "fitted"


class Optimise(Varied):
    """What `vanelock optimise` varies so that the largest peak is the smallest."""

    of: Literal["peak", "upper bound", "peak and wear"] = Field(
        default="peak", description="what is made smallest"
    )
    starts: int = Field(default=32, ge=0, le=1000, description="number of starts")

    allowed: ClassVar[tuple[str, ...]] = tuple(_OF_JOINTS)
    verb: ClassVar[str] = "optimised"


def _has_the_gauges(study: Any) -> Iterator[str]:
    """Measured strains are those of the study's gauges."""
    for i, curve in enumerate(study.measured):
        gauges = len(study.outputs.gauges)
        if curve.gauge is not None and curve.gauge > gauges:
            have = f"1 to {gauges}" if gauges else "none"
            yield f"measured[{i}].gauge = {curve.gauge}: outputs.gauges has {have}"


def _has_measurements(study: Any) -> Iterator[str]:
    if study.fit is not None and not study.measured:
        yield "fit: needs [[measured]], the curves to meet"


def _can_be_fitted(study: Any) -> Iterator[str]:
    tables = {"fit": study.fit, "optimise": study.optimise}
    for name, key in ((name, key) for name, of in tables.items() if of for key in of.parameters):
        where = f'{name}.parameters: "{key}"'
        joint, last = key.split(".")[1], key.rpartition(".")[2]
        if joint == "interlock" and not study.joints.interlock:
            yield f"{where}: joints.interlock = false"
        elif key == "excitation.force" and study.excitation.unbalance is not None:
            yield f"{where}: excitation.unbalance is given"
        elif last == "E" and getattr(study.temperature, joint) is not None:
            yield f"{where}: temperature.{joint} is given"
        elif last == "E" and getattr(study.material, joint).moduli:
            yield f"{where}: is given by temperature"
        elif key.startswith("joints.") and last in getattr(study.joints, joint).per_area:
            yield f"{where}: is a stiffness per area"


def _has_the_temperatures(study: Any) -> Iterator[str]:
    speeds = study.campbell and study.campbell.speeds
    low, high = study.temperature.speeds
    if speeds and (speeds[0] < low or speeds[1] > high):
        yield (
            f"campbell.speeds = [{speeds[0]:g}, {speeds[1]:g}]: temperatures are given from "
            f"{low:g} to {high:g} rpm"
        )


def _front_wears(study: "Study") -> Iterator[str]:
    wears = study.optimise is not None and study.optimise.of == "peak and wear"
    if wears and not study.wear_coefficients:
        keys = ", ".join(f"joints.{name}.wear_coefficient" for name in study.joint_names)
        yield f'optimise.of = "peak and wear": no joint wears: give one of {keys}'


COMPARISON_CHECKS: tuple[Check, ...] = (
    _has_the_gauges,
    _has_measurements,
    _can_be_fitted,
    _front_wears,
    _has_the_temperatures,
)
"""Of a `Study`."""
