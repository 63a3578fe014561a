"""Tables of the study file on what is compared: Campbell diagram, measured curves, fit."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo, field_validator

from vanelock.common.checked import Check
from vanelock.common.quantities import Force, Frequency, Revolutions, si
from vanelock.input.schema.structure.structure import KeyTable, leaves, sequence

if TYPE_CHECKING:
    from vanelock.input.schema.study import Study

FITTED = (
    "joints.interlock.mu",
    "joints.interlock.kn",
    "joints.interlock.kt",
    "joints.interlock.interference",
    "joints.hook.mu",
    "joints.hook.kn",
    "joints.hook.kt",
    "joints.hook.interference",
    "excitation.force",
    "damping.ratio",
    "material.vane.E",
    "material.casing.E",
)
"""Keys that may be fitted: those that need no new reduction."""
UNITS = {"kn": "N/m", "kt": "N/m", "interference": "m", "force": "N", "E": "Pa"}


def _ascending(value: tuple[float, ...] | None) -> tuple[float, ...] | None:
    """Both ends of a range, refused where the second is not above the first."""
    if value is not None and value[0] >= value[1]:
        raise ValueError("must be [low, high] with low < high")
    return value


Speed = Annotated[Revolutions, Field(ge=0, le=1e6, description="rotor speed [rpm]")]
Hertz = Annotated[Frequency, Field(gt=0, le=1e6, description="frequency [Hz]")]
FrequencyRange = Annotated[
    tuple[Hertz, ...],
    BeforeValidator(sequence),
    Field(min_length=2, max_length=2),
    AfterValidator(_ascending),
]
Newtons = Annotated[Force, Field(gt=0, le=1e9, description="force [N]")]
Positive = Annotated[int, Field(ge=1, le=1000, description="engine order")]


class CampbellKeys(KeyTable):
    """Campbell diagram: natural frequencies against rotor speed, and engine orders."""

    speeds: Annotated[tuple[Speed, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=2, max_length=2, description="[low, high] rotor speed [rpm]"
    )
    engine_orders: Annotated[tuple[Positive, ...], BeforeValidator(sequence)] = Field(
        default=(1, 2, 3, 4), min_length=1, max_length=20, description="engine orders"
    )
    modes: int = Field(default=4, ge=1, le=40, description="number of modes of a nodal diameter")

    @field_validator("speeds")
    @classmethod
    def _low_high(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        return _ascending(value)

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
    range: Annotated[tuple[Hertz, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=2, max_length=2, description="[low, high] frequency [Hz]"
    )
    record: int | None = Field(
        default=None, ge=1, le=1_000_000, description="number of the record of a Universal File"
    )
    unit: str | None = Field(
        default=None, min_length=1, max_length=40, description="unit of a Universal File's record"
    )
    force: Newtons | None = Field(
        default=None, description="force that a response per force is multiplied by [N]"
    )

    @field_validator("range")
    @classmethod
    def _low_high(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        return _ascending(value)


def curves(value: object) -> object:
    """One table, or a list of them."""
    if isinstance(value, dict | MeasuredCurve):
        return (value,)
    return tuple(value) if isinstance(value, list) else value


Bounds = Annotated[tuple[Any, ...], BeforeValidator(sequence), Field(min_length=2, max_length=2)]


class Varied(KeyTable):
    """Keys that are varied, between which bounds, and from how many starts."""

    parameters: Annotated[tuple[str, ...], BeforeValidator(sequence)] = Field(
        default=("joints.interlock.mu",),
        min_length=1,
        max_length=len(FITTED),
        description="varied keys",
    )
    bounds: dict[str, Bounds] = Field(
        default_factory=dict, description="[low, high] of each varied key"
    )
    starts: int = Field(default=3, ge=1, le=100, description="number of starts")

    allowed: ClassVar[tuple[str, ...]] = ()
    table: ClassVar[str] = ""
    verb: ClassVar[str] = ""

    @field_validator("parameters")
    @classmethod
    def _known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for key in value:
            if key not in cls.allowed:
                raise ValueError(
                    f'"{key}" cannot be {cls.verb}; what can: {", ".join(cls.allowed)}'
                )
        if len(set(value)) < len(value):
            raise ValueError(f"{cls.verb} keys must differ from each other")
        return value

    @field_validator("bounds", mode="before")
    @classmethod
    def _flattened(cls, value: Any) -> Any:
        """Accept `joints.interlock.mu = [...]` without quotes, which TOML nests."""
        return dict(leaves(value)) if isinstance(value, dict) else value

    @field_validator("bounds")
    @classmethod
    def _low_high(cls, value: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        found = {}
        for key, pair in value.items():
            if key not in info.data.get("parameters", cls.allowed):
                raise ValueError(f'"{key}" is not among {cls.table}.parameters')
            try:
                low, high = (si(each, UNITS.get(key.rpartition(".")[2], "")) for each in pair)
            except ValueError as error:
                raise ValueError(f'"{key}" = {list(pair)}: {error}') from None
            numbers = all(
                isinstance(each, int | float) and not isinstance(each, bool) for each in (low, high)
            )
            if not numbers or not low < high:  # type: ignore[operator]
                raise ValueError(f'"{key}" = {list(pair)}: expected [low, high] with low < high')
            found[key] = float(low), float(high)  # type: ignore[arg-type]
        return found


class Fit(Varied):
    """What `vanelock fit` varies so that the response meets the measured curves."""

    allowed: ClassVar[tuple[str, ...]] = FITTED
    table: ClassVar[str] = "fit"
    verb: ClassVar[str] = "fitted"


def _has_a_front_of_the_peak(table: Any) -> Iterator[str]:
    """A front is of what the peak is and wears."""
    if table.front and table.of != "peak":
        yield f'front: given {table.front}: it is of the peak against wear: needs of = "peak"'


class Optimise(Varied):
    """What `vanelock optimise` varies so that the largest peak is the smallest."""

    of: Literal["peak", "upper bound"] = Field(default="peak", description="what is made smallest")
    starts: int = Field(default=32, ge=0, le=1000, description="number of starts")
    front: int = Field(
        default=0, ge=0, le=50, description="number of points of the front of peak against wear"
    )

    allowed: ClassVar[tuple[str, ...]] = tuple(key for key in FITTED if key.startswith("joints."))
    table: ClassVar[str] = "optimise"
    verb: ClassVar[str] = "optimised"
    checks: ClassVar[tuple[Check, ...]] = (_has_a_front_of_the_peak,)


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
    tables = [each for each in (study.fit, study.optimise) if each is not None]
    for table, key in ((each, key) for each in tables for key in each.parameters):
        where = f'{table.table}.parameters: "{key}"'
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
    speeds = None if study.campbell is None else study.campbell.speeds
    if speeds is not None:
        low, high = study.temperature.speeds
        if speeds[0] < low or speeds[1] > high:
            yield (
                f"campbell.speeds = [{speeds[0]:g}, {speeds[1]:g}]: temperatures are given from "
                f"{low:g} to {high:g} rpm"
            )


def _front_wears(study: "Study") -> Iterator[str]:
    if study.optimise is not None and study.optimise.front and not study.wear_coefficients:
        keys = ", ".join(f"joints.{name}.wear_coefficient" for name in study.joint_names)
        yield f"optimise.front: no joint wears: give one of {keys}"


COMPARISON_CHECKS: tuple[Check, ...] = (
    _has_the_gauges,
    _has_measurements,
    _can_be_fitted,
    _front_wears,
    _has_the_temperatures,
)
"""Of a `Study`."""
