"""What a file holds, read with a bound on memory; .gz is unpacked.

A file of a thousandth of its contents' size is easily made, so what is unpacked is bounded by what
was packed: matrices as text shrink to a tenth, seldom to a hundredth.
"""

import gzip
import zlib
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
