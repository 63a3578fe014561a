"""Sparse matrices as text: Matrix Market, Harwell-Boeing and Rutherford-Boeing files.

Matrix Market lists entries or a full array, of a symmetric matrix one triangle: R. Boisvert, R.
Pozo, K. Remington, "The Matrix Market Exchange Formats: Initial Design", NISTIR 5935, 1996
(math.nist.gov/MatrixMarket/formats.html). Ansys writes it by `*EXPORT, K, MMF`, SciPy by
`scipy.io.mmwrite`. SciPy's reader is not used here: on a damaged file it ends the program (SciPy
1.17, `_fast_matrix_market`: a segmentation fault).

Harwell-Boeing lists compressed columns in Fortran's fixed formats: I. Duff, R. Grimes, J. Lewis,
"Users' Guide for the Harwell-Boeing Sparse Matrix Collection", TR/PA/92/86, CERFACS 1992; "The
Rutherford-Boeing Sparse Matrix Collection", RAL-TR-97-031. Ansys's `HBMAT` writes the first, with
the right-hand side after the matrix. Where numbers touch they are told apart by their width.
"""

import re
from codecs import BOM_UTF8
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import (
    FULL,
    HERMITIAN,
    SYMMETRIC,
    Entries,
    WantedMatrix,
    as_integers,
    content,
    number_table,
    square,
    text,
)

_FORMS = {"general": FULL, "symmetric": SYMMETRIC, "hermitian": HERMITIAN}
_FIELDS = ("real", "double", "complex", "integer", "unsigned-integer")
_LAYOUTS = ("coordinate", "array")


def read_market(path: Path, request: WantedMatrix) -> Entries:
    """Read a .mtx or .mtx.gz file that begins with a Matrix Market banner."""
    source, held = str(path), content(path).removeprefix(BOM_UTF8)
    banner, _, rest = held.partition(b"\n")
    words = banner[:200].decode("ascii", "replace").lower().split()
    if len(words) != 5 or words[:2] != ["%%matrixmarket", "matrix"]:
        raise InputError(f"{source}: line 1: not the banner of a Matrix Market matrix")
    layout, field, symmetry = words[2:]
    for word, allowed in ((layout, _LAYOUTS), (field, _FIELDS), (symmetry, tuple(_FORMS))):
        if word not in allowed:
            raise InputError(f"{source}: line 1: {word[:30]!a}: allowed are {', '.join(allowed)}")
    n, given, start = _sizes(source, layout, symmetry != "general", rest)
    parts = 2 if field == "complex" else 1
    places = 2 if layout == "coordinate" else 0
    table = _table(source, rest[start:], given, places + parts)
    values = table[:, places] if parts == 1 else table[:, places] + 1j * table[:, places + 1]
    if places:
        row, column = (as_integers(source, table[:, k], "row or column", 1) - 1 for k in (0, 1))
    elif symmetry == "general":
        column, row = np.divmod(np.arange(given), n)
    else:
        column, row = np.triu_indices(n)  # the lower triangle, column by column
    return Entries(source, n, row, column, values, _FORMS[symmetry])


def _sizes(source: str, layout: str, half: bool, rest: bytes) -> tuple[int, int, int]:
    """Rows, entries, and where these begin; refused if so many cannot stand in the file."""
    start, line = 0, b"%"
    while line.startswith(b"%") or not line.strip():
        if start >= len(rest):
            raise InputError(f"{source}: ends before its sizes")
        end = rest.find(b"\n", start)
        end = len(rest) if end < 0 else end
        line, start = rest[start : min(end, start + 1000)].strip(), end + 1
    wanted = 3 if layout == "coordinate" else 2
    words = line.decode("ascii", "replace").split()
    if len(words) != wanted or not all(re.fullmatch(r"\d{1,18}", word) for word in words):
        shown = line[:60].decode("ascii", "replace")
        raise InputError(f"{source}: its sizes are {shown!a}: {wanted} whole numbers are needed")
    sizes = [int(word) for word in words]
    square(source, tuple(sizes[:2]))
    n = sizes[0]
    given = sizes[2] if wanted == 3 else n * (n + 1) // 2 if half else n * n
    shortest = 6 if wanted == 3 else 2  # "1 1 1\n", "1\n"
    left = len(rest) - start + 1
    for number, what in ((given * shortest - shortest, "entries"), (n, "rows")):
        if number > left:
            count = given if what == "entries" else n
            raise InputError(f"{source}: {count:,} {what} are announced, but {left:,} bytes follow")
    return n, given, start


def _table(source: str, held: bytes, rows: int, columns: int) -> Floats:
    """(rows, columns) the numbers of as many lines."""
    if not rows:
        raise InputError(f"{source}: has no entries")
    try:
        table = number_table(source, held.decode("ascii"), comments=None)
    except UnicodeDecodeError:
        raise InputError(f"{source}: not a text file") from None
    if table.shape != (rows, columns):
        raise InputError(
            f"{source}: {table.shape[0]:,} lines of {table.shape[1]} numbers follow, not the "
            f"{rows:,} of {columns} that are announced"
        )
    return table


_SYMMETRIES = {"u": FULL, "r": FULL, "s": SYMMETRIC, "h": HERMITIAN}
_BARE = re.compile(r"([\d.])([+-]\d)")
_FORMAT = re.compile(r"\((?:\d*P,?)?(\d*)([IEDFG])(\d{1,3})(?:\.\d+)?(?:E\d+)?\)")


def read_harwell(path: Path, request: WantedMatrix) -> Entries:
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
    if values not in "rci" or symmetry not in _SYMMETRIES or storage != "a":
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
    return Entries(source, n, row - 1, columns, number, _SYMMETRIES[symmetry])


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
