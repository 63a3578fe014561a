"""Mutations of HDF5 files by what is in them: types, shapes, links, packed and foreign data."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tests.verification.hostile.mutations import bits, cut, flips
from tests.verification.hostile.words import VALUES, WORDS
from vanelock.common.files.files import BLOCK, stamp

Random = np.random.Generator
Edit = Callable[[Random, h5py.File, str], None]


def _one(random: Random, choice: list[Any]) -> Any:
    return choice[int(random.integers(len(choice)))]


def _text(random: Random) -> str:
    return _one(random, WORDS).decode("utf-8", "replace").replace("\0", "0") or "x"


def _data(random: Random) -> Any:
    return _one(random, [
        np.nan, np.zeros(0), np.full((3, 3), np.nan), np.arange(5), np.full(7, np.inf), "text",
        np.array([b"a", b"bb"]), np.zeros((1, 1, 1, 1, 1)), 1e308, -(2**62), np.array(1 + 1j), True,
        np.zeros(3, [("a", "f4"), ("b", "i8")]), np.array([2**63], "u8"), h5py.Empty("f8"),
        "x" * 9000, np.zeros((4, 0, 3)), np.zeros(200, "f2"), np.void(b"abc"),
        np.full((2, 3, 5), -1, "i1"), np.array(["a", 1], h5py.string_dtype()),
    ])  # fmt: skip


def removed(random: Random, file: h5py.File, name: str) -> None:
    """Something is missing."""
    del file[name]


def other(random: Random, file: h5py.File, name: str) -> None:
    """Data of another type or shape."""
    del file[name]
    file[name] = _data(random)


def bent(random: Random, file: h5py.File, name: str) -> None:
    """The same type and shape, other numbers."""
    item = file[name]
    if isinstance(item, h5py.Dataset) and item.dtype.kind in "iufc" and 0 < item.size < 10**7:
        values = item[()]
        flat = np.atleast_1d(values).ravel()
        at = random.integers(flat.size, size=min(5, flat.size))
        with np.errstate(all="ignore"):
            wild = [np.nan, np.inf, -1, 0, 1e300, 2**31, -(2**40)]
            flat[at] = np.array(wild)[random.integers(len(wild), size=len(at))].astype(item.dtype)
        item[...] = flat.reshape(np.shape(values)) if np.ndim(values) else flat[0]
    else:
        removed(random, file, name)


def reshaped(random: Random, file: h5py.File, name: str) -> None:
    """The same numbers in another shape."""
    item = file[name]
    if not isinstance(item, h5py.Dataset) or not 0 < item.size < 10**7 or not item.shape:
        return other(random, file, name)
    values = item[()]
    del file[name]
    ways = [values.ravel(), values[None], values[:-1], np.concatenate([values, values]), values.T]
    file.create_dataset(name, data=_one(random, ways))
    return None


def huge(random: Random, file: h5py.File, name: str) -> None:
    """Far more than the file holds: packed, never written or sparse."""
    del file[name]
    size = int(10 ** random.uniform(8, 16))
    packed = {"chunks": (1 << 16,), "compression": "gzip"}
    shape, how = _one(
        random, [((size,), packed), ((size,), {}), ((1 << 20,) * 3, {"chunks": True})]
    )
    file.create_dataset(name, shape, "f8", **how)


def elsewhere(random: Random, file: h5py.File, name: str) -> None:
    """Data in other files, or in none."""
    del file[name]
    files = ["/etc/passwd", "results/../x-0123456789abcdef0123.h5", "results/x.h5", file.filename]
    inside = ["/nowhere", "/", name, "/provenance"]
    links = [h5py.ExternalLink(_one(random, files), "/"), h5py.SoftLink(_one(random, inside))]
    if random.random() < 0.7:
        file[name] = _one(random, links)
    else:
        file.create_dataset(name, (4,), "i1", external=[("/etc/passwd", 0, 4)])


def looped(random: Random, file: h5py.File, name: str) -> None:
    """A group that contains itself, or very many."""
    above = below = file[name].parent
    kind = int(random.integers(3))
    if kind == 0:
        above["again"] = _one(random, [above, h5py.SoftLink(above.name)])
    for i in range((0, 60, 3000)[kind]):
        below = below.create_group("a") if kind == 1 else above.create_group(f"g{i}").parent


def attribute(random: Random, file: h5py.File, name: str) -> None:
    """Attributes of other types, missing or strange ones."""
    item = _one(random, [file, file.get("provenance", file), file[name], file[name]])
    own = list(item.attrs)
    key = _one(random, own) if own and random.random() < 0.8 else _text(random)[:60]
    if own and key in own and random.random() < 0.25:
        del item.attrs[key]
    else:
        value = _one(random, VALUES).decode("utf-8").replace("\0", "")
        item.attrs[key] = _one(random, [_text(random)[:60000], value, _data(random)])


def exchanged(random: Random, file: h5py.File, name: str) -> None:
    """One object stands in another's place."""
    again = _one(random, _names(file))
    if not name.startswith(again) and not again.startswith(name):
        kept = file[again]
        del file[name]
        file[name] = kept


EDITS: list[Edit] = [
    removed, other, bent, bent, reshaped, huge, elsewhere, looped, attribute, attribute, attribute,
    exchanged,
]  # fmt: skip


def _names(file: h5py.File) -> list[str]:
    found: list[str] = []
    file.visit(found.append)
    return found


def mutated_hdf5(random: Random, path: Path) -> None:
    """Mutate a file where it is."""
    if random.random() < 0.5:
        data = path.read_bytes()
        for _ in range(int(random.integers(1, 4))):
            if random.random() < 0.2:
                data = cut(random, data) or b"\n"
            elif random.random() < 0.5:
                data = flips(random, data)
            else:
                data = bits(random, data)
        path.write_bytes(data)
        return
    with h5py.File(path, "a") as file:
        for _ in range(int(random.integers(1, 3))):
            names = _names(file)
            # Few names near the top decide much, and thousands of data sets little.
            short = [name for name in names if name.count("/") < 2] or names
            choice = short if random.random() < 0.5 else names
            try:
                _one(random, EDITS)(random, file, _one(random, choice))
            except (KeyError, ValueError, RuntimeError, OSError, TypeError, OverflowError):
                continue  # what the library itself does not write
        results = file.userblock_size == BLOCK
    if results and random.random() < 0.7:
        stamp(path)  # what is wrong is no damage
