"""Digests of files, so that damage and mix-ups are noticed.

A file that is written once has the digest of its bytes in its name, `mu=0.1-<digest>.h5`, and lists
the files that it links to, which are named in the same way: where its own name fits, theirs are
those that it was written with. The file that changes as a run goes on has its digest in the block
before its HDF5 data.

No protection from intent: whoever alters a file can give it a digest that fits.
"""

import hashlib
import os
import re
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

import h5py

from vanelock.common.errors import InputError

NEEDS = "files"
"""Attribute of a file that was written once: names of all others in its folder that it needs."""
BLOCK = 512
"""Bytes before the HDF5 data of a file that changes."""
NAMED = re.compile(r"-([0-9a-f]{20})\.h5$")


def file_digest(path: Path, start: int = 0) -> str:
    """Digest of a file's bytes, from one of them on."""
    with path.open("rb") as file:
        file.seek(start)
        return hashlib.file_digest(file, "sha256").hexdigest()[:20]


def stamp(path: Path) -> None:
    """Write the digest of a file that changes into the block before its HDF5 data."""
    digest = file_digest(path, BLOCK)
    with path.open("r+b") as file:
        file.write(digest.encode())


def verify(group: h5py.Group) -> None:
    """Refuse a group of results whose file, or one that it needs, is not what was written."""
    file = group.file
    names = needs(file)
    if names is None and file.userblock_size != BLOCK:
        return
    path = Path(os.fsdecode(file.filename))
    for name in (path.name, *(names or ())):
        verify_file(path.with_name(name))


def needs(file: h5py.File) -> list[str] | None:
    """Names of the files, in its folder, that a file needs; None where it does not say."""
    if not h5py.h5a.exists(file.id, NEEDS.encode()):
        return None
    return [name for name in str(file.attrs[NEEDS]).split("/") if name]


def verify_file(path: Path) -> None:
    """Refuse a file that is not what its name says, or where that says nothing, its first block."""
    named = NAMED.search(path.name)
    digest = content_digest(path, 0 if named else BLOCK)
    if digest != (named[1] if named else _stated(path)):
        raise InputError(f"{path}: is not what was written: damaged, or altered since")


def _stated(path: Path) -> str:
    """What the block before the data says."""
    with path.open("rb") as file:
        return file.read(20).decode("ascii", "replace")


State: TypeAlias = tuple[int, int, int]


def file_state(path: str | os.PathLike[str]) -> State:
    """What changes when a file does: its size, among others."""
    found = os.stat(path)
    return found.st_size, found.st_mtime_ns, found.st_ino


def content_digest(path: str | os.PathLike[str], start: int = 0) -> str:
    """Digest of a user's file, taken anew when its size or time of change differ."""
    try:
        return _known_digest(Path(path), start, file_state(path))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None


@lru_cache(maxsize=1 << 16)
def _known_digest(path: Path, start: int, state: State) -> str:
    return file_digest(path, start)
