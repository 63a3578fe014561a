"""Read a study file: TOML, then the schema, then the sweep; every mistake is one clear line."""

import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from copy import deepcopy
from pathlib import Path
from typing import Any, TypeVar

from vanelock.common.checked import UNCHECKED, Checked, NotKnown, examined
from vanelock.common.errors import InputError, raised
from vanelock.common.files.files import beside, contents
from vanelock.common.tables import counted
from vanelock.common.toml import LARGEST, toml_tables
from vanelock.input.cases.sweep import cases, list_mistakes, misfits
from vanelock.input.cases.values import Given
from vanelock.input.messages import Order, described, dotted, mistakes
from vanelock.input.schema.structure.loads import files_named
from vanelock.input.schema.study import Study

S = TypeVar("S", bound=Checked)
Further = Callable[[S, bool], list[str]]
"""Lines about a table that was read, and whether it lacks what was wrong in it."""


def nothing(table: Checked, lacks: bool) -> list[str]:
    """No line: what the schema says is all."""
    return []


def load_study(
    path: str | os.PathLike[str], outside: bool = False, also: Further[Study] = nothing
) -> Study:
    """Read and check a study file.

    Parameters
    ----------
    path : path
        The study file.
    outside : bool
        Whether the files that it names may lie outside its folder.
    also : callable, optional
        What else is wrong with the study, as for `checked`.

    Raises
    ------
    InputError
        One line for each mistake: the file, the full key, the value given and what is allowed.
    """
    where, place = str(path), Path(path)
    data = toml_tables(read_text(place), where)
    if is_scene(data):
        raise InputError(
            f"{where}: a scene of matrices, which run, check and compare take; this needs a study, "
            "whose parts have meshes"
        )
    data, refused = _beside(data, place.parent, outside)
    return checked(
        Study, data, where, refused, lambda *found: [*case_mistakes(*found), *also(*found)]
    )


def is_scene(data: dict[str, Any]) -> bool:
    """Whether the tables of a file are a scene's, not a study's."""
    return "components" in data or "system" in data


def read_text(path: Path) -> str:
    """Text of a file."""
    try:
        return contents(path, "a study file", LARGEST).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None


def parse_study(text: str, where: str = "study") -> Study:
    """Check the text of a study file, sweep values apart; `where` is what errors call it."""
    return check_study(toml_tables(text, where), where)


def check_study(data: dict[str, Any], where: str = "study") -> Study:
    """Check the nested tables of a study."""
    return checked(Study, data, where)


def checked(
    schema: type[S],
    data: dict[str, Any],
    where: str,
    known: Iterable[str] = (),
    further: Further[S] = nothing,
) -> S:
    """Nested tables as what a schema makes of them."""
    table, found = examined(schema, data, mistakes)
    lines, more = described(found, data, schema)
    lines = [*known, *lines]
    if table is not None:
        lines += further(table, bool(lines))
        if not lines:
            return table
    lines = sorted(dict.fromkeys(lines), key=Order(data).of_line)
    if more:
        lines.append(f"and {counted(more, 'more mistake')}")
    raise InputError("\n".join(f"{where}: {line}" for line in lines))


def case_mistakes(given: Given, lacks: bool) -> list[str]:
    """What is wrong with the cases; where keys are missing, with each swept value by itself."""
    if not lacks:
        return raised(lambda: cases(given))
    found = list_mistakes(given, UNCHECKED)
    with suppress(NotKnown):
        if not (given.sweep or given.rows or given.scatter):
            found += misfits(given)
    return found


def _beside(data: dict[str, Any], folder: Path, outside: bool) -> tuple[dict[str, Any], list[str]]:
    """The tables with files where they are: their paths start at the study file's folder.

    And a line for each path that leaves it.
    """
    found, refused = deepcopy(data), []
    for (*path, key), file in files_named(data):
        table: Any = found
        for name in path:
            table = table[name]
        try:
            table[key] = str(beside(folder, file, dotted((*path, key)), outside))
        except InputError as error:
            refused.append(str(error))
    return found, refused
