"""Text of a TOML file as nested tables, of a size and depth that nothing after it chokes on.

Python's parser takes time with the square of a dotted key's length, refuses some text by other
errors than its own, and knows neither the format's largest integer nor a deepest nesting.
"""

import re
import tomllib
from typing import Any

from vanelock.common.errors import InputError, printable

LARGEST = 2_000_000
"""Bytes of the largest study or scene file."""
DEEPEST = 12
"""Tables and lists within one another; the schemas have half of that."""
_WORD = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"(?<![\w-]){_WORD}(?:[ \t]*+\.[ \t]*+{_WORD}){{{4 * DEEPEST}}}")


def toml_tables(text: str, where: str) -> dict[str, Any]:
    """The tables of a TOML file."""
    if len(text) > LARGEST:
        raise InputError(f"{where}: more than {LARGEST:,} bytes: at most that are read")
    if long := _LONG_KEY.search(text):
        line = text.count("\n", 0, long.start()) + 1
        raise InputError(f"{where}: line {line}: nested too deeply")
    try:
        found = tomllib.loads(text.replace("\r\n", "\n"))
    except tomllib.TOMLDecodeError as error:
        message = printable(str(error))
        place = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", message)
        if place is None:
            raise InputError(f"{where}: not valid TOML: {message[:200]}") from None
        number = place[2] or str(len(text.splitlines()) or 1)
        raise InputError(f"{where}: line {number}: not valid TOML: {place[1][:200]}") from None
    except RecursionError:
        raise InputError(f"{where}: nested too deeply") from None
    except ValueError as error:  # an integer of thousands of digits, a date that is none
        raise InputError(f"{where}: not valid TOML: {str(error)[:200]}") from None
    _check(found, where)
    return found


def _check(table: dict[str, Any], where: str) -> None:
    """Refuse what is nested too deeply and integers of more than 64 bits."""
    waiting: list[tuple[Any, list[Any]]] = [(table, [])]
    while waiting:
        value, path = waiting.pop()
        if isinstance(value, dict | list):
            if len(path) > DEEPEST:
                raise InputError(f"{where}: nested too deeply")
            inner = value.items() if isinstance(value, dict) else enumerate(value)
            waiting += [(each, [*path, key]) for key, each in inner]
        elif isinstance(value, int) and not -(2**63) <= value < 2**63:
            key = "".join(f"[{word}]" if isinstance(word, int) else f".{word}" for word in path)
            shown = printable(key[1:])[:200]
            raise InputError(f"{where}: {shown}: not valid TOML: an integer of more than 64 bits")
