"""A study file's text with other values of some keys: comments, order and all else stay.

TOML can say the same in many ways. Keys under their table's header, or dotted, are replaced where
they stand; those that the text does not hold are added to their table. What comes out is read again
and compared, so a text that says it otherwise (in inline tables) is refused, never spoiled.
"""

import copy
import re
import tomllib
from collections.abc import Mapping
from typing import Any

from vanelock.common.errors import InputError

_HEADER = re.compile(r"\s*(\[\[?)([A-Za-z0-9_.\- \t]+)\]\]?\s*(#.*)?$")
_BARE = r"""[^\s#"'\[{]+"""
_VALUE = re.compile(
    r"""(\s*([A-Za-z0-9_.\-]+)\s*=\s*)"""
    rf"""("[^"]*"|'[^']*'|{_BARE}(?:\s+{_BARE})*)(\s*(?:#.*)?)$"""
)


def rewritten(text: str, changes: Mapping[str, float | str]) -> str:
    """The text with dotted keys set to values.

    Parameters
    ----------
    text : str
        TOML.
    changes : mapping of str to number or str
        Values by dotted key; `measured[1].file` is that of the second `[[measured]]`.

    Raises
    ------
    InputError
        If the text writes one of these tables in a way that cannot be changed.
    """
    lines = text.replace("\r\n", "\n").split("\n")
    where = _Places(lines)
    missing: dict[str, dict[str, float | str]] = {}
    for key, value in changes.items():
        if key in where.values:
            line = where.values[key]
            match = _VALUE.match(lines[line])
            assert match is not None
            lines[line] = f"{match[1]}{_toml(value)}{match[4]}"
        else:
            table, _, name = key.rpartition(".")
            missing.setdefault(table, {})[name] = value
    # From the last header on, so that the lines of earlier ones stay where they are.
    for table in sorted(missing, key=lambda each: where.headers.get(each, -1), reverse=True):
        added = [f"{name} = {_toml(value)}" for name, value in missing[table].items()]
        if table in where.headers:
            at = where.headers[table] + 1
            lines[at:at] = added
        else:
            while lines and not lines[-1].strip():
                lines.pop()
            lines += ["", f"[{table}]", *added, ""]
    made = "\n".join(lines)
    _check(text, made, changes)
    return made


class _Places:
    """Lines of headers and of values, by dotted name."""

    def __init__(self, lines: list[str]) -> None:
        self.headers: dict[str, int] = {}
        self.values: dict[str, int] = {}
        table, counts = "", dict[str, int]()
        for i, line in enumerate(lines):
            if match := _HEADER.match(line):
                table = "".join(match[2].split())
                if match[1] == "[[":
                    counts[table] = counts.get(table, -1) + 1
                    table = f"{table}[{counts[table]}]"
                self.headers[table] = i
            elif match := _VALUE.match(line):
                self.values[f"{table}.{match[2]}" if table else match[2]] = i


def _toml(value: float | str) -> str:
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return repr(value)


def _check(text: str, made: str, changes: Mapping[str, float | str]) -> None:
    """Refuse a text that does not say what was meant."""
    try:
        wanted, found = copy.deepcopy(tomllib.loads(text)), tomllib.loads(made)
    except tomllib.TOMLDecodeError:
        wanted, found = {}, {"": None}
    for key, value in changes.items():
        table: Any = wanted
        *path, last = key.split(".")
        try:
            for name in path:
                bare, _, place = name.rstrip("]").partition("[")
                table = table.setdefault(bare, {}) if not place else table[bare][int(place)]
            table[last] = value
        except (KeyError, IndexError, TypeError, AttributeError):
            found = {"": None}
    if wanted != found:
        keys = ", ".join(changes)
        raise InputError(f"the text of the study cannot be changed: set {keys} in it yourself")
