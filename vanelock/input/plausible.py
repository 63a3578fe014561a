"""Numbers that are allowed but look like those of another unit: 8.2e-9 for a density in t/mm^3."""

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from vanelock.common.quantities import Bounds, Usual, meant, metadata, number, typical
from vanelock.input.messages import field_at, subject_and_unit


def unusual(table: BaseModel) -> tuple[str, ...]:
    """A line for each number of a study or a scene, swept ones too, that is hardly ever so."""
    found = [*_keys(table, "")]
    for name in ("sweep", "rows"):
        for key, values in getattr(table, name, {}).items():
            field = field_at(tuple(key.split(".")), type(table))
            found += [
                line
                for i, value in enumerate(values)
                for line in _line(f'{name}."{key}"[{i}]', value, field)
            ]
    return tuple(found)


def _keys(value: Any, where: str, field: FieldInfo | None = None) -> Iterator[str]:
    """Everything in a table, a list of tables or named ones."""
    if isinstance(value, BaseModel):
        for name in type(value).model_fields:
            if name in value.model_fields_set:
                key = f"{where}.{name}" if where else name
                yield from _keys(getattr(value, name), key, type(value).model_fields[name])
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from _keys(inner, f"{where}.{name}", field)
    elif isinstance(value, tuple):
        for i, inner in enumerate(value):
            last = inner[-1] if isinstance(inner, tuple) and inner else inner  # of [degC, Pa]
            yield from _keys(last, f"{where}[{i}]", field)
    elif field is not None:
        yield from _line(where, value, field)


def _line(where: str, value: Any, field: FieldInfo | None) -> Iterator[str]:
    if field is None or value is None:
        return
    usual = next((each for each in metadata(field) if isinstance(each, Usual)), None)
    if usual is None:
        return
    size = number(value, field)
    if size == 0 or usual.low <= size <= usual.high:
        return
    subject, unit = (each.strip() for each in subject_and_unit(field))
    other = meant(size, unit, Bounds(usual.low, usual.high, above=False), typical(field))
    hint = f'; "{other}"?' if other else ""
    yield (
        f"{where} = {size:.6g} {unit}: {subject} is hardly ever outside "
        f"{usual.low:g} to {usual.high:g} {unit}{hint}"
    )
