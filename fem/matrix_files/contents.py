"""What a file holds, read with a bound on memory; .gz is unpacked.

A file of a thousandth of its contents' size is easily made, so what is unpacked is bounded by what
was packed: matrices as text shrink to a tenth, seldom to a hundredth. Which of the matrices in a
file is meant is said by its name, a customary one, or it is the only one.
"""

import gzip
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vanelock.common.errors import InputError
from vanelock.common.files.files import regular

LARGEST = 4 << 30
"""Bytes of the largest file that is read, and of what one may unpack to."""
UNPACKED, ALWAYS = 100, 16 << 20
"""A packed file may hold this many times its size, and this many bytes anyway."""


def size_of(path: Path) -> int:
    """Bytes of a file."""
    size = regular(path, "a file of matrices")
    if size > LARGEST:
        raise InputError(f"{path}: {size:,} bytes: at most {LARGEST:,} are read")
    if size == 0:
        raise InputError(f"{path}: is empty")
    return size


def room(packed: int) -> int:
    """Bytes that so many packed bytes may unpack to."""
    return min(LARGEST, max(ALWAYS, UNPACKED * packed))


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


CUSTOMARY = {
    "stiffness": ("K", "stiffness", "stif", "Kr", "Kgg", "Kaa", "Kaax"),
    "mass": ("M", "mass", "Mr", "Mgg", "Maa", "Maax"),
    "damping": ("C", "damping", "damp", "B", "D", "Bgg", "Baa", "Baax"),
}
"""Names of the matrices, upper or lower case alike; Nastran's end in the set's letters."""


class NoMatrixError(InputError):
    """A file that was searched does not hold the matrix."""


@dataclass(frozen=True)
class WantedMatrix:
    """What is looked for in a file.

    Attributes
    ----------
    what : str
        "stiffness", "mass" or "damping".
    name : str or None
        The name that the user gives.
    alone : bool
        Whether a file's only matrix is the one, whatever its name.
    """

    what: str
    name: str | None = None
    alone: bool = True


def chosen(source: str, names: Sequence[str], wanted: WantedMatrix) -> str:
    """The name in the file of the matrix that is wanted."""
    if wanted.name is not None:
        same = [name for name in names if name == wanted.name]
        same = same or [name for name in names if name.lower() == wanted.name.lower()]
        if same:
            return same[0]
        raise NoMatrixError(f"{source}: no matrix {wanted.name!r}; it holds {_listed(names)}")
    for customary in CUSTOMARY[wanted.what]:
        found = [name for name in names if name.lower() == customary.lower()]
        if len(found) == 1:
            return found[0]
    if wanted.alone and len(names) == 1:
        return names[0]
    raise NoMatrixError(
        f"{source}: which is the {wanted.what} matrix? It holds {_listed(names)}: give the name"
    )


def refuse_unless_alone(source: str, wanted: WantedMatrix) -> None:
    """A format that holds one matrix holds no other besides."""
    if not wanted.alone:
        raise NoMatrixError(f"{source}: holds one matrix, no {wanted.what} besides")


def _listed(names: Sequence[str]) -> str:
    if not names:
        return "no matrix"
    shown = ", ".join(ascii(name)[1:41].rstrip("'") for name in names[:8])
    return shown + (f" and {len(names) - 8} more" if len(names) > 8 else "")
