"""Products kept in a run's folder under a hash of exactly the inputs that they depend on.

An entry is one HDF5 file whose name holds the stage, the key and the digest of the file's bytes: a
truncated or altered entry is noticed before it is read, and computed again. It lies in a folder
named by the first letters of its key.

A file of solved points that grows by one at a time, and is read when their stage begins again.

Each record is preceded by its length and its checksum, so that what a kill cut off, or something
else spoilt, is noticed and left out together with all that follows.
"""

import fcntl
import hashlib
import json
import os
import zlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from secrets import token_hex
from struct import Struct
from typing import Any, Generic, NamedTuple, TypeVar

import h5py
import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.common.files.digests import file_digest
from vanelock.common.files.files import writing
from vanelock.common.files.hdf5 import written
from vanelock.common.process import __version__, held, installed, release
from vanelock.common.product import Product

HEAD = b"vanelock-points 1\n"
_BEFORE = Struct("<QI")


class _PointsFile:
    """Solved points by label, see `vanelock.nonlinear.forced_response.options`."""

    def __init__(self, path: Path, notice: Callable[[str], None]) -> None:
        self._path, self._notice = path, notice
        self._known: dict[str, tuple[list[float], Floats]] = {}
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
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


P = TypeVar("P", bound=Product)
SHARD = 2
"""Letters of a key that name its entry's folder: among 256 folders a name is found fast."""
CODE = {".py", ".html", ".css", ".js"}
"""Endings of the files that say what the program does."""


class Entry(NamedTuple, Generic[P]):
    """A product out of the cache; seconds that computing it took, and took of processor time."""

    product: P
    seconds: float
    cpu: float


@dataclass(frozen=True)
class Cache:
    """The cache of one run's folder.

    Attributes
    ----------
    folder : Path
        Where the entries are; made when the first one is stored.
    notice : callable
        Called with one line of text when an entry had to be dropped.
    """

    folder: Path
    notice: Callable[[str], None]

    def load(self, stage: str, key: str, kind: type[P]) -> Entry[P] | None:
        """The stored product, or None where there is none that is intact."""
        for path in sorted((self.folder / key[:SHARD]).glob(f"{_flat(stage)}-{key}-*.h5")):
            try:
                if file_digest(path) != path.stem.rpartition("-")[2]:
                    raise InputError("its contents have changed since it was written")
                entry = _read_entry(path, kind, key)
                entry.product.stored_in(path)
                self._points(stage, key).unlink(missing_ok=True)
                return entry
            except (InputError, KeyError, OSError) as error:
                reason = str(error).splitlines()[0]
                self.notice(f"{path}: damaged cache entry, computing {stage} again ({reason})")
                path.unlink(missing_ok=True)
        return None

    def store(self, stage: str, key: str, product: P, seconds: float, cpu: float = 0.0) -> Entry[P]:
        """Keep a product; a kill leaves a whole entry or none."""
        with writing(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)
            temporary = self.folder / f".{_flat(stage)}.{token_hex(4)}.tmp"
            try:
                with held(), written(temporary) as file:
                    file.attrs.update(stage=stage, key=key, seconds=seconds, cpu=cpu)
                    product.save(file.create_group("product"))
                digest, entry = file_digest(temporary), _read_entry(temporary, type(product), key)
                place = self.folder / key[:SHARD] / f"{_flat(stage)}-{key}-{digest}.h5"
                place.parent.mkdir(exist_ok=True)
                os.replace(temporary, place)
                entry.product.stored_in(place)
                self._points(stage, key).unlink(missing_ok=True)
            finally:
                temporary.unlink(missing_ok=True)
        return entry

    def points(self, stage: str, key: str) -> closing[_PointsFile]:
        """Where a stage that takes long writes down its points until its product is stored."""
        return closing(_PointsFile(self._points(stage, key), self.notice))

    def held(self) -> Callable[[str, str], bool]:
        """What says whether there is an entry, intact or not, of any number as they are now."""
        names = {path.name.rpartition("-")[0] for path in self.folder.glob("*/*.h5")}
        return lambda stage, key: f"{_flat(stage)}-{key}" in names

    def _points(self, stage: str, key: str) -> Path:
        return self.folder / f"{_flat(stage)}-{key}.points"


def _read_entry(file: Path, kind: type[P], key: str) -> Entry[P]:
    """The product in an entry's file, as loading it gives."""
    with h5py.File(file, "r") as opened:
        if opened.attrs["key"] != key:
            raise InputError("it is the entry of another stage or study")
        product = kind.load(opened["product"])
        seconds = float(opened.attrs["seconds"])
        return Entry(product, seconds, float(opened.attrs.get("cpu", seconds)))


def key_of(
    stage: str, package: str, inputs: Mapping[str, Any], upstream: tuple[str, ...] = ()
) -> str:
    """Hash of a stage's own inputs, its upstream keys and the code that computes it."""
    record = {
        "stage": stage,
        "inputs": inputs,
        "upstream": list(upstream),
        "code": code_of(package, "stages", "input"),
    }
    text = json.dumps(_canonical(record), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def _canonical(value: Any) -> Any:
    """Numbers to 12 digits, so that "20 um" and 20e-6, a bit apart, are the same."""
    if isinstance(value, float):
        return float(f"{value:.12g}")
    if isinstance(value, str | int) or value is None:
        return value
    if isinstance(value, Mapping):
        return {str(key): _canonical(item) for key, item in value.items()}
    return [_canonical(item) for item in value] if isinstance(value, list | tuple) else value


@lru_cache
def code_of(*rooms: str) -> str:
    """The program's release and a digest of the source files of some of its folders.

    A digest, because a working copy changes between versions. The mesh generator's version
    counts too, since node numbers depend on it.
    """
    digest = hashlib.sha256()
    for room in rooms:
        for folder in import_module(f"vanelock.{room}").__path__:
            for path in sorted(p for p in Path(folder).rglob("*") if p.suffix in CODE):
                digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    if "mesh" in rooms:
        digest.update(f"{installed('gmsh')} {installed('meshio')}".encode())
    return f"{release(__version__)}+{digest.hexdigest()[:12]}"


def _flat(stage: str) -> str:
    return "".join(c if c.isalnum() else "-" for c in stage)
