"""Tables of the study file on what is shown: monitored displacement, gauges, pictures."""

import re
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator

from vanelock.common.cyclic import COMPONENTS
from vanelock.common.quantities import Length, number_within
from vanelock.input.schema.structure.structure import KeyTable, Listed

MONITOR = (
    rf"(?P<node>(?:vane|casing) output [1-9][0-9]*)(?:, (?P<component>{'|'.join(COMPONENTS)}))?"
)

MONITORED = (
    'expected an output node and a component, such as "vane output 1, radial" '
    "(vane or casing; output 1 to 3; radial, circumferential or axial)"
)


def _direction(value: object) -> object:
    """Pass "span" and "chord"; anything else is an angle in degrees."""
    if value in ("span", "chord"):
        return value
    needed = (
        'gauge direction must be "span", "chord" or the angle from the former to the latter, '
        "-180 to 180 deg"
    )
    return number_within(value, "deg", -180, 180, needed)


class GaugeKeys(KeyTable):
    """A strain gauge on an aerofoil of the vane."""

    aerofoil: int = Field(ge=1, description="number of the aerofoil")
    span: float = Field(ge=0, le=1, description="fraction of the span")
    chord: float = Field(ge=0, le=1, description="fraction of the chord")
    side: Literal["suction", "pressure"] = Field(default="suction", description="side")
    direction: Annotated[Any, BeforeValidator(_direction)] = Field(
        default="span", description="direction"
    )
    length: Length = Field(default=0.002, ge=1e-5, le=0.05, description="gauge length [m]")


class Outputs(KeyTable):
    """What a run shows of its results."""

    monitor: str | None = Field(default=None, description="monitored displacement")
    show: Listed[Literal["shapes", "loops", "animations", "report"]] = Field(
        default=("shapes", "loops", "report"), description="what is drawn and written"
    )
    gauges: Listed[GaugeKeys] = Field(default=(), max_length=100, description="strain gauges")

    @field_validator("monitor")
    @classmethod
    def _named(cls, value: str | None) -> str | None:
        if value is not None and not re.fullmatch(MONITOR, value):
            raise ValueError(MONITORED)
        return value
