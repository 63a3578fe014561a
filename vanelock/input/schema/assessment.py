"""Tables on what a response is worth: bounds over static friction, and stability."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BeforeValidator, Field

from vanelock.input.schema.structure import KeyTable, sequence

if TYPE_CHECKING:
    from vanelock.input.schema.scene import Scene
    from vanelock.input.schema.study import ResponseKeys, Study


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


ALLOWED = {"coupling": "coupled", "samples": None, "harmonic_diameters": "wave"}
"""What both take of `response`."""


def assessable(response: "ResponseKeys") -> bool:
    """Whether responses of this kind have bounds and stability."""
    return all(getattr(response, key) == allowed for key, allowed in ALLOWED.items())


def can_be_assessed(given: "Study | Scene") -> Iterator[str]:
    """What keeps bounds or stability from being given; cases of a campaign may lack them."""
    response = given.response
    for table in ("bounds", "stability"):
        if getattr(given, table) is None or getattr(given, "campaign", None) is not None:
            continue
        if getattr(given, "elements", None):
            yield f"elements: [{table}] is of contacts alone: leave one of them out"
        for key, allowed in ALLOWED.items():
            value = getattr(response, key)
            if value != allowed:
                must = "leave it out" if allowed is None else f'must be "{allowed}"'
                text = value if isinstance(value, int) else f'"{value}"'
                yield f"response.{key} = {text}: {must} for [{table}]"
    if given.stability is not None and given.stability.points == "all":
        if getattr(given, "accuracy", None) is not None:
            yield 'stability.points = "all": with an accuracy choose "peaks"'
    if given.bounds is not None:
        known = given.joint_names
        for name in given.bounds.joints or ():
            if known and name not in known:
                yield f'bounds.joints: given "{name}": allowed are {", ".join(known)}'
        if response.frequencies is not None and len(response.frequencies) < 2:
            yield "response.frequencies: given one: [bounds] is of a peak, which takes a range"
