"""HDF5 files of the user or of an earlier run, opened only after a child process has read them.

The HDF5 library trusts the structures of a file: flipped bytes make it crash, loop or ask for any
amount of memory, and a small file can stand for a huge one, lead to other files, or hold itself.
So a child of limited memory and time opens the file first, and looks at every object.
"""

import errno
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vanelock.common.errors import InputError, printable
from vanelock.common.files.digests import NAMED, State, file_state
from vanelock.common.files.files import PathLike, limited, regular
from vanelock.common.process import held

UNPACKED = 256_000_000
"""Bytes that all data sets that are packed, or not written in full, may have in all."""
DENSEST = 10
"""So many times the size of the files may be added to that."""
TEXT = 64_000_000
"""Bytes of all texts in a file."""
OBJECTS = 1_000_000
DEEPEST = 32
MEMORY = 700_000_000
"""Bytes that the child may take beyond what its parent has."""
SECONDS = 4
"""Processor time of the child for a small file; a large one has a second more for 50 MB."""


@contextmanager
def opened(path: PathLike, beside: str | None = None, follow: bool = True) -> Iterator[h5py.File]:
    """A file, open for reading, whose every object could be read."""
    regular(path, "an HDF5 file")
    states = [file_state(path)]
    if follow and beside is not None and (folder := Path(path).with_name(beside)).is_dir():
        states += [file_state(each) for each in os.scandir(folder) if each.is_file()]
    _refuse(Path(path), beside, follow, tuple(states))
    try:
        file = h5py.File(path, "r")
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: not a readable HDF5 file ({_said(error)})") from None
    with file:
        yield file


@contextmanager
def written(path: PathLike, mode: str = "w", block: int = 0) -> Iterator[h5py.File]:
    """A file, open for writing, "w", or for additions, "a"; a new one may begin with a block.

    Where the disk is full the HDF5 library must not learn of it: it drops small data sets without a
    word, and crashes as it closes the file. So it is given success, and what the system
    said is raised when it is done. Nor can a signal's exception pass through it: signals wait while
    the file is opened and closed, and should wait while it is written (`signals.held`).
    """
    with _Sink(path, "w+" if mode == "w" else "r+") as sink:
        with held():
            file = h5py.File(sink, mode, userblock_size=block if mode == "w" else None)
        try:
            yield file
        finally:
            with held():
                file.close()
        if sink.error is not None:
            raise sink.error


class _Sink(io.FileIO):
    """A file for the HDF5 library whose writes never fail; the first error is kept."""

    error: OSError | None = None

    def readinto(self, target: Any, /) -> int:
        """Read as much as is asked for; zeros where nothing could be written."""
        view = memoryview(target).cast("B")
        done = 0
        while done < len(view) and (more := super().readinto(view[done:])):
            done += more
        view[done:] = bytes(len(view) - done)
        return len(view)

    def write(self, data: Any, /) -> int:
        """Write all of it."""
        view = memoryview(data).cast("B")
        done = 0
        try:
            while done < len(view) and self.error is None:
                done += super().write(view[done:]) or 0
        except OSError as error:
            self.error = error
        return len(view)

    def truncate(self, size: int | None = None, /) -> int:
        """Make it so many bytes long."""
        try:
            if self.error is None:
                super().truncate(size)
        except OSError as error:
            self.error = error
        return size or 0


def texts(dataset: h5py.Dataset) -> list[str]:
    """The texts of a data set of one dimension, or none."""
    return [str(each) for each in np.atleast_1d(dataset.asstr()[()]).tolist()]


@lru_cache(maxsize=64)
def _refuse(path: Path, beside: str | None, follow: bool, states: tuple[State, ...]) -> None:
    """Report what a child says that reads the files, or that it fell, unless it did so before."""
    size = sum(state[0] for state in states)
    seconds = SECONDS + size // 50_000_000 + len(states) // 50
    if why := limited(lambda: _trouble(path, size, beside, follow), seconds, MEMORY + 2 * size):
        raise InputError(f"{path}: not a readable HDF5 file ({why})")


def _trouble(path: Path, size: int, beside: str | None, follow: bool) -> str:
    """What is wrong with a file and those that it leads to, "" where nothing is."""
    walk = _Walk(size, beside)
    waiting, seen = [path], {path}
    try:
        while waiting:
            each = waiting.pop()
            found = walk.file(each) - seen
            seen |= found
            waiting += found if follow else ()
    except _Refused as refused:
        return str(refused)
    except FileNotFoundError:
        return f"{each.parent.name}/{_plain(each.name)}, which it leads to, is missing"
    except MemoryError:
        raise
    except Exception as error:
        said = _said(error)
        return said if each == path else f"{each.parent.name}/{_plain(each.name)}: {said}"
    return ""


def _said(error: Exception) -> str:
    """An error's text on one line that a terminal can show."""
    if isinstance(error, OSError) and error.errno == errno.EAGAIN:  # HDF5's lock
        return "it is open for writing in another program: close it there"
    if isinstance(error, OSError) and error.errno:
        return os.strerror(error.errno)
    first = (str(error.args[0] if error.args else error).splitlines() or [""])[0]
    return printable(first)[:200] or type(error).__name__


class _Refused(Exception):
    """What a file holds that is not read."""


class _Walk:
    """Looks at every object of some files once, and adds up what they would take in memory."""

    def __init__(self, size: int, beside: str | None) -> None:
        self.size, self.beside = size, beside
        self.seen: set[int] = set()
        self.unpacked = self.text = self.links = 0
        self.places: set[Path] = set()

    def file(self, path: Path) -> set[Path]:
        """All of a file; the files that it leads to."""
        self.path, self.seen, self.places = path, set(), set()
        with h5py.File(path, "r") as file:
            self.group(file, 0, ())
        return self.places

    def group(self, group: h5py.Group, depth: int, above: tuple[int, ...]) -> None:
        """A group and all below it."""
        self._attributes(group)
        if depth > DEEPEST:
            raise _Refused("its groups lie too deep in one another")
        place = h5py.h5o.get_info(group.id).addr
        if place in above:
            raise _Refused("a group contains itself")
        if place in self.seen:
            return
        self.seen.add(place)
        for name in group:
            self.links += 1
            if self.links > OBJECTS:
                raise _Refused(f"more than {OBJECTS:,} objects")
            kind = group.get(name, getlink=True)
            if isinstance(kind, h5py.SoftLink):  # leads to what is looked at in its own place
                continue
            if isinstance(kind, h5py.ExternalLink) and self._beside(kind.filename):
                continue
            if not isinstance(kind, h5py.HardLink):
                raise _Refused(f"{_plain(name)} is a link to another file")
            value = group[name]
            if isinstance(value, h5py.Group):
                self.group(value, depth + 1, (*above, place))
            elif isinstance(value, h5py.Dataset):
                self._dataset(value)

    def _beside(self, target: str) -> bool:
        """Whether a file may be led to."""
        folder, _, name = target.rpartition("/")
        own = self.beside if NAMED.search(self.path.name) is None else ""
        if self.beside is None or folder != own or NAMED.search(name) is None:
            return False
        self.places.add(self.path.with_name(folder) / name if folder else self.path.with_name(name))
        return True

    def _attributes(self, item: Any) -> None:
        for value in item.attrs.values():
            self._add_text(value)

    def _dataset(self, dataset: h5py.Dataset) -> None:
        self._attributes(dataset)
        where, plan = _plain(dataset.name), dataset.id.get_create_plist()
        if dataset.is_virtual or plan.get_external_count():
            raise _Refused(f"{where}: its data lie in other files")
        size = int(dataset.size or 0) * dataset.dtype.itemsize  # exact: NumPy's product wraps
        stored = dataset.id.get_storage_size()
        packed = plan.get_nfilters() or size > stored
        if packed:
            self.unpacked += size
            if self.unpacked > (most := UNPACKED + DENSEST * self.size):
                raise _Refused(f"{where}: it is packed, and more than {most:,} bytes in all")
        elif size > self.size:
            raise _Refused(f"{where}: larger than the file")
        if dataset.dtype.kind == "O":
            self._texts(dataset)
        elif packed or dataset.chunks:
            dataset[()]
        elif size:
            dataset[(0,) * dataset.ndim], dataset[(-1,) * dataset.ndim]

    def _texts(self, dataset: h5py.Dataset) -> None:
        """Texts in slices: any number of them may be one and the same long one in the file."""
        if dataset.ndim == 0:
            return self._add_text(dataset[()])
        width = max(int(np.prod(dataset.shape[1:])), 1)
        for start in range(0, len(dataset), max(256 // width, 1)):
            self._add_text(dataset[start : start + max(256 // width, 1)])
        return None

    def _add_text(self, value: Any) -> None:
        found = value.ravel().tolist() if isinstance(value, np.ndarray) else [value]
        self.text += sum(len(each) for each in found if isinstance(each, str | bytes))
        if self.text > TEXT:
            raise _Refused(f"more than {TEXT:,} bytes of text")


def _plain(name: str | None) -> str:
    return printable(name or "")[:80]
