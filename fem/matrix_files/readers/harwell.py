"""Harwell-Boeing and Rutherford-Boeing files: columns, compressed, in Fortran's fixed formats.

I. Duff, R. Grimes, J. Lewis, "Users' Guide for the Harwell-Boeing Sparse Matrix Collection",
TR/PA/92/86, CERFACS 1992; "The Rutherford-Boeing Sparse Matrix Collection", RAL-TR-97-031. Ansys's
`HBMAT` writes the first, with the right-hand side after the matrix. Where
numbers touch they are told apart by their width.
"""

import re
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Array, Integers
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import WantedMatrix, text
from vanelock.fem.matrix_files.entries import FULL, HERMITIAN, SYMMETRIC, Entries, square

_FORMS = {"u": FULL, "r": FULL, "s": SYMMETRIC, "h": HERMITIAN}
_BARE = re.compile(r"([\d.])([+-]\d)")
_FORMAT = re.compile(r"\((?:\d*P,?)?(\d*)([IEDFG])(\d{1,3})(?:\.\d+)?(?:E\d+)?\)")


def read_harwell(path: Path, wanted: WantedMatrix) -> Entries:
    """Read an assembled real or complex matrix."""
    source, lines = str(path), text(path).splitlines()
    if len(lines) < 5:
        raise InputError(f"{source}: not a Harwell-Boeing file: {len(lines)} lines")
    counts = _integers(source, 2, lines[1], 4)
    kind, *rest = lines[2].split()
    sizes = _integers(source, 3, " ".join(rest), 3)
    if not re.fullmatch(r"[a-z]{3}", kind.lower()):
        raise InputError(f"{source}: line 3: {kind[:20]!a} is not a type such as RSA")
    values, symmetry, storage = tuple(kind.lower())
    if values not in "rci" or symmetry not in _FORMS or storage != "a":
        raise InputError(
            f"{source}: line 3: type {kind}: real or complex (R, C), symmetric, Hermitian or "
            "unsymmetric (S, H, U), assembled (A) matrices are read"
        )
    square(source, (sizes[0], sizes[1]))
    n, entries = sizes[0], sizes[2]
    doubled = 2 if values == "c" else 1
    formats = [word.upper() for word in re.findall(r"\([^()]*\)", lines[3])]
    if len(formats) < 3:
        raise InputError(f"{source}: line 4: three formats are needed")
    has_rhs_line = len(counts) > 4 and counts[4] > 0
    block = _Blocks(source, lines, 5 if has_rhs_line else 4)
    pointer = block.integers(counts[1], formats[0], n + 1)
    row = block.integers(counts[2], formats[1], entries)
    number = block.reals(counts[3], formats[2], entries * doubled)
    if doubled == 2:
        number = number[0::2] + 1j * number[1::2]
    if pointer[0] != 1 or pointer[-1] != entries + 1 or (np.diff(pointer) < 0).any():
        raise InputError(f"{source}: its column pointers do not rise from 1 to {entries + 1}")
    columns = np.repeat(np.arange(n), np.diff(pointer))
    return Entries(source, n, row - 1, columns, number, _FORMS[symmetry])


def _integers(source: str, line: int, words: str, least: int) -> list[int]:
    found = words.split()
    if len(found) < least or not all(re.fullmatch(r"\d{1,15}", word) for word in found):
        raise InputError(f"{source}: line {line}: at least {least} whole numbers are needed")
    return [int(word) for word in found]


class _Blocks:
    """The blocks of numbers below the head, one after the other."""

    def __init__(self, source: str, lines: list[str], start: int) -> None:
        self.source, self.lines, self.start = source, lines, start

    def integers(self, lines: int, form: str, count: int) -> Integers:
        """(count,) whole numbers."""
        try:
            return np.array(self._words(lines, form, count, "I"), "S").astype(np.int64)
        except (ValueError, OverflowError):
            raise InputError(f"{self.source}: text where whole numbers are needed") from None

    def reals(self, lines: int, form: str, count: int) -> Array:
        """(count,) numbers; D and a bare sign are exponents as E."""
        words = self._words(lines, form, count, "EDFGI")
        try:
            plain = [word.upper().replace("D", "E") for word in words]
            plain = [_BARE.sub(r"\1E\2", word) for word in plain]
            return np.array(plain, "S").astype(np.float64)
        except (ValueError, OverflowError):
            raise InputError(f"{self.source}: text where numbers are needed") from None

    def _words(self, lines: int, form: str, count: int, letters: str) -> list[str]:
        found = _FORMAT.fullmatch(form.replace(" ", ""))
        if found is None or found[2] not in letters or int(found[3]) < 1:
            raise InputError(f"{self.source}: line 4: format {form[:30]!a} is not read")
        width = int(found[3])
        block = self.lines[self.start : self.start + lines]
        self.start += lines
        if count > sum(map(len, block)) or len(block) < lines:
            raise InputError(f"{self.source}: ends before its {count:,} numbers")
        words = " ".join(block).split()  # SciPy's are not as wide as its formats say
        if len(words) != count:
            words = [
                word
                for line in block
                for k in range(0, len(line), width)
                if (word := line[k : k + width].strip())
            ]
        if len(words) != count:
            raise InputError(f"{self.source}: {len(words):,} numbers where {count:,} are announced")
        if any(not word.isascii() for word in words):
            raise InputError(f"{self.source}: text where numbers are needed")
        return words
