"""Numbers and ranges out of a deck."""

import re

import numpy as np

from vanelock.common.arrays import Integers
from vanelock.common.errors import InputError

_MOST_LISTED = 10_000_000
"""Members of all sets of a file; a mesh at the limit of its nodes has a third of a million."""
_BARE_EXPONENT = re.compile(r"(?<=[\d.])([+-]\d+)$")


def integer(text: str, where: str) -> int:
    """A whole number out of a file."""
    try:
        number = int(text.replace("_", "?"))
    except ValueError:
        raise InputError(f"{where}: {_shortened(text)} is not a whole number") from None
    if abs(number) >= 10**15:
        raise InputError(f"{where}: {_shortened(text)} is too large")
    return number


def real(text: str, where: str) -> float:
    """A real number, whose exponent may be called D, or lack its letter as in 1.5-3."""
    spelt = _BARE_EXPONENT.sub(r"E\1", text.upper().replace("D", "E").replace("_", "?"))
    try:
        return float(spelt)
    except ValueError:
        raise InputError(f"{where}: {_shortened(text)} is not a number") from None


def _shortened(text: str) -> str:
    """Text of a file, quoted, for an error's single line."""
    plain = "".join(c if c.isprintable() else "?" for c in text)
    return f'"{plain}"' if len(plain) <= 40 else f'"{plain[:37]}..."'


def span(low: int, high: int, step: int, where: str) -> Integers:
    """Numbers of a range with both ends."""
    if step < 1 or high < low:
        raise InputError(f"{where}: {low} to {high} by {step} is no range")
    if (high - low) // step > 5_000_000:
        raise InputError(f"{where}: the range {low} to {high} is too long")
    return np.arange(low, high + 1, step, dtype=np.int64)


def counted(total: int, more: Integers, where: str) -> int:
    """How many members all sets of a file have so far: short lines list very many."""
    total += len(more)
    if total > _MOST_LISTED:
        raise InputError(f"{where}: the sets have more than {_MOST_LISTED:,} members so far")
    return total
