"""Cases of a study or a scene: the product of the swept keys' values, each checked as its key is.

The first key of the sweep runs slowest; rows of keys that vary together are slower still. Keys that
scatter have their samples instead.
"""

from collections.abc import Callable, Collection, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic import ValidationError

from vanelock.common.checked import (
    disagreements,
    dotted,
    explain,
    field_at,
    mistakes,
    reason,
    show,
    unknown,
)
from vanelock.common.errors import InputError
from vanelock.input.cases.names import valued
from vanelock.input.cases.values import Problem, path_of, value_at, with_values
from vanelock.input.schema.structure.loads import files_named
from vanelock.input.schema.structure.own_mesh import OwnCasing, OwnVane
from vanelock.input.schema.study import Study
from vanelock.input.settings import unit_of
from vanelock.mesh.checks import (
    check_casing,
    check_clearances,
    check_sectors,
    check_vane,
)

LARGEST = 100_000
"""Most cases of one study."""

SAMPLE = "sample"
"""What the cases of keys that scatter are called, with their number."""
NUMBERS = ("mesh.size", "rom.modes", "temperature.vane", "temperature.casing")
"""Keys that hold a number, or something else that can be swept no more than a table."""


@dataclass(frozen=True, slots=True)
class Case:
    """One point of a sweep.

    Attributes
    ----------
    name : str
        Short and unique in its study, such as "mu=0.15,harmonics=3".
    values : dict of str to number or str
        The swept keys' values, SI.
    problem : Study or Scene
        What the file says, with those values and no sweep.
    """

    name: str
    values: dict[str, float | str]
    problem: Problem

    @property
    def study(self) -> Study:
        """The same, where only a study has cases like this one."""
        assert isinstance(self.problem, Study)
        return self.problem


def cases(problem: Problem) -> tuple[Case, ...]:
    """Every case, the last key running fastest; one called "nominal" where nothing is swept.

    Raises
    ------
    InputError
        One line for each swept key or value that the study or scene could not hold.
    """
    if problem.scatter is not None:
        return _samples(problem)
    if wrong := _list_mistakes(problem):
        raise InputError("\n".join(wrong))
    lists = dict(problem.sweep)
    if not lists and not problem.rows:
        if wrong := misfits(problem):
            raise InputError("\n".join(wrong))
        return (Case("nominal", {}, problem),)
    together = zip(*problem.rows.values(), strict=True)
    rows = [dict(zip(problem.rows, row, strict=True)) for row in together] or [{}]
    count = len(rows)
    for values in lists.values():
        count *= len(values)
    where = _where(problem, [*problem.rows, *lists])
    if count > LARGEST:
        raise InputError(f"{where}: {count} cases: at most {LARGEST} are allowed")
    names = _short_names([*problem.rows, *lists])
    found: dict[str, Case] = {}
    fitting: set[Hashable] = set()
    known: dict[Hashable, Any] = {}
    for row, combination in product(rows, product(*lists.values())):
        chosen = {**row, **dict(zip(lists, combination, strict=True))}
        case = _case(problem, chosen, names, known)
        _check_fit(case, chosen, fitting, where)
        if case.name in found:
            raise InputError(f"rows: {case.name} is there twice")
        found[case.name] = case
    return tuple(found.values())


def _list_mistakes(problem: Problem) -> list[str]:
    """What is wrong with the lists of its sweep, rows and scatter."""
    from vanelock.input.cases.samples import sample_mistakes

    swept = [
        line for key, values in problem.sweep.items() for line in _mistakes(problem, key, values)
    ]
    return [*swept, *_of_rows(problem), *sample_mistakes(problem)]


def _samples(problem: Problem) -> tuple[Case, ...]:
    """A case for each sample of the keys that scatter."""
    from vanelock.input.cases.samples import samples

    columns = samples(problem)
    count = len(next(iter(columns.values())))
    found = []
    fitting: set[Hashable] = set()
    for i in range(count):
        chosen = {key: values[i] for key, values in columns.items()}
        try:
            case = _case(problem, chosen, _short_names(list(chosen)), {})
            _check_fit(case, chosen, fitting)
        except InputError as error:
            reason = str(error).removeprefix("sweep: ")
            raise InputError(
                f"scatter, sample {i + 1}: {reason}; within = [low, high] cuts a distribution"
            ) from None
        found.append(replace(case, name=f"{SAMPLE}={i + 1:0{len(str(count))}d}"))
    return tuple(found)


def _of_rows(problem: Problem) -> list[str]:
    """What is wrong with the lists of keys that vary together."""
    found: list[str] = []
    lengths = {len(values) for values in problem.rows.values()}
    for key, values in problem.rows.items():
        where = f'rows."{key}"'
        if key in problem.sweep:
            found.append(f"{where}: is in sweep too")
        elif not values:
            found.append(f"{where} = []: needs at least one value")
        else:
            found += [
                line.replace("sweep.", "rows.", 1)
                for value in dict.fromkeys(map(_hashable, values))
                for line in _mistakes(problem, key, (value,))
                if "must" not in line  # may hold for the other values of its row
            ][:1]
    if not found and len(lengths) > 1:
        text = ", ".join(f'"{key}" {len(values)}' for key, values in problem.rows.items())
        found.append(f"rows: lists must be equally long, not {text}")
    return found


def _hashable(value: object) -> Any:
    return value if isinstance(value, Hashable) else str(value)


def _case(
    problem: Problem, chosen: dict[str, Any], names: dict[str, str], parsed: dict[Hashable, Any]
) -> Case:
    """What is given with all chosen values at once: combinations may be impossible too.

    Cases whose values in a table are the same share it: those `parsed` so far.
    """
    try:
        changed = with_values(problem, chosen, parsed=parsed)
    except ValidationError as error:
        shown = ", ".join(f"{key} = {show(value)}" for key, value in chosen.items())
        text = f"{shown}: " if len(chosen) > 1 else ""
        why = explain(error, {}, type(problem))[0]
        raise InputError(f"{_where(problem, chosen)}: {text}{why}") from None
    values = {key: value_at(changed, key) for key in chosen}
    return Case(_named(values, names, type(problem)), values, changed)


def _named(values: dict[str, float | str], names: dict[str, str], schema: type[Problem]) -> str:
    """A name from values by key, and what their keys are called: "mu=0.15,interference=4um"."""
    texts = (f"{names[key]}={valued(v, unit_of(key, schema))}" for key, v in values.items())
    return ",".join(texts)


def misfits(problem: Problem) -> list[str]:
    """What dimensions of a study contradict one another, and what mesh files are not there."""
    if not isinstance(problem, Study):
        return []
    return disagreements(problem, (_files, _sectors, _vane, _casing, _both))


def _files(study: Study) -> Iterator[str]:
    for location, file in files_named(study.model_dump(warnings=False)):
        if location[0] != "measured" and not Path(file).is_file():
            yield f"{dotted(location)} = {show(file)}: no such file"


def _sectors(study: Study) -> None:
    check_sectors(study.ring.sectors)


def _vane(study: Study) -> None:
    if not isinstance(study.vane, OwnVane):
        check_vane(study.vane, study.ring.sectors)


def _casing(study: Study) -> None:
    if not isinstance(study.casing, OwnCasing):
        check_casing(study.casing, study.vane.hook, study.ring.sectors)


def _both(study: Study) -> None:
    if not isinstance(study.vane, OwnVane) and not isinstance(study.casing, OwnCasing):
        check_clearances(study.vane, study.casing)


def _where(problem: Problem, keys: Collection[str]) -> str:
    """Which tables of the study or scene vary some keys."""
    rows = any(key in problem.rows for key in keys)
    others = any(key not in problem.rows for key in keys)
    return "rows and sweep" if rows and others else "rows" if rows else "sweep"


def _check_fit(
    case: Case, chosen: dict[str, Any], parsed: set[Hashable], where: str = "sweep"
) -> None:
    """Refuse a vane and a casing that cannot be assembled, unless it is known that they can."""
    if not isinstance(study := case.problem, Study):
        return
    geometry = study.vane, study.casing, study.ring.sectors
    if geometry in parsed:
        return
    if wrong := misfits(study):
        shown = ", ".join(f"{key} = {show(value)}" for key, value in chosen.items())
        raise InputError(f"{where}: {shown}: {wrong[0]}")
    parsed.add(geometry)


def _mistakes(problem: Problem, key: str, values: tuple[Any, ...]) -> list[str]:
    """What is wrong with a swept key, value by value."""
    where, schema = f'sweep."{key}"', type(problem)
    if field_at(path_of(key), schema) is None:
        return [f"{where}: {unknown(path_of(key), schema)}"]
    if key.startswith(("outputs.", "scatter.")) or not _can_vary(key, schema):
        return [f"{where}: only keys that hold a number or a choice of words can be swept"]

    def held(value: Any) -> Any:
        try:
            return value_at(with_values(problem, {key: value}), key)
        except ValidationError as error:
            raise InputError(reason(mistakes(error)[0], schema, value)) from None

    return _value_mistakes(where, values, held)


def _value_mistakes(where: str, values: Sequence[Any], held: Callable[[Any], Any]) -> list[str]:
    """What is wrong with a swept key's values; `held` is what the key holds of one, or refuses."""
    if not values:
        return [f"{where} = []: needs at least one value"]
    found: list[str] = []
    seen: dict[float | str, int] = {}
    for i, value in enumerate(values):
        item = f"{where}[{i}] = {show(value)}"
        try:
            number = held(value)
        except InputError as error:
            found.append(f"{item}: {error}")
            continue
        if isinstance(number, bool) or not isinstance(number, int | float | str):
            found.append(f"{item}: expected a number or a word")
            continue
        if number in seen:
            found.append(f"{item}: the same as entry {seen[number]}")
        seen.setdefault(number, i)
    return found


def _can_vary(key: str, schema: type[Problem]) -> bool:
    """Whether a key holds a number or a choice of words."""
    field = field_at(path_of(key), schema)
    if field is None:
        return False
    options = [field.annotation, *get_args(field.annotation)]
    options += [inner for option in options for inner in get_args(option)[:1]]
    numbers = key in NUMBERS or any(option in (int, float) for option in options)
    words = (get_args(option) for option in options if get_origin(option) is Literal)
    return numbers or any(isinstance(word, str) for choice in words for word in choice)


def _short_names(keys: list[str]) -> dict[str, str]:
    """Each key's last word, with as many before it as it takes to tell the keys apart.

    Of an entry of a list, such as "loads[0].amplitude", the list goes with it.
    """
    names = {}
    for key in keys:
        words = key.split(".")
        depth = next((len(words) - i for i, word in enumerate(words) if "[" in word), 1)
        while any(other != key and other.split(".")[-depth:] == words[-depth:] for other in keys):
            depth += 1
        names[key] = ".".join(words[-depth:])
    return names


def label(cases: Sequence[Case], groups: Sequence[Hashable]) -> list[str]:
    """What distinguishes the groups that cases belong to: the swept values fixed in every group."""
    if len(set(groups)) < 2:
        return [""] * len(cases)
    if len(set(groups)) == len(cases):
        return [case.name for case in cases]
    keys = list(cases[0].values)
    fixed = []
    for key in keys:
        seen: dict[Hashable, float | str] = {}
        values = [case.values[key] for case in cases]
        if all(seen.setdefault(g, v) == v for g, v in zip(groups, values, strict=True)):
            fixed.append(key)
    names = _short_names(keys)
    return [
        _named({key: case.values[key] for key in fixed}, names, type(case.problem)) or case.name
        for case in cases
    ]
