"""Mutations of HDF5 files by what is in them: types, shapes, links, packed and foreign data."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tests.verification.hostile.mutations import Random, cut, flips, one
from tests.verification.hostile.words import VALUES, WORDS
from vanelock.common.files.digests import BLOCK, stamp

WILD = [np.nan, np.inf, -1, 0, 1e300, 2**31, -(2**40)]


def _data(random: Random) -> Any:
    return one(random, [
        np.nan, np.zeros(0), np.full((3, 3), np.nan), np.arange(5), np.full(7, np.inf), "text",
        np.array([b"a", b"bb"]), np.zeros((1, 1, 1, 1, 1)), 1e308, -(2**62), np.array(1 + 1j), True,
        np.zeros(3, [("a", "f4"), ("b", "i8")]), np.array([2**63], "u8"), h5py.Empty("f8"),
        "x" * 9000, np.zeros((4, 0, 3)), np.zeros(200, "f2"), np.void(b"abc"),
        np.full((2, 3, 5), -1, "i1"), np.array(["a", 1], h5py.string_dtype()),
    ])  # fmt: skip


def bent(random: Random, item: Any) -> Any:
    """Data of the same type and shape, other numbers; or the same numbers in another shape."""
    if not isinstance(item, h5py.Dataset) or not 0 < item.size < 10**7 or not item.shape:
        return _data(random)
    values = item[()]
    if item.dtype.kind not in "iufc" or random.random() < 0.3:
        ways = [values.ravel(), values[None], values[:-1], np.concatenate([values] * 2), values.T]
        return one(random, ways)
    with np.errstate(all="ignore"):
        wild = np.array([one(random, WILD) for _ in range(5)]).astype(item.dtype)
    values.flat[random.integers(values.size, size=5)] = wild
    return values


def huge(random: Random, file: h5py.File, name: str) -> None:
    """Far more than the file holds: packed, never written or sparse."""
    size = (int(10 ** random.uniform(8, 16)),)
    packed = {"chunks": (1 << 16,), "compression": "gzip"}
    ways: Any = [(size, packed), (size, {}), ((1 << 20,) * 3, {"chunks": True})]
    shape, options = one(random, ways)
    file.create_dataset(name, shape, "f8", **options)


def elsewhere(random: Random, file: h5py.File, name: str) -> None:
    """Data in other files, or in none."""
    files = ["/etc/passwd", "results/../x-0123456789abcdef0123.h5", "results/x.h5", file.filename]
    if random.random() < 0.3:
        file.create_dataset(name, (4,), "i1", external=[("/etc/passwd", 0, 4)])
    elif random.random() < 0.5:
        file[name] = h5py.ExternalLink(one(random, files), "/")
    else:
        file[name] = h5py.SoftLink(one(random, ["/nowhere", "/", name, "/provenance"]))


def looped(random: Random, above: h5py.Group) -> None:
    """A group that contains itself, or very many."""
    kind, below = int(random.integers(3)), above
    if kind == 0:
        above["again"] = one(random, [above, h5py.SoftLink(above.name)])
    for i in range((0, 60, 3000)[kind]):
        below = below.create_group("a") if kind == 1 else above.create_group(f"g{i}").parent


def attribute(random: Random, item: Any) -> None:
    """An attribute of another type, missing or strange."""
    text = one(random, WORDS + VALUES).decode("utf-8", "replace").replace("\0", "")[:60000]
    names = [*item.attrs] * 4 + [text[:60] or "x"]
    name = one(random, names)
    if name in item.attrs and random.random() < 0.25:
        del item.attrs[name]
    else:
        item.attrs[name] = one(random, [text, _data(random)])


def edited(random: Random, file: h5py.File, names: list[str]) -> None:
    """One object missing, another, in another's place, or with another attribute."""
    # Few names near the top decide much, and thousands of data sets little.
    short = [name for name in names if name.count("/") < 2] or names
    name, other = (one(random, short if random.random() < 0.5 else names) for _ in range(2))
    kind, item, beside = int(random.integers(12)), file[name], file[other]
    new = bent(random, item)
    if kind < 4:
        attribute(random, one(random, [file, file.get("provenance", file), item, item]))
        return
    if kind == 4:
        looped(random, item.parent)
        return
    del file[name]
    if kind < 7:
        (huge if kind == 5 else elsewhere)(random, file, name)
    elif kind > 7:  # else it is missing
        file[name] = new if kind < 11 else beside


def mutated_hdf5(random: Random, path: Path) -> None:
    """Mutate a file where it is."""
    if random.random() < 0.5:
        data = path.read_bytes()
        for _ in range(int(random.integers(1, 4))):
            data = (cut if random.random() < 0.2 else flips)(random, data) or b"\n"
        path.write_bytes(data)
        return
    with h5py.File(path, "a") as file:
        for _ in range(int(random.integers(1, 3))):
            names: list[str] = []
            file.visit(names.append)
            try:
                edited(random, file, names)
            except (KeyError, ValueError, RuntimeError, OSError, TypeError, OverflowError):
                continue  # what the library itself does not write
        results = file.userblock_size == BLOCK
    if results and random.random() < 0.7:
        stamp(path)  # what is wrong is no damage
