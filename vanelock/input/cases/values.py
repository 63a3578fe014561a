"""Values of a study or scene by dotted keys, such as "loads[0].amplitude", read off and put in."""

import re
from collections.abc import Hashable
from typing import Any, TypeAlias, TypeVar, cast, get_origin

from vanelock.common.checked import Location, dotted
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.common.files.hdf5 import opened
from vanelock.input.schema.scene import Scene
from vanelock.input.schema.structure.structure import KeyTable
from vanelock.input.schema.study import Study

Problem: TypeAlias = Study | Scene
"""What a file says."""
G = TypeVar("G", bound=Problem)

VARIED = {"sweep", "rows", "scatter"}
"""Tables of what cases differ in, which a case has not."""
_STEP = re.compile(r'(?:"([^"]+)"|([^."\[\]]+))((?:\[\d+\])*)')
_WORD = re.compile(r'(?:"[^"]*"|[^."])+')


def path_of(key: str) -> Location:
    """Names and places on the way to a key; a key that is not written as one stays whole.

    >>> path_of('loads.pressure."BLADE-1.SUCTION"'), path_of("measured[1].file")
    (('loads', 'pressure', 'BLADE-1.SUCTION'), ('measured', 1, 'file'))
    """
    path: list[str | int] = []
    for word in (words := _WORD.findall(key)):
        found = _STEP.fullmatch(word)
        if found is None:
            return (key,)
        path += [found[1] or found[2], *(int(i) for i in re.findall(r"\d+", found[3]))]
    return tuple(path) if ".".join(words) == key else (key,)


def value_at(problem: Problem, key: str) -> Any:
    """Value of a dotted key, None where there is none."""
    value: Any = problem
    for item in path_of(key):
        if isinstance(item, int) or isinstance(value, dict):
            value = value[item]
        else:
            value = getattr(value, item, None)
    return value


def ring_of(problem: Problem) -> tuple[int, int]:
    """Number of sectors N and engine order EO; of a joined system those in its file."""
    if isinstance(problem, Study) or problem.system is None:
        return problem.ring.sectors, problem.excitation.engine_order
    with opened(problem.system.file) as file:
        try:
            return int(file.attrs["sectors"]), int(file.attrs["engine_order"])
        except (KeyError, TypeError, ValueError):
            raise InputError(f"{problem.system.file}: not a vanelock System") from None


def with_values(
    problem: G, changes: dict[str, Any], parsed: dict[Hashable, Any] | None = None
) -> G:
    """The study or scene with some keys changed and no sweep; raises pydantic's ValidationError.

    Tables without a change are those of the given one itself, which are not checked again, nor are
    tables `parsed` from the same changes of the same study; new ones are added to these.
    """
    changed: dict[str, Any] = {}  # what it is known by
    for key, value in changes.items():
        table = str(path_of(key)[0])
        changed[table] = (*changed.get(table, (table,)), key, repr(value))
    same = {name: getattr(problem, name) for name in problem.model_fields_set - VARIED - {*changed}}
    if parsed is not None:
        same |= {name: parsed[by] for name, by in changed.items() if by in parsed}
    tables = {name: value for name, value in same.items() if isinstance(value, KeyTable)}
    data = tables | problem.model_dump(exclude_unset=True, exclude={*VARIED, *tables})
    for key, value in changes.items():
        path = path_of(key)
        if len(path) == 1 or path[0] not in tables:
            _put(data, path, value, type(problem))
    found = cast("G", type(problem).model_validate(data, strict=True))
    if parsed is not None:
        parsed.update({by: getattr(found, name) for name, by in changed.items() if name in data})
    return found


def _put(data: dict[str, Any], path: Location, value: Any, schema: type[KeyTable]) -> None:
    """Change a value in nested tables; tables that a user names must be there."""
    table: Any = data
    for i, item in enumerate(path[:-1]):
        if i == 1 and get_origin(schema.model_fields[str(path[0])].annotation) is dict:
            if item not in table:
                have = ", ".join(table) or "none"
                raise InputError(f"no {dotted(path[:2])}; there are {have}")
        try:
            table = table.setdefault(item, {}) if isinstance(item, str) else table[item]
        except (AttributeError, IndexError, KeyError, TypeError):
            table = None
    if not isinstance(table, dict) or isinstance(path[-1], int):
        raise InputError(f"{dotted(path)}: there is nothing of that name to change")
    table[path[-1]] = value


def diameter_of(problem: Problem, harmonic: int) -> int:
    """Nodal diameter of a harmonic, 0 to N/2: k and N - k are one another's conjugates."""
    return folded(harmonic * problem.excitation.engine_order, problem.ring.sectors)


def diameters_of(problem: Problem, harmonics: int | None = None) -> tuple[int, ...]:
    """Nodal diameters of harmonics 0 to `harmonics`, those of its response unless said."""
    highest = problem.response.harmonics if harmonics is None else harmonics
    return tuple(sorted({diameter_of(problem, h) for h in range(highest + 1)}))
