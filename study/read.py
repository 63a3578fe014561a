"""Read a study file: TOML, then the schema, then the sweep; every mistake is one clear line."""

import os
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from vanelock.errors import InputError
from vanelock.files import beside, contents
from vanelock.study.messages import explain
from vanelock.study.model import Study
from vanelock.study.sweep import cases
from vanelock.toml import LARGEST, toml_tables

S = TypeVar("S", bound=BaseModel)


def load_study(path: str | os.PathLike[str], outside: bool = False) -> Study:
    """Read and check a study file.

    Parameters
    ----------
    path : path
        The study file.
    outside : bool
        Whether the files that it names may lie outside its folder.

    Raises
    ------
    InputError
        One line for each mistake: the file, the full key, the value given and what is allowed.
    """
    where = str(path)
    data = toml_tables(read_text(Path(path)), where)
    try:
        data = _beside(data, Path(path).parent, outside)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    study = check_study(data, where)
    try:
        cases(study)
    except InputError as error:
        raise InputError(
            "\n".join(f"{where}: {line}" for line in str(error).splitlines())
        ) from None
    return study


def read_text(path: Path) -> str:
    """Text of a file.

    Raises
    ------
    InputError
        If it cannot be read or is not text.
    """
    try:
        return contents(path, "a study file", LARGEST).decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None


def parse_study(text: str, where: str = "study") -> Study:
    """Check the text of a study file, sweep values apart; `where` is what errors call it."""
    return check_study(toml_tables(text, where), where)


def check_study(data: dict[str, Any], where: str = "study") -> Study:
    """Check the nested tables of a study."""
    return checked(Study, data, where)


def checked(schema: type[S], data: dict[str, Any], where: str) -> S:
    """Nested tables as what a schema makes of them; `where` is what errors call them.

    Raises
    ------
    InputError
        One line for each mistake.
    """
    try:
        return schema.model_validate(data, strict=True)
    except ValidationError as error:
        lines = explain(error, data, schema)
        raise InputError("\n".join(f"{where}: {line}" for line in lines)) from None


def _beside(data: dict[str, Any], folder: Path, outside: bool) -> dict[str, Any]:
    """The tables with files where they are: their paths start at the study file's folder."""
    found = dict(data)
    measured = data.get("measured")
    if isinstance(measured, dict):
        measured = [measured]
    if isinstance(measured, list):
        found["measured"] = [
            _placed(each, "file", folder, f"measured[{i}]", outside)
            for i, each in enumerate(measured)
        ]
    for name in ("vane", "casing"):
        if name in data:
            found[name] = _placed(data[name], "mesh", folder, name, outside)
    return found


def _placed(table: Any, key: str, folder: Path, where: str, outside: bool) -> Any:
    """The table with its file's path from the folder on; anything else is for the schema."""
    if isinstance(table, dict) and isinstance(table.get(key), str) and table[key]:
        place = beside(folder, table[key], f"{where}.{key}", outside)
        return {**table, key: str(place)}
    return table
