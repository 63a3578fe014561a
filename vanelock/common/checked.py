"""Tables of an input file: checks of keys that must agree, and each mistake as one clear line.

Pydantic holds each key against its type and its limits. A line of the answer has the full key, the
value given, what is allowed, and for a misspelt key the nearest one that is known. A table's checks
are made where each of its keys is right in itself.
"""

import difflib
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Self, get_args, get_origin

from pydantic import BaseModel, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, PydanticCustomError

from vanelock.common.errors import MOST_MISTAKES, InputError, cut_short, printable
from vanelock.common.quantities import bounds, is_number, meant
from vanelock.common.tables import counted

Location = tuple[int | str, ...]
Schema = type[BaseModel]
Check = Callable[[Any], Iterable[str] | None]
ANY = "<name>"
"""Stands in a schema's keys for a name that the user gives to a table."""
DIMENSIONS, OWN = "<dimensions>", "<own mesh>"
PLAIN, OTHER = "<plain>", "<other>"
"""How pydantic marks in an error's place which of two forms a value was taken for."""
_NO_KEYS = (DIMENSIONS, OWN, PLAIN, OTHER, "[key]")

_BOUNDS = {
    "greater_than": ("gt", ">"),
    "greater_than_equal": ("ge", ">="),
    "less_than": ("lt", "<"),
    "less_than_equal": ("le", "<="),
}
_SAID = {
    "missing": "must be given",
    "literal_error": "{subject} must be one of {expected}",
    "too_short": "{subject}: expected at least {min_length} of them",
    "too_long": "{subject}: expected at most {max_length} of them",
    "string_too_short": "{subject} must have at least {min_length} characters",
    "string_too_long": "{subject} must have at most {max_length} characters",
    "finite_number": "expected a finite number",
}
_TYPES = {
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "string": "text",
    "tuple": "a list",
    "dict": "a table",
    "model": "a table",
}


_DISAGREE = "disagreement"
"""The type of pydantic's error where keys of a table contradict one another."""


class Checked(BaseModel):
    """A table and its checks, functions of it that yield a line for each contradiction."""

    checks: ClassVar[tuple[Check, ...]] = ()

    @model_validator(mode="after")
    def _agrees(self) -> Self:
        if lines := disagreements(self, self.checks):
            raise PydanticCustomError(_DISAGREE, "{lines}", {"lines": "\n".join(lines)})
        return self


def disagreements(table: Any, checks: Iterable[Check]) -> list[str]:
    """What a table's checks say; one that raises `InputError` ends there."""
    lines: list[str] = []
    for check in checks:
        try:
            for line in check(table) or ():
                lines.append(line)
        except InputError as error:
            lines += str(error).splitlines()
    return list(dict.fromkeys(lines))


def explain(error: ValidationError, data: dict[str, Any], schema: Schema) -> list[str]:
    """One line for each mistake that pydantic found in nested tables, and how many more."""
    lines: dict[str, None] = {}
    every = mistakes(error)
    for i, details in enumerate(every):
        if len(lines) >= MOST_MISTAKES:  # to find a similar key takes long
            return [*lines, f"and {counted(len(every) - i, 'more mistake')}"]
        lines |= dict.fromkeys(map(cut_short, _lines(details, data, schema)))
    return list(lines)


def mistakes(error: ValidationError) -> list[ErrorDetails]:
    """What pydantic found, in places that name keys only."""
    every = error.errors(include_url=False)
    within = {details["loc"][:-1] for details in every if details["loc"]}
    # of a list with wrong entries pydantic counts the right ones alone
    found = [each for each in every if not (each["type"] == "too_short" and each["loc"] in within)]
    for details in found:
        details["loc"] = tuple(i for i in details["loc"] if i not in _NO_KEYS)
    return found


def _lines(details: ErrorDetails, data: dict[str, Any], schema: Schema) -> list[str]:
    """One mistake, or each contradiction in a table."""
    location = details["loc"]
    if details["type"] == _DISAGREE:
        return [_within(location, line, schema) for line in details["msg"].splitlines()]
    value = value_in(data, location, details["input"])
    text = reason(details, schema, value)
    if location and not isinstance(value, dict | BaseModel):
        return [f"{dotted(location)} = {show(value)}: {text}"]
    return [_within(location, text, schema)]


def _within(location: Location, text: str, schema: Schema) -> str:
    """What is said of a table, which names one of its keys or not."""
    if not location:
        return text
    names = re.match(r"[\w.]+(?= = |: )", text)
    inner = names is not None and field_at((*location, *names[0].split(".")), schema)
    return f"{dotted(location)}{'.' if inner else ': '}{text}"


def value_in(data: Any, location: Location, otherwise: Any = None) -> Any:
    """The value at a place of nested tables, as a file gives it."""
    try:
        for item in location:
            data = data[item]
    except (KeyError, IndexError, TypeError):
        return otherwise
    return data


def reason(details: ErrorDetails, schema: Schema, argument: object = None) -> str:
    """What is wrong with a value and what is allowed, and the unit that was meant, if any was."""
    kind, location = details["type"], details["loc"]
    context = details.get("ctx", {})
    field = field_at(location, schema)
    subject, unit = subject_and_unit(field, location)
    if kind == "extra_forbidden":
        return unknown(location, schema)
    if kind in _BOUNDS:
        name, sign = _BOUNDS[kind]
        limit = f"{subject} must be {sign} {context[name]:.12g} {unit}".rstrip()
        return limit + _suggested(argument, unit, field, name, float(context[name]))
    if kind in _SAID:
        quoted = {name: str(value).replace("'", '"') for name, value in context.items()}
        return _SAID[kind].format(subject=subject, **quoted)
    if expected := _TYPES.get(kind.removesuffix("_type").removesuffix("_parsing")):
        return f"expected {expected}"
    return details["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")


def _suggested(value: object, unit: str, field: FieldInfo | None, bound: str, limit: float) -> str:
    """The number with the unit in which it would be allowed."""
    if not is_number(value) or field is None:
        return ""
    allowed = bounds(field)
    if bound in ("gt", "ge"):
        allowed = replace(allowed, low=max(limit, allowed.low))
    else:
        allowed = replace(allowed, high=min(limit, allowed.high))
    other = meant(value, unit, allowed, field)
    return f'; {value:.12g} is {value:.12g} {unit}: "{other}"?' if other else ""


def dotted(location: Location) -> str:
    """Key as a user writes it: `damping.ratio`, `response.frequencies[2]`."""
    text = ""
    for item in location:
        if isinstance(item, int):
            text += f"[{item}]"
        else:
            bare = item.replace("_", "").replace("-", "").isalnum() and item.isascii()
            shown = cut_short(item, 60)
            text += ("." if text else "") + (shown if bare else f'"{printable(shown)}"')
    return text


def show(value: object) -> str:
    """A value as TOML writes it, shortened to fit a line."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = '"' + value[:60].replace("\n", " ") + '"'
    elif isinstance(value, list | tuple):
        text = "[" + ", ".join(show(item) for item in value[:60]) + "]"
    else:
        text = str(value).replace("\n", " ")
    return cut_short(printable(text), 60)


def _known_keys(schema: Schema, prefix: str = "") -> list[str]:
    """Every dotted key of a schema, tables included, sweep entries apart."""
    keys = []
    for name, field in schema.model_fields.items():
        keys.append(prefix + name)
        below = f"{prefix}{name}.{ANY}." if _names_tables(field) else f"{prefix}{name}."
        for inner in _tables(field):
            keys += _known_keys(inner, below)
    return list(dict.fromkeys(keys))


def unknown(location: Location, schema: Schema) -> str:
    """Hint for an unknown key: a similar one beside it, else the same elsewhere, else its table."""
    *path, key = [item[:60] for item in location if isinstance(item, str)]
    prefix = "".join(f"{name}." for name, _ in _way(path, schema))
    every = _known_keys(schema)
    beside = [k for k in every if k.startswith(prefix) and "." not in k[len(prefix) :]]
    names = {k[len(prefix) :].lower(): k for k in beside}
    elsewhere: dict[str, str] = {}
    for k in every:
        elsewhere.setdefault(k.rpartition(".")[2].lower(), k)
    if close := difflib.get_close_matches(key.lower(), names, 1):
        nearest = names[close[0]]
    elif close := difflib.get_close_matches(key.lower(), elsewhere, 1, cutoff=0.75):
        nearest = elsewhere[close[0]]
    elif not beside and (close := difflib.get_close_matches(prefix + key, every, 1)):
        nearest = close[0]
    else:
        here = ", ".join(k[len(prefix) :] for k in beside)
        return f"unknown key; known here: {here}" if here else "unknown key"
    return f"unknown key; nearest known key: {nearest}"


def _names_tables(field: FieldInfo) -> bool:
    """Whether a field holds tables under names that the user gives."""
    return get_origin(field.annotation) is dict


def _tables(field: FieldInfo) -> list[Schema]:
    """The tables that a field may hold."""
    kinds = (kind for kind in kinds_of(field) if isinstance(kind, type))
    return list(dict.fromkeys(kind for kind in kinds if issubclass(kind, BaseModel)))


def kinds_of(field: FieldInfo) -> list[Any]:
    """What a field may hold, be it optional or annotated once more."""
    options = [field.annotation, *get_args(field.annotation)]
    return options + [inner for option in options for inner in get_args(option)[:1]]


def field_at(location: Location, schema: Schema) -> FieldInfo | None:
    """The schema's field at a location; list entries and named tables belong to their field."""
    fields = [field for _, field in _way(location, schema)]
    return fields[-1] if fields else None


def _way(location: Sequence[int | str], schema: Schema) -> Iterator[tuple[str, FieldInfo | None]]:
    """Keys down to a location, `ANY` for names that the user gives to tables, and their fields."""
    tables: list[Schema] = [schema]
    field, named = None, False
    for item in location:
        if isinstance(item, int):
            continue
        named = field is not None and _names_tables(field) and not named
        if not named:
            fields = [table.model_fields[item] for table in tables if item in table.model_fields]
            field = fields[0] if fields else None
            tables = [table for each in fields for table in _tables(each)]
        yield ANY if named else item, field


def subject_and_unit(field: FieldInfo | None, location: Location = ()) -> tuple[str, str]:
    """What a field's description calls it, and its unit, which stands there in brackets."""
    text = (field.description if field else None) or str(location[-1] if location else "study")
    subject, _, unit = text.partition(" [")
    return subject, unit.rstrip("]")
