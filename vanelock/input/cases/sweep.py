"""Cases of a study or a scene: the product of the swept keys' values, each checked as its key is.

The first key of the sweep runs slowest; rows of keys that vary together are slower still. Keys that
scatter have their samples instead.
"""

from collections.abc import Collection, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from vanelock.common.checked import (
    Check,
    disagreements,
    dotted,
    explain,
    field_at,
    kinds_of,
    mistakes,
    reason,
    show,
    unknown,
)
from vanelock.common.errors import InputError
from vanelock.common.quantities import is_number
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
    keys = [*problem.rows, *lists]
    if count > LARGEST:
        where = _where(problem, keys)
        raise InputError(f"{where}: {count} cases: at most {LARGEST} are allowed")
    found: dict[str, Case] = {}
    names, parsed = _short_names(keys), dict[Hashable, Any]()
    for row, combination in product(rows, product(*lists.values())):
        case = _case(problem, row | dict(zip(lists, combination, strict=True)), names, parsed)
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
    names, parsed = _short_names(list(columns)), dict[Hashable, Any]()
    for i in range(count):
        try:
            case = _case(problem, {key: of[i] for key, of in columns.items()}, names, parsed)
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

    Cases whose values in a table are the same share it: those `parsed` so far, among which are the
    dimensions of vanes and casings that can be assembled.
    """
    where = _where(problem, chosen)
    shown = ", ".join(f"{key} = {show(value)}" for key, value in chosen.items())
    try:
        changed = with_values(problem, chosen, parsed=parsed)
    except ValidationError as error:
        text = f"{shown}: " if len(chosen) > 1 else ""
        raise InputError(f"{where}: {text}{explain(error, {}, type(problem))[0]}") from None
    if isinstance(changed, Study):
        dimensions = changed.model_dump_json(include={"vane", "casing", "ring"})
        if dimensions not in parsed and (wrong := misfits(changed)):
            raise InputError(f"{where}: {shown}: {wrong[0]}")
        parsed[dimensions] = None
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
    vane, casing, N = problem.vane, problem.casing, problem.ring.sectors
    checks: list[Check] = [_files, lambda study: check_sectors(N)]
    if not isinstance(vane, OwnVane):
        checks.append(lambda study: check_vane(vane, N))
    if not isinstance(casing, OwnCasing):
        checks.append(lambda study: check_casing(casing, vane.hook, N))
        if not isinstance(vane, OwnVane):
            checks.append(lambda study: check_clearances(vane, casing))
    return disagreements(problem, checks)


def _files(study: Study) -> Iterator[str]:
    for location, file in files_named(study.model_dump(warnings=False)):
        if location[0] != "measured" and not Path(file).is_file():
            yield f"{dotted(location)} = {show(file)}: no such file"


def _where(problem: Problem, keys: Collection[str]) -> str:
    """Which tables of the study or scene vary some keys."""
    rows = any(key in problem.rows for key in keys)
    others = any(key not in problem.rows for key in keys)
    return "rows and sweep" if rows and others else "rows" if rows else "sweep"


def _mistakes(problem: Problem, key: str, values: tuple[Any, ...]) -> list[str]:
    """What is wrong with a swept key, value by value."""
    where, schema = f'sweep."{key}"', type(problem)
    if (field := field_at(path_of(key), schema)) is None:
        return [f"{where}: {unknown(path_of(key), schema)}"]
    if key.startswith(("outputs.", "scatter.")) or not (key in NUMBERS or _can_vary(field)):
        return [f"{where}: only keys that hold a number or a choice of words can be swept"]
    if not values:
        return [f"{where} = []: needs at least one value"]
    found: list[str] = []
    seen: dict[float | str, int] = {}
    for i, value in enumerate(values):
        item = f"{where}[{i}] = {show(value)}"
        try:
            held = value_at(with_values(problem, {key: value}), key)
        except ValidationError as error:
            found.append(f"{item}: {reason(mistakes(error)[0], schema, value)}")
            continue
        except InputError as error:
            found.append(f"{item}: {error}")
            continue
        if not is_number(held) and not isinstance(held, str):
            found.append(f"{item}: expected a number or a word")
        elif held in seen:
            found.append(f"{item}: the same as entry {seen[held]}")
        else:
            seen[held] = i
    return found


def _can_vary(field: FieldInfo) -> bool:
    """Whether a key holds a number or a choice of words."""
    options = kinds_of(field)
    words = (get_args(option) for option in options if get_origin(option) is Literal)
    return not {int, float}.isdisjoint(options) or any(
        isinstance(word, str) for choice in words for word in choice
    )


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
