"""Schema errors in words: full key, value given, what is allowed, nearest known key."""

import difflib
import re
from dataclasses import replace
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from vanelock.common.checked import Disagreement, walked
from vanelock.common.errors import MOST_MISTAKES, cut_short, printable
from vanelock.common.quantities import bounds, meant, typical
from vanelock.common.tables import counted
from vanelock.input.schema.structure.own_mesh import DIMENSIONS, OWN
from vanelock.input.schema.study import Study

Location = tuple[int | str, ...]
_KEY = "[key]"  # pydantic's place of a name that is itself wrong
ANY = "<name>"
"""Stands in a schema's keys for a name that the user gives to a table."""

_BOUNDS = {
    "greater_than": ("gt", ">"),
    "greater_than_equal": ("ge", ">="),
    "less_than": ("lt", "<"),
    "less_than_equal": ("le", "<="),
}
_TYPES = {
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "string": "text",
    "tuple": "a list",
    "dict": "a table",
    "model": "a table",
    "finite_number": "a finite number",
}


def explain(
    error: ValidationError, data: dict[str, Any], schema: type[BaseModel] = Study
) -> list[str]:
    """One line for each mistake that pydantic found in the study `data`, or in another schema's."""
    lines, more = described(mistakes(error), data, schema)
    return [*lines, f"and {counted(more, 'more mistake')}"] if more else lines


def described(
    every: list[ErrorDetails], data: dict[str, Any], schema: type[BaseModel]
) -> tuple[list[str], int]:
    """A line for each of the first mistakes, in the order of the file, and how many are left."""
    lines: dict[str, None] = {}
    order = Order(data)
    every = sorted(every, key=lambda details: order.of(details["loc"]))
    for i, details in enumerate(every):
        if len(lines) >= MOST_MISTAKES:  # to find a similar key takes long
            return list(lines), len(every) - i
        lines |= dict.fromkeys(map(cut_short, _mistakes(details, data, schema)))
    return list(lines), 0


def _mistakes(details: ErrorDetails, data: dict[str, Any], schema: type[BaseModel]) -> list[str]:
    """One mistake, or each contradiction in a table."""
    location = details["loc"]
    error = details.get("ctx", {}).get("error")
    if isinstance(error, Disagreement):
        return [_within(location, line, schema) for line in error.lines]
    value = _given(data, location, details["input"])
    text = reason(details, schema, value)
    if location and not isinstance(value, dict | BaseModel):
        return [f"{dotted(location)} = {show(value)}: {text}"]
    return [_within(location, text, schema)]


def _within(location: Location, text: str, schema: type[BaseModel]) -> str:
    """What is said of a table, which names one of its keys or not."""
    if not location:
        return text
    names = re.match(r"[\w.]+(?= = |: )", text)
    inner = names is not None and field_at((*location, *names[0].split(".")), schema)
    return f"{dotted(location)}{'.' if inner else ': '}{text}"


_LEADING = re.compile(r"""[A-Za-z_][\w-]*(?:\.(?:[\w-]+|"[^"]*")|\[\d+\])*""")
_ITEM = re.compile(r"""\[(\d+)\]|"([^"]*)"|([\w-]+)""")


class Order:
    """Where things stand in nested tables: a sortable place for a key, as a path or as text."""

    def __init__(self, data: dict[str, Any]) -> None:
        self._data = data
        self._ranks: dict[int, dict[str, int]] = {}

    def of(self, location: Location) -> tuple[int, ...]:
        """Place of a path; a key that is not given stands at the head of its table."""
        place = []
        for table, item in walked(self._data, location):
            if isinstance(table, dict):
                place.append(self._ranked(table).get(str(item), -1))
            elif isinstance(item, int):
                place.append(item)
        return tuple(place)

    def _ranked(self, table: dict[str, Any]) -> dict[str, int]:
        if id(table) not in self._ranks:
            self._ranks[id(table)] = {key: i for i, key in enumerate(table)}
        return self._ranks[id(table)]

    def of_line(self, line: str) -> tuple[int, ...]:
        """Place of the key that a line names first."""
        found = _LEADING.search(line)
        items = _ITEM.findall(found[0]) if found else []
        return self.of(tuple(int(i) if i else quoted or word for i, quoted, word in items))


def mistakes(error: ValidationError) -> list[ErrorDetails]:
    """What pydantic found, in places that name keys only."""
    every = error.errors(include_url=False)
    within = {details["loc"][:-1] for details in every if details["loc"]}
    # of a list with wrong entries pydantic counts the right ones alone
    found = [each for each in every if not (each["type"] == "too_short" and each["loc"] in within)]
    for details in found:
        details["loc"] = tuple(i for i in details["loc"] if i not in (DIMENSIONS, OWN, _KEY))
    return found


def _given(data: Any, location: Location, converted: Any) -> Any:
    """The value as the study gives it, before its unit was converted."""
    try:
        for item in location:
            data = data[item]
    except (KeyError, IndexError, TypeError):
        return converted
    return data


def reason(details: ErrorDetails, schema: type[BaseModel] = Study, given: object = None) -> str:
    """What is wrong with a value and what is allowed, and the unit that was meant, if any was."""
    kind, location = details["type"], details["loc"]
    context = details.get("ctx", {})
    field = field_at(location, schema)
    subject, unit = subject_and_unit(field, location)
    if kind == "extra_forbidden":
        return unknown(location, schema)
    if kind == "missing":
        return "must be given"
    if kind in _BOUNDS:
        name, sign = _BOUNDS[kind]
        text = f"{subject} must be {sign} {_number(context[name])}{unit}"
        return text + _suggested(given, unit.strip(), field, details)
    if kind == "literal_error":
        return f"{subject} must be one of {context['expected']}".replace("'", '"')
    if kind in ("too_short", "too_long"):
        allowed = context.get("min_length", context.get("max_length"))
        bound = "at least" if kind == "too_short" else "at most"
        return f"{subject}: expected {bound} {allowed} of them"
    if kind in ("string_too_short", "string_too_long"):
        allowed = context.get("min_length", context.get("max_length"))
        bound = "at least" if kind == "string_too_short" else "at most"
        return f"{subject} must have {bound} {allowed} characters"
    expected = _TYPES.get(kind.removesuffix("_type").removesuffix("_parsing"))
    if expected:
        return f"expected {expected}"
    return details["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")


def _suggested(given: object, unit: str, field: FieldInfo | None, details: ErrorDetails) -> str:
    """The number with the unit in which it would be allowed."""
    if isinstance(given, bool) or not isinstance(given, int | float) or field is None:
        return ""
    allowed, name = bounds(field), _BOUNDS[details["type"]][0]
    limit = float(details.get("ctx", {})[name])
    if name in ("gt", "ge"):
        allowed = replace(allowed, low=max(limit, allowed.low))
    else:
        allowed = replace(allowed, high=min(limit, allowed.high))
    other = meant(given, unit, allowed, typical(field))
    return f'; {given:.12g} is {given:.12g} {unit}: "{other}"?' if other else ""


def dotted(location: Location) -> str:
    """Key as a user writes it: `joints.interlock.mu`, `response.frequencies[2]`."""
    text = ""
    for item in location:
        if isinstance(item, int):
            text += f"[{item}]"
        else:
            bare = item.replace("_", "").replace("-", "").isalnum() and item.isascii()
            shown = item if len(item) <= 60 else item[:57] + "..."
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
    text = printable(text)
    return text if len(text) <= 60 else text[:57] + "..."


def known_keys(table: type[BaseModel] = Study, prefix: str = "") -> list[str]:
    """Every dotted key of the schema, tables included, sweep entries apart."""
    keys = []
    for name, field in table.model_fields.items():
        keys.append(prefix + name)
        below = f"{prefix}{name}.{ANY}." if _names_tables(field) else f"{prefix}{name}."
        for inner in _tables(field):
            keys += known_keys(inner, below)
    return list(dict.fromkeys(keys))


def unknown(location: Location, schema: type[BaseModel] = Study) -> str:
    """Hint for an unknown key: a similar one beside it, else the same elsewhere, else its table."""
    *path, key = [item[:60] for item in location if isinstance(item, str)]
    prefix = "".join(f"{item}." for item in _general(path, schema))
    every = known_keys(schema)
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


def _general(path: list[str], schema: type[BaseModel]) -> list[str]:
    """A path of keys with the names that a user gives to tables replaced."""
    found: list[str] = []
    for i, item in enumerate(path):
        above = field_at(tuple(path[:i]), schema) if i else None
        given = above is not None and _names_tables(above) and (not found or found[-1] != ANY)
        found.append(ANY if given else item)
    return found


def _names_tables(field: FieldInfo) -> bool:
    """Whether a field holds tables under names that the user gives."""
    return get_origin(field.annotation) is dict


def _tables(field: FieldInfo) -> list[type[BaseModel]]:
    """The tables that a field may hold."""
    found = []
    for option in (field.annotation, *get_args(field.annotation)):
        kind = get_args(option)[0] if get_origin(option) is Annotated else option
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            found.append(kind)
    return found


def field_at(location: Location, schema: type[BaseModel] = Study) -> FieldInfo | None:
    """The schema's field at a location; list entries and named tables belong to their field."""
    tables: list[type[BaseModel]] = [schema]
    field, named = None, False
    for item in location:
        if isinstance(item, int):
            continue
        if field is not None and _names_tables(field) and not named:
            named = True  # a name that the user gives
            continue
        fields = [table.model_fields[item] for table in tables if item in table.model_fields]
        if not fields:
            return None
        field, named = fields[0], False
        tables = [table for each in fields for table in _tables(each)]
    return field


def unit_of(key: str) -> str:
    """Unit of a key's number, "" where it has none."""
    return subject_and_unit(field_at(tuple(key.split("."))), ())[1].strip()


def subject_and_unit(field: FieldInfo | None, location: Location = ()) -> tuple[str, str]:
    """What a field's description calls it, and its unit, which stands there in brackets."""
    text = (field.description if field else None) or str(location[-1] if location else "study")
    subject, _, unit = text.partition(" [")
    return subject, f" {unit.rstrip(']')}" if unit else ""


def _number(value: object) -> str:
    return f"{value:.12g}" if isinstance(value, int | float) else str(value)
