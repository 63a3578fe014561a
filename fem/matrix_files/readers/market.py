"""Matrix Market files: text, a list of entries or a full array, one triangle where symmetric.

The format: R. Boisvert, R. Pozo, K. Remington, "The Matrix Market Exchange Formats: Initial
Design", NISTIR 5935, 1996 (math.nist.gov/MatrixMarket/formats.html). Ansys writes it
by `*EXPORT, K, MMF`, SciPy by `scipy.io.mmwrite`. SciPy's reader is not used here: on a damaged
file it ends the program (SciPy 1.17, `_fast_matrix_market`: a segmentation fault).
"""

import re
from codecs import BOM_UTF8
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import WantedMatrix, content
from vanelock.fem.matrix_files.entries import (
    FULL,
    HERMITIAN,
    SYMMETRIC,
    Entries,
    number_table,
    square,
    whole,
)

_FORMS = {"general": FULL, "symmetric": SYMMETRIC, "hermitian": HERMITIAN}
_FIELDS = ("real", "double", "complex", "integer", "unsigned-integer")
_LAYOUTS = ("coordinate", "array")


def read_market(path: Path, wanted: WantedMatrix) -> Entries:
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
        row, column = (whole(source, table[:, k], "row or column", 1) - 1 for k in (0, 1))
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
