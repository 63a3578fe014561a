"""A file of solved points that grows by one at a time, and is read when their stage begins again.

Each record is preceded by its length and its checksum, so that what a kill cut off, or something
else spoilt, is noticed and left out together with all that follows.
"""

import fcntl
import json
import zlib
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from struct import Struct

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.files.files import writing

HEAD = b"vanelock-points 1\n"
_BEFORE = Struct("<QI")


class PointsFile:
    """Solved points by label, see `vanelock.nonlinear.forced_response.options`."""

    def __init__(self, path: Path, notice: Callable[[str], None]) -> None:
        self._path, self._notice = path, notice
        self._known: dict[str, tuple[list[float], Floats]] = {}
        with writing(path):
            self._file = path.open("a+b", buffering=0)
            self._writes = True
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:  # another process computes the same; it writes, this one does not
                self._writes = False
                return
            self._file.seek(0)
            self._read(self._file.read())

    def _read(self, content: bytes) -> None:
        """Take in what was written, as far as it is whole."""
        end = len(HEAD) if content.startswith(HEAD) else 0
        while end and len(content) >= (begin := end + _BEFORE.size):
            length, checksum = _BEFORE.unpack(content[end:begin])
            record = content[begin : begin + length]
            if len(record) < length or zlib.crc32(record) != checksum:
                break
            head, _, numbers = record.partition(b"\n")
            label, values, shape = json.loads(head)
            self._known[label] = values, np.frombuffer(numbers).reshape(shape)
            end = begin + length
        if end < len(content):
            self._notice(f"{self._path}: ends in the middle of a point: what follows is left out")
            self._file.truncate(end)
        if not end:
            self._file.write(HEAD)
        self._end = max(end, len(HEAD))

    def get(self, label: str) -> tuple[list[float], Floats] | None:
        """What was written of a point: some numbers, and its unknowns."""
        return self._known.get(label)

    def add(self, label: str, numbers: Sequence[float], unknowns: Floats) -> None:
        """Write a point behind the last one."""
        if not self._writes:
            return
        head = json.dumps([label, [*numbers], unknowns.shape]).encode()
        record = head + b"\n" + np.ascontiguousarray(unknowns, float).tobytes()
        whole = memoryview(_BEFORE.pack(len(record), zlib.crc32(record)) + record)
        with writing(self._path):
            try:
                done = 0
                while done < len(whole):
                    done += self._file.write(whole[done:]) or 0
            except OSError:
                self._file.truncate(self._end)
                raise
        self._end += len(whole)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


@contextmanager
def points_file(path: Path, notice: Callable[[str], None]) -> Generator[PointsFile, None, None]:
    """The points of a stage, open while it is computed."""
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    opened = PointsFile(path, notice)
    try:
        yield opened
    finally:
        opened.close()
