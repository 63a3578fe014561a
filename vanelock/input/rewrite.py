"""A study file's text with other values of some keys: comments, order and all else stay."""

import tomllib
from collections.abc import Mapping
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from vanelock.common.errors import InputError


def rewritten(text: str, changes: Mapping[str, float | str]) -> str:
    """The text with dotted keys set to values; what it does not hold is added to its table.

    Parameters
    ----------
    text : str
        TOML.
    changes : mapping of str to number or str
        Values by dotted key; `measured[1].file` is that of the second `[[measured]]`.

    Raises
    ------
    InputError
        If the text is not TOML, or writes one of these tables in a way that cannot be changed.
    """
    try:
        wanted, document = tomllib.loads(text), tomlkit.parse(text)
        _set(wanted, changes)
        _set(document, changes)
        made = tomlkit.dumps(document)
        said = tomllib.loads(made) == wanted
    except (TOMLKitError, ValueError, LookupError, TypeError, AttributeError):
        said = False
    if not said:
        keys = ", ".join(changes)
        raise InputError(f"the text of the study cannot be changed: set {keys} in it yourself")
    return made


def _set(tables: Any, changes: Mapping[str, float | str]) -> None:
    for key, value in changes.items():
        table = tables
        *path, last = key.split(".")
        for name in path:
            bare, _, place = name.rstrip("]").partition("[")
            table = table[bare][int(place)] if place else table.setdefault(bare, {})
        table[last] = value
