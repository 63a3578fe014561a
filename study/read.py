"""Read a study file: TOML, then the schema, then the sweep; every mistake is one clear line."""

import os
import re
import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from vanelock.errors import InputError
from vanelock.study.messages import explain
from vanelock.study.model import Study
from vanelock.study.sweep import cases


def load_study(path: str | os.PathLike[str]) -> Study:
    """Read and check a study file.

    Raises
    ------
    InputError
        One line for each mistake: the file, the full key, the value given and what is allowed.
    """
    where = str(path)
    data = toml_tables(read_text(Path(path)), where)
    study = check_study(_beside(data, Path(path).parent), where)
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
        return path.read_bytes().decode("utf-8")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, a study file is needed") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None


def parse_study(text: str, where: str = "study") -> Study:
    """Check the text of a study file, sweep values apart; `where` is what errors call it."""
    return check_study(toml_tables(text, where), where)


def check_study(data: dict[str, Any], where: str = "study") -> Study:
    """Check the nested tables of a study."""
    try:
        return Study.model_validate(data, strict=True)
    except ValidationError as error:
        lines = explain(error, data)
        raise InputError("\n".join(f"{where}: {line}" for line in lines)) from None


def _beside(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tables with files where they are: their paths start at the study file's folder."""
    found = dict(data)
    measured = data.get("measured")
    if isinstance(measured, dict):
        measured = [measured]
    if isinstance(measured, list):
        found["measured"] = [_placed(each, "file", folder) for each in measured]
    for name in ("vane", "casing"):
        if name in data:
            found[name] = _placed(data[name], "mesh", folder)
    return found


def _placed(table: Any, key: str, folder: Path) -> Any:
    """The table with its file's path from the folder on; anything else is for the schema."""
    if isinstance(table, dict) and isinstance(table.get(key), str) and table[key]:
        return {**table, key: str(folder / table[key])}
    return table


def toml_tables(text: str, where: str) -> dict[str, Any]:
    """Nested tables of a TOML text; `where` is what errors call it."""
    try:
        return tomllib.loads(text.replace("\r\n", "\n"))
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        found = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", message)
        if found is None:
            raise InputError(f"{where}: not valid TOML: {message}") from None
        line = found[2] or str(len(text.splitlines()) or 1)
        raise InputError(f"{where}: line {line}: not valid TOML: {found[1]}") from None
    except RecursionError:
        raise InputError(f"{where}: not a study: nested too deeply") from None
