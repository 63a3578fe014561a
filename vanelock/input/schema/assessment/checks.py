"""What keeps the responses of a study or a scene from being assessed."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vanelock.input.schema.assessment.unlike import can_be_unlike
from vanelock.input.schema.response import ResponseKeys

if TYPE_CHECKING:
    from vanelock.input.schema.scene import Scene
    from vanelock.input.schema.study import Study

TABLES = ("bounds", "stability", "unlike", "damped_modes", "wear")
ALLOWED = {"coupling": "coupled", "samples": None, "harmonic_diameters": "wave"}
"""What all take of `response`."""


def assessable(response: ResponseKeys) -> bool:
    """Whether responses of this kind can be assessed."""
    return all(getattr(response, key) == allowed for key, allowed in ALLOWED.items())


def is_assessed(given: "Study | Scene") -> bool:
    """Whether anything is asked for beyond the responses."""
    return any(getattr(given, table, None) is not None for table in TABLES)


def can_be_assessed(given: "Study | Scene") -> Iterator[str]:
    """What keeps these tables from being used."""
    response = given.response
    yield from can_be_unlike(given)
    for table in TABLES:
        if getattr(given, table, None) is None:
            continue
        if getattr(given, "elements", None) and table != "unlike":
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
