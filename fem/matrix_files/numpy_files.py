"""NumPy's files: .npy, .npz with full arrays, .npz of `scipy.sparse.save_npz`.

Nothing is ever unpickled. The size that an array's header claims is compared with the bytes that
follow before memory is taken (the formats: numpy.lib.format, scipy.sparse.save_npz).
"""

import io
import math
import tokenize
import zipfile
import zlib
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import (
    Entries,
    WantedMatrix,
    chosen,
    content,
    dense_entries,
    numbers,
    refuse_unless_alone,
    room,
    size_of,
    square,
)

_FAULTS = (
    ValueError, TypeError, KeyError, OSError, EOFError, RuntimeError, NotImplementedError,
    SyntaxError, MemoryError, RecursionError, OverflowError, zlib.error,
    tokenize.TokenError, zipfile.BadZipFile,
)  # fmt: skip
_PARTS: tuple[str, ...] = (
    "format", "shape", "data", "row", "col", "indices", "indptr", "offsets"
)  # fmt: skip
_MEMBERS = {
    "csr": ("data", "indices", "indptr"),
    "csc": ("data", "indices", "indptr"),
    "bsr": ("data", "indices", "indptr"),
    "coo": ("data", "row", "col"),
    "dia": ("data", "offsets"),
}


def read_npy(path: Path, request: WantedMatrix) -> Entries:
    """Read a .npy file: one full array."""
    refuse_unless_alone(str(path), request)
    return dense_entries(str(path), _array(str(path), content(path)))


def read_npz(path: Path, request: WantedMatrix) -> Entries:
    """Read an array of a .npz file, or the sparse matrix that it is."""
    source, size = str(path), size_of(path)
    try:
        with zipfile.ZipFile(path) as archive:
            members = {
                each.filename.removesuffix(".npy"): each
                for each in archive.infolist()
                if each.filename.endswith(".npy")
            }
            claimed = sum(each.file_size for each in members.values())
            if claimed > room(size):
                raise InputError(f"{source}: {size:,} bytes claim to unpack to {claimed:,}")
            if {"format", "shape", "data"} <= set(members):
                refuse_unless_alone(source, request)
                found = {
                    name: _array(f"{source}: {name}", archive.read(members[name]))
                    for name in _PARTS
                    if name in members
                }
                return _sparse(source, found)
            name = chosen(source, sorted(members), request)
            return dense_entries(
                f"{source}: {name}", _array(f"{source}: {name}", archive.read(members[name]))
            )
    except InputError:
        raise
    except _FAULTS:
        raise InputError(f"{source}: not a whole .npz file") from None


def arrays(path: Path) -> dict[str, Array]:
    """All arrays of a .npz file of one's own."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def _array(source: str, held: bytes) -> Array:
    """An array from the bytes of a .npy file."""
    file = io.BytesIO(held)
    try:
        version = np.lib.format.read_magic(file)
        read = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }.get((version[0], version[1]))
        if read is None:
            raise ValueError
        shape, _, dtype = read(file)
    except _FAULTS:
        raise InputError(f"{source}: not NumPy's format") from None
    if dtype.hasobject:
        raise InputError(f"{source}: holds Python objects, which are not read")
    claimed, left = math.prod(shape) * dtype.itemsize, len(held) - file.tell()
    if claimed != left or any(n < 0 for n in shape):
        given = " x ".join(map(str, shape))
        raise InputError(f"{source}: {given} entries take {claimed:,} bytes; {left:,} follow")
    try:
        found: Array = np.load(io.BytesIO(held), allow_pickle=False)
    except _FAULTS:
        raise InputError(f"{source}: not NumPy's format") from None
    return found


def _sparse(source: str, members: dict[str, Array]) -> Entries:
    """The matrix of `scipy.sparse.save_npz`."""
    kind = members["format"].item() if members["format"].shape == () else b""
    kind = kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)
    if kind not in _MEMBERS:
        raise InputError(f"{source}: sparse format {kind[:20]!a} is not read")
    if absent := [name for name in _MEMBERS[kind] if name not in members]:
        raise InputError(f"{source}: {absent[0]} of the sparse matrix is missing")
    shape = members["shape"]
    if shape.shape != (2,) or shape.dtype.kind not in "iu":
        raise InputError(f"{source}: shape of the sparse matrix is not two whole numbers")
    square(source, tuple(int(n) for n in shape))
    n = int(shape[0])
    numbers(source, members["data"].dtype)
    first, *places = (members[name] for name in _MEMBERS[kind])
    if any(each.dtype.kind not in "iu" or each.ndim != 1 for each in places):
        raise InputError(f"{source}: indices of the sparse matrix are not whole numbers")
    try:
        if kind == "coo":
            row, column = (each.astype(np.int64) for each in places)
            if not len(first) == len(row) == len(column):
                raise ValueError
            return Entries(source, n, row, column, first)
        if kind == "dia":
            matrix = sp.dia_array((first, *places), shape=(n, n))
        else:
            if kind != "bsr" and len(places[1]) != n + 1:
                raise ValueError
            make = {"csr": sp.csr_array, "csc": sp.csc_array, "bsr": sp.bsr_array}[kind]
            matrix = make((first, *places), shape=(n, n))
            matrix.check_format(full_check=True)
        coo = matrix.tocoo()
    except _FAULTS:
        raise InputError(f"{source}: parts of the sparse matrix do not fit together") from None
    return Entries(source, n, coo.row, coo.col, coo.data)
