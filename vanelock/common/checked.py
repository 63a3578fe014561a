"""Tables of an input file whose keys must agree with one another.

A library that validates stops a table's own checks at the table's first wrong key, and those of the
table around it too, so that one wrong number hides every other mistake. Here wrong keys are left
out and marked, and each check that does not read them is made all the same.
"""

import copy
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

from pydantic import (
    BaseModel,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import ErrorDetails

from vanelock.common.errors import InputError

T = TypeVar("T", bound="Checked")
Check = Callable[[Any], Iterable[str] | None]
UNCHECKED = "unchecked"
"""Context of a validation that looks at each key alone."""
MOST_ROUNDS = 50
"""Times that mistakes are left out; each table within another takes two."""


class NotKnown(Exception):
    """A key was read whose value is wrong."""


class Disagreement(ValueError):
    """Keys of a table contradict one another: `lines` says how, each from the table's key on."""

    def __init__(self, lines: list[str]) -> None:
        super().__init__("\n".join(lines))
        self.lines = lines


class Checked(BaseModel):
    """A table and its checks, functions of it that yield a line for each contradiction."""

    checks: ClassVar[tuple[Check, ...]] = ()

    @model_validator(mode="wrap")
    @classmethod
    def _agrees(
        cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo
    ) -> Self:
        table = handler(data)
        if info.context == UNCHECKED:
            return table
        mark = (info.context or {}).get(id(data))
        if info.context:
            _forget(table, data, mark, info.context)
        if (mark is None or not mark.checked) and (lines := disagreements(table, cls.checks)):
            raise Disagreement(lines)
        return table

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Pydantic asks here for what is not there."""
            if name in type(self).model_fields:
                raise NotKnown(name)
            return super().__getattr__(name)


@dataclass
class _Mark:
    """What was found in a table: keys that are wrong, or contradictions."""

    wrong: set[str] = field(default_factory=set)
    checked: bool = False


def disagreements(table: Any, checks: Iterable[Check]) -> list[str]:
    """What a table's checks say; one that reads a wrong key, or raises `InputError`, ends there."""
    lines: list[str] = []
    for check in checks:
        try:
            for line in check(table) or ():
                lines.append(line)
        except NotKnown:
            continue
        except InputError as error:
            lines += str(error).splitlines()
    return list(dict.fromkeys(lines))


def examined(
    schema: type[T],
    data: dict[str, Any],
    mistakes: Callable[[ValidationError], list[ErrorDetails]],
) -> tuple[T | None, list[ErrorDetails]]:
    """What a schema makes of nested tables, as far as they are right, and what is wrong.

    Of the table that comes back a key that was wrong cannot be read: `NotKnown`. `mistakes` are
    those of an error, in places that name keys only.
    """
    data = copy.deepcopy(data)
    marks: dict[int, _Mark] = {}
    found: list[ErrorDetails] = []
    for _ in range(MOST_ROUNDS):
        try:
            return schema.model_validate(data, strict=True, context=marks or None), found
        except ValidationError as error:
            every = mistakes(error)
        ways = [_way(data, details["loc"]) for details in every]
        found += [
            details
            for details, way in zip(every, ways, strict=True)
            if details["type"] not in ("missing", "too_short")
            or not (_is_wrong(way[-1], marks) or id(_inner(*way[-1])) in marks)  # but was left out
        ]
        if not all([_leave_out(data, marks, *each) for each in zip(every, ways, strict=True)]):
            break
    return None, found


_Way = list[tuple[dict[str, Any], str]]
"""Tables from the outermost on, each with its key that leads on."""


def walked(data: Any, location: Iterable[int | str]) -> Iterator[tuple[Any, int | str]]:
    """Tables and lists from the outermost on, each with what leads on, as far as it is there.

    A name with dots that is not there as it is has been written without quotes, and TOML nests it.
    """
    waiting = list(location)
    while waiting:
        item = waiting.pop(0)
        if isinstance(data, dict) and item not in data and "." in str(item):
            waiting = [*str(item).split("."), *waiting]
            continue
        yield data, item
        data = _inner(data, item)


def _inner(data: Any, item: int | str) -> Any:
    """None where there is none."""
    try:
        return data[item]
    except (KeyError, IndexError, TypeError):
        return None


def _way(data: dict[str, Any], location: tuple[int | str, ...]) -> _Way:
    return [(table, str(key)) for table, key in walked(data, location) if isinstance(table, dict)]


def _is_wrong(place: tuple[dict[str, Any], str], marks: dict[int, _Mark]) -> bool:
    table, key = place
    return id(table) in marks and key in marks[id(table)].wrong


def _leave_out(
    data: dict[str, Any], marks: dict[int, _Mark], details: ErrorDetails, way: _Way
) -> bool:
    """Mark what is wrong, and take a wrong value out; false where it cannot be found."""
    if isinstance(details.get("ctx", {}).get("error"), Disagreement):
        table: Any = data
        for outer, item in walked(data, details["loc"]):
            table = _inner(outer, item)
        mark = marks.setdefault(id(table), _Mark())
        if not mark.checked:
            mark.checked = True
            return True
    if details["type"] == "missing":
        way = way[:-1]  # a table without what it needs is left out as a whole
    for table, key in reversed(way):
        if key in table:
            del table[key]
            marks.setdefault(id(table), _Mark()).wrong.add(key)
            return True
        if _is_wrong((table, key), marks):  # by another mistake in it
            return True
    return False


def _forget(table: BaseModel, data: Any, mark: _Mark | None, marks: dict[int, _Mark]) -> None:
    """Take wrong keys' defaults out of a table, and lists of names that had wrong entries only."""
    for name in mark.wrong if mark else ():
        table.__dict__.pop(name, None)
    for name, value in list(table.__dict__.items()):
        if value == {} and isinstance(data, dict) and id(data.get(name)) in marks:
            del table.__dict__[name]
