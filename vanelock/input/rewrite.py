"""A study file's text with other values of some keys: comments, order and all else stay."""

import tomllib
from collections.abc import Iterable, Mapping
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from vanelock.common.checked import dotted
from vanelock.common.errors import InputError
from vanelock.input.cases.values import path_of

Changes = Mapping[Any, float | str]


def rewritten(text: str, changes: Changes, without: Iterable[str] = ()) -> str:
    """The text with keys set to values; what it does not hold is added to its table."""
    try:
        wanted, document = tomllib.loads(text), tomlkit.parse(text)
        for tables in (wanted, document):
            _set(tables, changes)
            for key in without:
                _leave_out(tables, key)
        made = tomlkit.dumps(document)
        said = tomllib.loads(made) == wanted
    except (TOMLKitError, ValueError, LookupError, TypeError, AttributeError):
        said = False
    if not said:
        keys = ", ".join(key if isinstance(key, str) else dotted(key) for key in changes)
        raise InputError(f"the text of the study cannot be changed: set {keys} in it yourself")
    return made


def _set(tables: Any, changes: Changes) -> None:
    for key, value in changes.items():
        *path, last = path_of(key) if isinstance(key, str) else key
        table = tables
        for name in path:
            table = table[name] if isinstance(name, int) else table.setdefault(name, {})
        table[last] = value


def _leave_out(tables: Any, key: str) -> None:
    *path, last = path_of(key)
    for name in path:
        tables = tables.get(name, {})
    tables.pop(last, None)
