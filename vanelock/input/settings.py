"""The settings of a study or scene as flat lists: each key with its value in people's units."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic.fields import FieldInfo

from vanelock.common.checked import field_at, show, subject_and_unit
from vanelock.common.quantities import Usual, is_number, meant, metadata, number
from vanelock.input.cases.names import scaled
from vanelock.input.cases.values import Problem, path_of
from vanelock.input.schema.response import ExcitationKeys
from vanelock.input.schema.structure.structure import PER_AREA, leaves
from vanelock.input.schema.study import Study

Flat = dict[str, Any]
SCATTERING = "scatter.keys."


@dataclass(frozen=True)
class Setting:
    """One key of a study.

    Attributes
    ----------
    key : str
        Dotted.
    value : number, str, bool, list or None
        As the study holds it, SI.
    default : the same
        What it is unless a study says otherwise; None where there is no default.
    schema : type
        Whose key it is.
    """

    key: str
    value: Any
    default: Any
    schema: type[Problem] = Study

    @property
    def changed(self) -> bool:
        """Whether it is not the default; what is not set is."""
        return self.value is not None and not same(self.value, self.default)


def same(one: Any, other: Any) -> bool:
    """Whether two values are equal, numbers to 12 digits."""
    if isinstance(one, float) and isinstance(other, int | float):
        return f"{one:.12g}" == f"{other:.12g}"
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def flattened(tables: dict[str, Any]) -> Flat:
    """Dotted keys and values of nested tables; the sweep's keys are dotted already."""
    return {key: list(v) if isinstance(v, tuple) else v for key, v in leaves(tables)}


def settings(problem: Problem) -> list[Setting]:
    """All keys of a study or scene, in the order of its file."""
    schema, dumped = type(problem), problem.model_dump(mode="json")
    tables = dumped if isinstance(problem, Study) else _numbered(dumped)
    return [
        Setting(key, value, _default(key, schema), schema)
        for key, value in flattened(tables).items()
    ]


def unusual(problem: Problem) -> tuple[str, ...]:
    """A line for each number that is allowed but looks like one of another unit: 8.2e-9 t/mm^3.

    Of the keys that a file sets, swept ones too.
    """
    found = []
    for key, value in flattened(_numbered(problem.model_dump(exclude_unset=True))).items():
        field = _field(key, type(problem))
        usual = next((e for e in metadata(field) if isinstance(e, Usual)), None) if field else None
        if field is None or usual is None or value is None:
            continue
        where = f'{key.partition(".")[0]}."{swept}"' if (swept := _listed_key(key)) != key else key
        for i, each in enumerate(value if isinstance(value, list) else [value]):
            last = each[-1] if isinstance(each, list | tuple) else each  # of [degC, Pa]
            if isinstance(last, str) and last.endswith(PER_AREA):  # says its unit
                continue
            size = number(last, field)
            if size == 0 or usual.low <= size <= usual.high:
                continue
            subject, unit = subject_and_unit(field)
            other = meant(size, unit, usual, field)
            found.append(
                f"{where}{f'[{i}]' if isinstance(value, list) else ''} = {size:.6g} {unit}: "
                f"{subject} is hardly ever outside {usual.low:g} to {usual.high:g} {unit}"
                + (f'; "{other}"?' if other else "")
            )
    return tuple(found)


def _numbered(table: Any) -> Any:
    """Lists of tables as tables by their places."""
    if isinstance(table, Mapping):
        found: dict[str, Any] = {}
        for key, value in table.items():
            if isinstance(value, list) and value and isinstance(value[0], Mapping):
                found |= {f"{key}[{i}]": _numbered(each) for i, each in enumerate(value)}
            else:
                found[key] = _numbered(value)
        return found
    return table


def _default(key: str, schema: type[Problem]) -> Any:
    """What a key is unless it is set."""
    if key == "excitation.force":
        return ExcitationKeys().force_per_node
    field = _field(key, schema)
    value = None if field is None or field.is_required() else field.get_default()
    return list(value) if isinstance(value, tuple) else value


def _field(key: str, schema: type[Problem]) -> FieldInfo | None:
    """The schema's field of a dotted key, be it swept, in rows, or part of a distribution."""
    if key.startswith(SCATTERING):
        return field_at(("scatter", "keys", "key", key.rpartition(".")[2]), schema)
    return field_at(path_of(_listed_key(key)), schema)


def _listed_key(key: str) -> str:
    """The key that a list of values in `sweep` or `rows` is of."""
    return key.removeprefix("sweep.").removeprefix("rows.")


def meaning_and_unit(key: str, schema: type[Problem] = Study) -> tuple[str, str]:
    """What a key is, and its unit in SI, "" where it has none."""
    swept = _listed_key(key)
    words = swept.rpartition(".")[2].replace("_", " ")
    meaning, unit = subject_and_unit(_field(key, schema), (words,))
    return (f"swept: {meaning}" if swept != key else meaning), unit


def unit_of(key: str, schema: type[Problem] = Study) -> str:
    """The SI unit of a key, "" where it has none; a size of a mesh may be a word besides."""
    return "m" if key == "mesh.size" else meaning_and_unit(key, schema)[1]


def as_text(key: str, value: Any, schema: type[Problem] = Study) -> str:
    """A value with its unit, as people write it; a list in the unit of its largest entry."""
    unit = unit_of(key, schema)
    if value is None:
        return "not set"
    if isinstance(value, bool):
        return "yes" if value else "no"
    numbers = value if isinstance(value, list) else [value]
    if numbers and all(map(is_number, numbers)):
        factor, shown = scaled(max(map(abs, numbers)), unit)
        text = ", ".join(f"{factor * number:.10g}" for number in numbers)
        return f"{text}°" if shown == "°" else f"{text} {shown}".rstrip()
    return value if isinstance(value, str) else show(value)
