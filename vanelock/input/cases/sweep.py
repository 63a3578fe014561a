"""Cases of a study: the product of the swept keys' values, each checked as the key itself is.

Several engine orders are swept values of `excitation.engine_order`, the slowest of them. Rows of
keys that vary together are slower still. Keys that scatter have their samples instead.
"""

from collections.abc import Callable, Collection, Hashable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic import ValidationError

from vanelock.common.checked import UNCHECKED, NotKnown, disagreements
from vanelock.common.errors import InputError
from vanelock.input.messages import explain, field_at, known_keys, mistakes, reason, show, unknown
from vanelock.input.schema.own_mesh import OwnCasing, OwnVane
from vanelock.input.schema.structure import KeyTable
from vanelock.input.schema.study import Study
from vanelock.mesh.checks.dimensions import (
    check_casing,
    check_clearances,
    check_sectors,
    check_vane,
)

LARGEST = 100_000
"""Most cases of one study."""

ORDER = "excitation.engine_order"
SAMPLE = "sample"
"""What the cases of keys that scatter are called, with their number."""
NUMBERS = ("mesh.size", "temperature.vane", "temperature.casing")
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
    study : Study
        The study with those values and no sweep.
    """

    name: str
    values: dict[str, float | str]
    study: Study


def cases(study: Study) -> tuple[Case, ...]:
    """Every case, the last key running fastest; one called "nominal" where nothing is swept.

    Raises
    ------
    InputError
        One line for each swept key or value that the study could not hold.
    """
    if study.scatter is not None:
        return _samples(study)
    if wrong := list_mistakes(study):
        raise InputError("\n".join(wrong))
    lists = dict(study.sweep)
    if study.excitation.engine_orders is not None:
        lists = {ORDER: study.excitation.engine_orders, **lists}
    if not lists and not study.rows:
        if wrong := misfits(study):
            raise InputError("\n".join(wrong))
        return (Case("nominal", {}, study),)
    together = zip(*study.rows.values(), strict=True)
    rows = [dict(zip(study.rows, row, strict=True)) for row in together] or [{}]
    count = len(rows)
    for values in lists.values():
        count *= len(values)
    where = _where(study, [*study.rows, *lists])
    if count > LARGEST:
        raise InputError(f"{where}: {count} cases: at most {LARGEST} are allowed")
    names = short_names([*study.rows, *lists])
    found: dict[str, Case] = {}
    fitting: set[Hashable] = set()
    known: dict[Hashable, Any] = {}
    for row, combination in product(rows, product(*lists.values())):
        chosen = {**row, **dict(zip(lists, combination, strict=True))}
        case = _case(study, chosen, names, known)
        _check_fit(case, chosen, fitting, where)
        if case.name in found:
            raise InputError(f"rows: {case.name} is there twice")
        found[case.name] = case
    return tuple(found.values())


def list_mistakes(study: Study, context: str | None = None) -> list[str]:
    """What is wrong with the lists of a study's sweep, rows and scatter.

    Parameters
    ----------
    study : Study
        It may lack keys whose values are wrong.
    context : str, optional
        "unchecked" looks at each value by itself, without its combination with others.
    """
    from vanelock.input.cases.samples import sample_mistakes

    found: list[str] = []
    with suppress(NotKnown):
        for key, values in study.sweep.items():
            found += _mistakes(study, key, values, context)
    with suppress(NotKnown):
        found += _of_rows(study, context)
    with suppress(NotKnown):
        found += sample_mistakes(study)
    return found


def _samples(study: Study) -> tuple[Case, ...]:
    """A case for each sample of the keys that scatter."""
    from vanelock.input.cases.samples import samples

    columns = samples(study)
    count = len(next(iter(columns.values())))
    found = []
    fitting: set[Hashable] = set()
    for i in range(count):
        chosen = {key: values[i] for key, values in columns.items()}
        try:
            case = _case(study, chosen, short_names(list(chosen)), {})
            _check_fit(case, chosen, fitting)
        except InputError as error:
            told = str(error).removeprefix("sweep: ")
            raise InputError(
                f"scatter, sample {i + 1}: {told}; low, high or truncate = true cut distributions"
            ) from None
        found.append(replace(case, name=f"{SAMPLE}={i + 1:0{len(str(count))}d}"))
    return tuple(found)


def _of_rows(study: Study, context: str | None) -> list[str]:
    """What is wrong with the lists of keys that vary together."""
    found: list[str] = []
    lengths = {len(values) for values in study.rows.values()}
    for key, values in study.rows.items():
        where = f'rows."{key}"'
        if key in study.sweep:
            found.append(f"{where}: is in sweep too")
        elif not values:
            found.append(f"{where} = []: needs at least one value")
        else:
            found += [
                line.replace("sweep.", "rows.", 1)
                for value in dict.fromkeys(map(_hashable, values))
                for line in _mistakes(study, key, (value,), context)
                if "must" not in line  # may hold for the other values of its row
            ][:1]
    if not found and len(lengths) > 1:
        told = ", ".join(f'"{key}" {len(values)}' for key, values in study.rows.items())
        found.append(f"rows: lists must be equally long, not {told}")
    return found


def _hashable(value: object) -> Any:
    return value if isinstance(value, Hashable) else str(value)


def _case(
    study: Study, chosen: dict[str, Any], names: dict[str, str], known: dict[Hashable, Any]
) -> Case:
    """The study with all chosen values at once: combinations may be impossible too.

    Cases whose values in a table are the same share it: those `known` so far.
    """
    try:
        changed = with_values(study, chosen, known=known)
    except ValidationError as error:
        shown = ", ".join(f"{key} = {show(value)}" for key, value in chosen.items())
        told = f"{shown}: " if len(chosen) > 1 else ""
        raise InputError(f"{_where(study, chosen)}: {told}{explain(error, {})[0]}") from None
    values = {key: value_at(changed, key) for key in chosen}
    name = ",".join(f"{names[key]}={shown_value(value)}" for key, value in values.items())
    return Case(name, values, changed)


def misfits(study: Study) -> list[str]:
    """What dimensions contradict one another, and what mesh files are not there."""
    return disagreements(study, (_files, _sectors, _vane, _casing, _both))


def _files(study: Study) -> Iterator[str]:
    for name in ("vane", "casing"):
        part = getattr(study, name)
        if isinstance(part, OwnVane | OwnCasing) and not Path(part.mesh).is_file():
            yield f"{name}.mesh = {show(part.mesh)}: no such file"


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


def _where(study: Study, keys: Collection[str]) -> str:
    """Which tables of the study vary some keys."""
    rows = any(key in study.rows for key in keys)
    others = any(key not in study.rows for key in keys)
    return "rows and sweep" if rows and others else "rows" if rows else "sweep"


def _check_fit(
    case: Case, chosen: dict[str, Any], known: set[Hashable], where: str = "sweep"
) -> None:
    """Refuse a vane and a casing that cannot be assembled, unless it is known that they can."""
    geometry = case.study.vane, case.study.casing, case.study.ring.sectors
    if geometry in known:
        return
    if wrong := misfits(case.study):
        shown = ", ".join(f"{key} = {show(value)}" for key, value in chosen.items())
        raise InputError(f"{where}: {shown}: {wrong[0]}")
    known.add(geometry)


def _mistakes(study: Study, key: str, values: tuple[Any, ...], context: str | None) -> list[str]:
    """What is wrong with a swept key, value by value."""
    where = f'sweep."{key}"'
    if key not in known_keys():
        return [f"{where}: {unknown(tuple(key.split('.')))}"]
    if key.startswith(("outputs.", "scatter.")) or not (_holds_number(key) or _holds_choice(key)):
        return [f"{where}: only keys that hold a number or a choice of words can be swept"]
    if key == ORDER and study.excitation.engine_orders is not None:
        return [f"{where}: give either this or excitation.engine_orders, not both"]

    def held(value: Any) -> Any:
        try:
            return value_at(with_values(study, {key: value}, context), key)
        except ValidationError as error:
            raise InputError(reason(mistakes(error)[0], given=value)) from None

    return value_mistakes(where, values, held)


def value_mistakes(where: str, values: Sequence[Any], held: Callable[[Any], Any]) -> list[str]:
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


def _holds_number(key: str) -> bool:
    field = field_at(tuple(key.split(".")))
    if field is None:
        return False
    options = [field.annotation, *get_args(field.annotation)]
    options += [inner for option in options for inner in get_args(option)[:1]]
    return key in NUMBERS or any(option in (int, float) for option in options)


def _holds_choice(key: str) -> bool:
    field = field_at(tuple(key.split(".")))
    return field is not None and get_origin(field.annotation) is Literal


def shown_value(value: float | str) -> str:
    """A value as case names have it."""
    return value if isinstance(value, str) else f"{value:.9g}"


def value_at(study: Study, key: str) -> Any:
    """Value of a dotted key, None where there is none."""
    value: Any = study
    for name in key.split("."):
        value = getattr(value, name, None)
    return value


def with_values(
    study: Study,
    changes: dict[str, Any],
    context: str | None = None,
    known: dict[Hashable, Any] | None = None,
) -> Study:
    """The study with some keys changed and no sweep; raises pydantic's ValidationError.

    Tables without a change are those of the study itself, which are not checked again, nor are
    tables `known` from the same changes of the same study; new ones are added to these. In the
    context "unchecked" it is not looked at whether keys contradict one another.
    """
    changed: dict[str, Any] = {"excitation": ("excitation",)}  # what it is known by
    for key, value in changes.items():
        name = key.partition(".")[0]
        changed[name] = (*changed.get(name, (name,)), key, repr(value))
    apart = {"sweep", "rows", "scatter"}
    tables: dict[str, Any] = {}
    if context != UNCHECKED:  # else keys may be missing
        same = {name: getattr(study, name) for name in study.model_fields_set - apart - {*changed}}
        if known is not None:
            same |= {name: known[by] for name, by in changed.items() if by in known}
        tables = {name: value for name, value in same.items() if isinstance(value, KeyTable)}
    data = tables | study.model_dump(
        exclude_unset=True, exclude={*apart, *tables}, warnings=context != UNCHECKED
    )
    if "excitation" not in tables:
        data.get("excitation", {}).pop("engine_orders", None)
    for key, value in changes.items():
        *path, last = key.split(".")
        if path and path[0] in tables:
            continue
        table = data
        for name in path:
            table = table.setdefault(name, {})
        table[last] = value
    found = Study.model_validate(data, strict=True, context=context)
    if known is not None:
        known.update({by: getattr(found, name) for name, by in changed.items() if name in data})
    return found


def short_names(keys: list[str]) -> dict[str, str]:
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
    """What tells the groups that cases belong to apart: the swept values fixed in every group.

    Parameters
    ----------
    cases : sequence of Case
        All cases.
    groups : sequence
        The group of each; "" is the label of an only one.
    """
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
    names = short_names(keys)
    return [
        ",".join(f"{names[key]}={shown_value(case.values[key])}" for key in fixed) or case.name
        for case in cases
    ]
