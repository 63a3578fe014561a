"""Table of the study file on wear over cycles: what the engine dwells at, one after another."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import BeforeValidator, Field, field_validator

from vanelock.common.checked import Check
from vanelock.input.schema.comparison import Hertz, ascending
from vanelock.input.schema.structure.structure import KeyTable, sequence

if TYPE_CHECKING:
    from vanelock.input.schema.study import Study


class DwellKeys(KeyTable):
    """Vibration that stays at a frequency, or at the peak of a range wherever that moves."""

    cycles: float = Field(gt=0, le=1e15, description="number of cycles")
    frequency: Hertz | None = Field(default=None, description="frequency [Hz]")
    range: Annotated[tuple[Hertz, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=2, max_length=2, description="[low, high] frequency [Hz]"
    )
    load: float = Field(default=1.0, gt=0, le=1e6, description="load over that of the study")

    @field_validator("range")
    @classmethod
    def _low_high(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        return ascending(value)

    def _one_place(self) -> Iterator[str]:
        if self.frequency is not None and self.range is not None:
            yield f"range = {list(self.range)}: give either this or frequency, not both"

    checks: ClassVar[tuple[Check, ...]] = (_one_place,)


class WearKeys(KeyTable):
    """How contacts wear over cycles, and how the vibration changes with them."""

    dwells: Annotated[tuple[DwellKeys, ...], BeforeValidator(sequence)] = Field(
        min_length=1, max_length=1000, description="dwells"
    )
    step: float = Field(
        default=0.05, gt=0, le=0.5, description="largest relative change of interference in a step"
    )


def can_wear(study: "Study") -> Iterator[str]:
    """What keeps joints from wearing."""
    front = study.optimise is not None and study.optimise.front
    for asks, table in ((study.wear is not None, "wear"), (front, "optimise.front")):
        if asks and not study.wear_coefficients:
            keys = ", ".join(f"joints.{name}.wear_coefficient" for name in study.joint_names)
            yield f"{table}: no joint wears: give one of {keys}"
