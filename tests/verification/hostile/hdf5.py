"""Mutations of HDF5 files by what is in them: types, shapes, links, packed and foreign data."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tests.verification.hostile.mutations import bits, cut, flips
from tests.verification.hostile.words import VALUES, WORDS
from vanelock.common.files.digests import BLOCK, stamp

Random = np.random.Generator
Edit = Callable[[Random, h5py.File, str], None]


def _text(random: Random) -> str:
    found = WORDS[int(random.integers(len(WORDS)))].decode("utf-8", "replace").replace("\0", "0")
    return found or "x"


def _data(random: Random) -> Any:
    choice: list[Any] = [
        np.nan, np.zeros(0), np.full((3, 3), np.nan), np.arange(5), np.full(7, np.inf), "text",
        np.array([b"a", b"bb"]), np.zeros((1, 1, 1, 1, 1)), 1e308, -(2**62), np.array(1 + 1j), True,
        np.zeros(3, [("a", "f4"), ("b", "i8")]), np.array([2**63], "u8"), h5py.Empty("f8"),
        "x" * 9000, np.zeros((4, 0, 3)), np.zeros(200, "f2"), np.void(b"abc"),
        np.full((2, 3, 5), -1, "i1"),
    ]  # fmt: skip
    return choice[int(random.integers(len(choice)))]


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
    file.create_dataset(name, data=ways[int(random.integers(len(ways)))])
    return None


def huge(random: Random, file: h5py.File, name: str) -> None:
    """Far more than the file holds: packed, sparse or never written."""
    del file[name]
    size = int(10 ** random.uniform(8, 16))
    kind = int(random.integers(4))
    if kind == 0:
        file.create_dataset(name, (size,), "f8", chunks=(1 << 16,), compression="gzip")
    elif kind == 1:
        file.create_dataset(name, (size,), "f8")
    elif kind == 2:
        rows = file.create_dataset(name, (40_000_000,), "f8", chunks=(1 << 20,), compression="gzip")
        rows[: 1 << 20] = 1.0
    else:
        file.create_dataset(name, (1 << 20, 1 << 20, 1 << 20), "f8", chunks=(1, 1, 1 << 10))


def elsewhere(random: Random, file: h5py.File, name: str) -> None:
    """Data in other files, or in none."""
    del file[name]
    kind = int(random.integers(5))
    if kind == 0:
        foreign = ["/etc/passwd", "results/../x-0123456789abcdef0123.h5"]
        foreign += ["results/x-0123456789abcdef0123.h5", "results/x.h5"]
        file[name] = h5py.ExternalLink(foreign[int(random.integers(4))], "/")
    elif kind == 1:
        file[name] = h5py.ExternalLink(file.filename, "/")
    elif kind == 2:
        file[name] = h5py.SoftLink(["/nowhere", "/", name, "/provenance"][int(random.integers(4))])
    elif kind == 3:
        layout = h5py.VirtualLayout((3,), "f8")
        layout[:] = h5py.VirtualSource("/etc/passwd", "x", (3,))
        file.create_virtual_dataset(name, layout)
    else:
        file.create_dataset(name, (4,), "i1", external=[("/etc/passwd", 0, 4)])


def looped(random: Random, file: h5py.File, name: str) -> None:
    """A group that contains itself, or very many."""
    above = file[name].parent
    kind = int(random.integers(4))
    if kind == 0:
        above["again"] = above
    elif kind == 1:
        above["again"] = h5py.SoftLink(above.name)
    elif kind == 2:
        below = above
        for _ in range(60):
            below = below.create_group("a")
    else:
        for i in range(3000):
            above.create_group(f"g{i}")


def attribute(random: Random, file: h5py.File, name: str) -> None:
    """Attributes of other types, missing or strange ones."""
    item = file[name] if random.random() < 0.6 else file
    if "provenance" in file and random.random() < 0.3:
        item = file["provenance"]
    own = list(item.attrs)
    key = (
        own[int(random.integers(len(own)))] if own and random.random() < 0.8 else _text(random)[:60]
    )
    kind = int(random.integers(4))
    if kind == 0 and own and key in own:
        del item.attrs[key]
    elif kind == 1:
        item.attrs[key] = _text(random)[:60000]
    elif kind == 2:
        item.attrs[key] = (
            VALUES[int(random.integers(len(VALUES)))].decode("utf-8").replace("\0", "")
        )
    else:
        item.attrs[key] = _data(random)


def renamed(random: Random, file: h5py.File, name: str) -> None:
    """What is there, under another name."""
    word = _text(random).replace("/", "_")[:200]
    if word not in file[name].parent and word != ".":
        file.move(name, f"{file[name].parent.name}/{word}")


def exchanged(random: Random, file: h5py.File, name: str) -> None:
    """Two objects change places, or one stands in another's."""
    names = _names(file)
    again = names[int(random.integers(len(names)))]
    if name.startswith(again) or again.startswith(name):
        return
    kept = file[again]
    del file[name]
    file[name] = kept


def cooked(random: Random, file: h5py.File, name: str) -> None:
    """Types that are seldom seen."""
    del file[name]
    kinds: list[Any] = [
        h5py.ref_dtype, h5py.vlen_dtype("i4"), h5py.enum_dtype({"a": 1}),
        h5py.string_dtype("ascii", 5), h5py.opaque_dtype("M8[s]"),
        np.dtype([("r", "f8"), ("i", "f8")]), np.dtype(("f8", (3,))), "S9",
    ]  # fmt: skip
    file.create_dataset(name, (3,), kinds[int(random.integers(len(kinds)))])


EDITS: list[Edit] = [
    removed, other, bent, bent, reshaped, huge, elsewhere, looped, attribute, attribute, attribute,
    renamed, exchanged, cooked,
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
                EDITS[int(random.integers(len(EDITS)))](
                    random, file, choice[int(random.integers(len(choice)))]
                )
            except (KeyError, ValueError, RuntimeError, OSError, TypeError, OverflowError):
                continue  # what the library itself does not write
        results = file.userblock_size == BLOCK
    if results and random.random() < 0.7:
        stamp(path)  # what is wrong is no damage
