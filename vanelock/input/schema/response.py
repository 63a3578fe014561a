"""Tables of the study file on the forced response: excitation, damping, frequencies."""

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator

from vanelock.common.quantities import Force, Frequency, Unbalance
from vanelock.input.schema.structure.structure import KeyTable, Listed, ascending

FrequencyList = Listed[Annotated[Frequency, Field(gt=0, description="frequency [Hz]")]]


def _travels(value: int) -> int:
    if value == 0:
        raise ValueError("engine order must not be 0; negative is a backward wave")
    return value


Order = Annotated[
    int, Field(ge=-1000, le=1000, description="engine order"), AfterValidator(_travels)
]


class ExcitationKeys(KeyTable):
    """The travelling radial load on the casing: a force per node, or a rotating unbalance.

    A load too small would drown in the round-off of the static deformation.
    """

    engine_order: Order = Field(default=1, description="engine order")
    force: Force | None = Field(
        default=None, ge=1e-6, le=1e6, description="radial force per node [N]"
    )
    unbalance: Unbalance | None = Field(
        default=None, ge=1e-9, le=100, description="unbalance [kg m]"
    )

    @field_validator("unbalance")
    @classmethod
    def _one_load(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is None:
            return value
        if info.data.get("force") is not None:
            raise ValueError("give either unbalance or excitation.force, not both")
        if abs(info.data.get("engine_order", 1)) != 1:
            raise ValueError("an unbalance excites excitation.engine_order 1 or -1 only")
        return value

    @property
    def force_per_node(self) -> float:
        """Radial force per node, N: 30 N unless the study says otherwise, 0 with an unbalance."""
        if self.unbalance is not None:
            return 0.0
        return 30.0 if self.force is None else self.force


class Damping(KeyTable):
    """Structural damping."""

    ratio: float = Field(default=0.003, gt=0, lt=1, description="damping ratio")
    joints: Literal["open", "stuck"] = Field(
        default="open", description="contacts in the modes that have this ratio"
    )


class ResponseKeys(KeyTable):
    """Where and how finely the forced response is computed."""

    mode: int = Field(default=2, ge=1, le=20, description="mode of interest")
    frequencies: FrequencyList | None = Field(
        default=None, min_length=1, description="excitation frequency [Hz]"
    )
    range: FrequencyList | None = Field(
        default=None, min_length=2, max_length=2, description="[low, high] frequency [Hz]"
    )
    points: int | None = Field(default=None, ge=2, le=100_000, description="number of frequencies")
    direction: Literal["up", "down", "both"] = Field(
        default="up", description="direction of the sweep"
    )
    harmonics: int = Field(default=3, ge=1, le=99, description="highest harmonic")
    friction: Literal["orthogonal", "isotropic"] = Field(
        default="orthogonal", description="friction in the tangential plane"
    )
    coupling: Literal["coupled", "uncoupled", "constant-load"] = Field(
        default="coupled", description="coupling of the static and the dynamic balance"
    )
    samples: int | None = Field(
        default=None, ge=8, le=1_000_000, description="number of samples of a period"
    )

    @field_validator("range", "points")
    @classmethod
    def _on_a_range(cls, value: object, info: ValidationInfo) -> object:
        if value is not None and info.data.get("frequencies") is not None:
            raise ValueError(
                f"give either response.{info.field_name} or response.frequencies, not both"
            )
        return value

    _low_high = field_validator("range")(ascending)

    @field_validator("frequencies")
    @classmethod
    def _ascends(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        if value is not None and any(a >= b for a, b in pairwise(value)):
            raise ValueError("frequencies must ascend")
        return value
