"""Tables on a solution that is not unique or not stable: bounds over static friction, stability."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from vanelock.input.schema.structure.structure import KeyTable, sequence


class BoundsKeys(KeyTable):
    """Between which values static friction, which no model determines, may move the peak."""

    joints: (
        Annotated[tuple[Annotated[str, Field(min_length=1)], ...], BeforeValidator(sequence)] | None
    ) = Field(default=None, min_length=1, description="joints of undetermined static friction")
    share: float = Field(default=1.0, ge=0, le=1, description="share of Coulomb's limit")
    starts: int = Field(default=4, ge=0, le=1000, description="number of random starts")
    seed: int = Field(default=1, ge=0, le=2**31 - 1, description="seed")


class StabilityKeys(KeyTable):
    """Whether the ring stays with the periodic wave, all nodal diameters considered."""

    points: Literal["peaks", "all"] = Field(default="peaks", description="points of the response")
    follow: bool = Field(default=False, description="follow an unstable peak in time")
