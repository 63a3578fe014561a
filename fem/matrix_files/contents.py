"""What a file holds, read with a bound on memory, and the finite, Hermitian matrix made of it.

What ends in .gz is unpacked. A file of a thousandth of its contents' size is easily made, so what
is unpacked is bounded by what was packed: matrices as text shrink to a tenth, seldom to a
hundredth. Which of the matrices in a file is meant is said by its name, a customary one, or it is
the only one.

A file that stores one triangle of a symmetric matrix stands for A = T + Tᴴ - diag(T); a structure's
matrices are Hermitian, A = Aᴴ, and one that is not is some other matrix or only part of it.
"""

import gzip
import io
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.files.files import regular

_LARGEST = 4 << 30  # bytes of the largest file that is read, and of what one may unpack to
_UNPACKED, _ALWAYS = 100, 16 << 20
"""A packed file may hold this many times its size, and this many bytes anyway."""


def size_of(path: Path) -> int:
    """Bytes of a file."""
    size = regular(path, "a file of matrices")
    if size > _LARGEST:
        raise InputError(f"{path}: {size:,} bytes: at most {_LARGEST:,} are read")
    if size == 0:
        raise InputError(f"{path}: is empty")
    return size


def room(packed: int) -> int:
    """Bytes that so many packed bytes may unpack to."""
    return min(_LARGEST, max(_ALWAYS, _UNPACKED * packed))


def content(path: Path) -> bytes:
    """All bytes of a file; of one that ends in .gz, what it unpacks to."""
    size = size_of(path)
    try:
        if path.suffix.lower() != ".gz":
            return path.read_bytes()
        most = room(size)
        with gzip.open(path) as file:
            held = file.read(most + 1)
    except (EOFError, zlib.error, gzip.BadGzipFile):
        raise InputError(f"{path}: not a whole .gz file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    if len(held) > most:
        raise InputError(f"{path}: unpacks to more than {most:,} bytes from {size:,}: not read")
    return held


def text(path: Path) -> str:
    """A text file's contents."""
    held = content(path)
    if b"\0" in held:
        raise InputError(f"{path}: not a text file")
    return held.decode("utf-8-sig", "replace")


_CUSTOMARY = {
    "stiffness": ("K", "stiffness", "stif", "Kr", "Kgg", "Kaa", "Kaax"),
    "mass": ("M", "mass", "Mr", "Mgg", "Maa", "Maax"),
    "damping": ("C", "damping", "damp", "B", "D", "Bgg", "Baa", "Baax"),
}
"""Names of the matrices, upper or lower case alike; Nastran's end in the set's letters."""


class NoMatrixError(InputError):
    """A file that was searched does not hold the matrix."""


@dataclass(frozen=True)
class WantedMatrix:
    """What is looked for in a file."""

    what: str  # "stiffness", "mass" or "damping"
    name: str | None = None  # the name that the user gives
    alone: bool = True  # whether a file's only matrix is the one, whatever its name


def chosen(source: str, names: Sequence[str], request: WantedMatrix) -> str:
    """The name in the file of the matrix that is wanted."""
    if request.name is not None:
        same = [name for name in names if name == request.name]
        same = same or [name for name in names if name.lower() == request.name.lower()]
        if same:
            return same[0]
        raise NoMatrixError(f"{source}: no matrix {request.name!r}; it holds {_listed(names)}")
    for customary in _CUSTOMARY[request.what]:
        found = [name for name in names if name.lower() == customary.lower()]
        if len(found) == 1:
            return found[0]
    if request.alone and len(names) == 1:
        return names[0]
    raise NoMatrixError(
        f"{source}: which is the {request.what} matrix? It holds {_listed(names)}: give the name"
    )


def refuse_unless_alone(source: str, request: WantedMatrix) -> None:
    """A format that holds one matrix holds no other besides."""
    if not request.alone:
        raise NoMatrixError(f"{source}: holds one matrix, no {request.what} besides")


def _listed(names: Sequence[str]) -> str:
    if not names:
        return "no matrix"
    shown = ", ".join(ascii(name)[1:41].rstrip("'") for name in names[:8])
    return shown + (f" and {len(names) - 8} more" if len(names) > 8 else "")


_ASYMMETRY = 1e-8
"""Largest |A - Aᴴ| over the largest |A| that is taken for round-off of a printed number."""
FULL, SYMMETRIC, HERMITIAN = "full", "symmetric", "hermitian"


@dataclass(frozen=True)
class Entries:
    """Entries of a square matrix, and its rows' labels where the file gives them."""

    source: str  # what errors call the file
    size: int  # rows n
    rows: Integers  # (k,), places from 0
    columns: Integers
    values: Array  # (k,), the entries
    form: str = FULL  # `FULL`; or `SYMMETRIC`, `HERMITIAN` where one triangle stands for both
    node: Integers | None = None  # (n,), labels of the rows, directions as in `Matrices`
    direction: Integers | None = None
    leaves_out: bool = False  # whether the format leaves out rows in which all entries are zero
    fixed: frozenset[tuple[int, int]] = frozenset()
    """Labels that the file marks as held by a boundary condition, and which it is left without."""


def number_table(source: str, text: str, **options: Any) -> Floats:
    """Numbers by lines, as `numpy.loadtxt` reads them; their exponents may be called D."""
    try:
        return np.loadtxt(io.StringIO(text.replace("D", "E").replace("d", "e")), ndmin=2, **options)
    except (ValueError, OverflowError) as error:
        reason = (str(error).strip().splitlines() or ["not a table of numbers"])[0][:150]
        raise InputError(f"{source}: {reason}") from None


def as_integers(source: str, values: Floats, what: str, least: float = -np.inf) -> Integers:
    """Whole numbers that a table has as any others, `what` is what they count."""
    with np.errstate(invalid="ignore"):
        wrong = ~((np.abs(values) < 1e15) & (values == np.round(values)))
    if wrong.any():
        raise InputError(f"{source}: {values[wrong][0]:g} is not a {what}")
    if (outside := values[values < least]).size:
        raise InputError(f"{source}: {what} {outside[0]:g} is outside: they count from {least}")
    return values.astype(np.int64)


def square(source: str, shape: tuple[int, ...]) -> None:
    """Refuse what is not square, or has no rows."""
    if len(shape) != 2 or shape[0] != shape[1] or shape[0] < 1:
        given = " x ".join(map(str, shape)) or "a single number"
        raise InputError(f"{source}: {given}: a square matrix is needed")


def numbers(source: str, dtype: np.dtype[Any]) -> None:
    """Refuse what does not hold real or complex numbers."""
    if dtype.kind not in "iufc":
        raise InputError(f"{source}: holds {dtype}, not real or complex numbers")


def assembled(entries: Entries, what: str) -> sp.csc_array:
    """(n, n) the matrix, exactly Hermitian; complex only where it must be."""
    source, n = entries.source, entries.size
    rows, columns = np.asarray(entries.rows), np.asarray(entries.columns)
    values = np.asarray(entries.values)
    values = values.astype(np.complex128 if np.iscomplexobj(values) else np.float64)
    for name, places in (("row", rows), ("column", columns)):
        outside = (places < 0) | (places >= n)
        if outside.any():
            first = int(places[outside][0]) + 1
            raise InputError(f"{source}: an entry in {name} {first}: there are rows 1 to {n}")
    if not np.isfinite(values).all():
        k = int(np.flatnonzero(~np.isfinite(values))[0])
        place = f"({rows[k] + 1}, {columns[k] + 1})"
        raise InputError(f"{source}: entry {place} is {values[k]}: finite numbers are needed")
    _refuse_repeated(source, rows, columns, n)
    if entries.form != FULL:
        rows, columns, values = _one_triangle(entries, rows, columns, values)
    matrix = sp.coo_array((values, (rows, columns)), shape=(n, n)).tocsc()
    return _hermitian(source, matrix, what)


def _refuse_repeated(source: str, rows: Integers, columns: Integers, n: int) -> None:
    """An entry given twice is added by some programs and replaced by others."""
    keys = np.sort(rows.astype(np.int64) * n + columns)
    again = keys[1:][keys[1:] == keys[:-1]]
    if len(again):
        row, column = divmod(int(again[0]), n)
        raise InputError(f"{source}: entry ({row + 1}, {column + 1}) is given twice")


def _one_triangle(
    entries: Entries, rows: Integers, columns: Integers, values: Array
) -> tuple[Integers, Integers, Array]:
    """Both triangles; where the file gives both, they must agree."""
    n, conjugate = entries.size, entries.form == HERMITIAN
    upper = rows < columns
    mirrored = np.where(upper, values.conj() if conjugate else values, values)
    low, high = np.maximum(rows, columns), np.minimum(rows, columns)
    _, first, inverse = np.unique(
        low.astype(np.int64) * n + high, return_index=True, return_inverse=True
    )
    differs = np.abs(mirrored - mirrored[first][inverse]) > _ASYMMETRY * np.abs(mirrored)
    if differs.any():
        k = int(np.flatnonzero(differs)[0])
        place = f"({rows[k] + 1}, {columns[k] + 1})"
        raise InputError(f"{entries.source}: entry {place} differs from the one mirrored to it")
    low, high, kept = low[first], high[first], mirrored[first]
    off = low != high
    both = kept[off].conj() if conjugate else kept[off]
    return (
        np.concatenate([low, high[off]]),
        np.concatenate([high, low[off]]),
        np.concatenate([kept, both]),
    )


def _hermitian(source: str, matrix: sp.csc_array, what: str) -> sp.csc_array:
    """The Hermitian part, which differs by round-off at most."""
    largest = float(np.abs(matrix.data).max()) if matrix.nnz else 0.0
    if not largest:
        raise InputError(f"{source}: all entries of the {what} matrix are zero")
    if largest > 1e150:
        raise InputError(f"{source}: the {what} matrix has an entry of {largest:.0e}")
    adjoint = matrix.conj().T.tocsc()
    difference = matrix - adjoint
    off = float(np.abs(difference.data).max()) if difference.nnz else 0.0
    if off > _ASYMMETRY * largest:
        worst = difference.tocoo()
        k = int(np.argmax(np.abs(worst.data)))
        i, j = int(worst.row[k]), int(worst.col[k])
        kind = "Hermitian" if np.iscomplexobj(matrix.data) else "symmetric"
        raise InputError(
            f"{source}: the {what} matrix is not {kind}: entries ({i + 1}, {j + 1}) and "
            f"({j + 1}, {i + 1}) differ by {off / largest:.0e} of its largest entry"
        )
    if off:
        matrix = (0.5 * (matrix + adjoint)).tocsc()
    if np.iscomplexobj(matrix.data) and not np.any(matrix.data.imag):
        matrix = matrix.real.tocsc()
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    return matrix
