"""A file of records that grows by one at a time, and is read again from its beginning.

Each record is preceded by its length and its checksum, so that what a kill cut off, or something
else spoilt, is noticed and left out together with all that follows.
"""

import fcntl
import os
import zlib
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from struct import Struct

from vanelock.common.files.files import writing

HEAD = b"vanelock-journal 1\n"
_BEFORE = Struct("<QI")


class JournalFile:
    """An open journal, see `vanelock.nonlinear.forced_response.replay`."""

    def __init__(self, path: Path, notice: Callable[[str], None]) -> None:
        self._path, self._notice = path, notice
        with writing(path):
            self._file = path.open("a+b", buffering=0)
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:  # another process computes the same; it writes, this one does not
                self._file.close()
                self._end, self._reads = -1, False
                return
            self._file.seek(0)
            self._size = self._file.seek(0, os.SEEK_END)
            self._file.seek(0)
            self._end, self._last, self._reads = 0, 0, True
            if self._size and self._file.read(len(HEAD)) != HEAD:
                self._leave_out("is not a journal of this version")
            if not self._size:
                self._file.write(HEAD)
            self._end = self._last = len(HEAD)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def next(self) -> bytes | None:
        """The next record; None behind the last one."""
        if not self._reads:
            return None
        with writing(self._path):
            record = self._record()
        if record is None:
            self._reads = False
            if self._end < self._size:
                self._leave_out("ends in the middle of a point")
            return None
        self._last = self._end
        self._end += _BEFORE.size + len(record)
        return record

    def _record(self) -> bytes | None:
        self._file.seek(self._end)
        before = self._file.read(_BEFORE.size)
        if len(before) < _BEFORE.size:
            return None
        length, checksum = _BEFORE.unpack(before)
        if length > self._size - self._end - _BEFORE.size:
            return None
        record = self._file.read(length)
        return record if zlib.crc32(record) == checksum else None

    def drop(self) -> None:
        """Leave out the last record and all that follow."""
        self._end, self._reads = self._last, False
        self._leave_out("holds points of another computation")

    def add(self, record: bytes) -> None:
        """Write a record behind the last one."""
        self._reads = False
        if self._end < 0:
            return
        whole = _BEFORE.pack(len(record), zlib.crc32(record)) + record
        with writing(self._path):
            try:
                done = 0
                while done < len(whole):
                    done += self._file.write(memoryview(whole)[done:]) or 0
            except OSError:
                self._file.truncate(self._end)
                raise
        self._end += len(whole)

    def _leave_out(self, why: str) -> None:
        self._notice(f"{self._path}: {why}: what follows is computed again")
        self._file.truncate(self._end)
        self._size = self._end


class NoJournal:
    """Where nothing can be written down."""

    def next(self) -> None:
        """There is no record."""

    def drop(self) -> None:
        """Nothing is forgotten."""

    def add(self, record: bytes) -> None:
        """Nothing is kept."""


@contextmanager
def journal(
    path: Path | None, notice: Callable[[str], None] = lambda text: None
) -> Generator[JournalFile | NoJournal, None, None]:
    """A journal, open while a stage is computed; one that keeps nothing where there is no path."""
    if path is None:
        yield NoJournal()
        return
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    opened = JournalFile(path, notice)
    try:
        yield opened
    finally:
        opened.close()
