"""Matrices in binary files of arrays: NumPy's .npy and .npz, HDF5, MATLAB's .mat.

Nothing is ever unpickled. The size that an array's header claims is compared with the bytes that
follow before memory is taken (the formats: numpy.lib.format, scipy.sparse.save_npz).

"file.h5:/group/K" names the place in an HDF5 file. A sparse matrix is a group with MATLAB's data,
ir, jc (MathWorks, MAT-File Format, version 7.3; full arrays stand transposed there), or with data,
indices, indptr of compressed columns and the attribute shape, as vanelock's results have it. What
leads out of the file - external links and storage, virtual data sets - is not followed.

A .mat of version 5 is read by SciPy, of version 7.3, which is HDF5, by h5py; of version 5 only
arrays of numbers, full or sparse: cells, structures and objects are refused unread.
"""

import io
import math
import os
import tokenize
import zipfile
import zlib
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import scipy.io
import scipy.sparse as sp

from vanelock.common.arrays import Array
from vanelock.common.errors import InputError
from vanelock.common.files.hdf5 import opened
from vanelock.fem.matrix_files.contents import (
    Entries,
    NoMatrixError,
    WantedMatrix,
    chosen,
    content,
    numbers,
    refuse_unless_alone,
    room,
    size_of,
    square,
)

_FAULTS = (
    ValueError, TypeError, KeyError, OSError, EOFError, RuntimeError, NotImplementedError,
    SyntaxError, MemoryError, RecursionError, OverflowError, zlib.error, tokenize.TokenError,
    zipfile.BadZipFile, IndexError, AttributeError, scipy.io.matlab.MatReadError,
)  # fmt: skip
_WHOLE = ("shape", "row", "col", "indices", "indptr", "offsets")
"""Parts of a saved sparse matrix that hold whole numbers."""


@contextmanager
def _refused(fault: str) -> Generator[None, None, None]:
    """All that a damaged file may raise, as one line."""
    try:
        yield
    except InputError:
        raise
    except _FAULTS:
        raise InputError(fault) from None


def read_npy(path: Path, request: WantedMatrix) -> Entries:
    """Read a .npy file: one full array."""
    refuse_unless_alone(str(path), request)
    return _dense_entries(str(path), _array(str(path), content(path)))


def read_npz(path: Path, request: WantedMatrix) -> Entries:
    """Read an array of a .npz file, or the sparse matrix that it is."""
    source, size = str(path), size_of(path)
    with _refused(f"{source}: not a whole .npz file"), zipfile.ZipFile(path) as archive:
        members = {
            each.filename.removesuffix(".npy"): each
            for each in archive.infolist()
            if each.filename.endswith(".npy")
        }
        claimed = sum(each.file_size for each in members.values())
        if claimed > room(size):
            raise InputError(f"{source}: {size:,} bytes claim to unpack to {claimed:,}")

        def read(name: str) -> Array:
            return _array(f"{source}: {name}", archive.read(members[name]))

        if {"format", "shape", "data"} <= set(members):
            refuse_unless_alone(source, request)
            parts = ("format", "data", *_WHOLE)
            return _saved_sparse(source, path, {n: read(n) for n in parts if n in members})
        name = chosen(source, sorted(members), request)
        return _dense_entries(f"{source}: {name}", read(name))


def _array(source: str, held: bytes) -> Array:
    """An array from the bytes of a .npy file."""
    file, other = io.BytesIO(held), f"{source}: not NumPy's format"
    with _refused(other):
        read = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }[np.lib.format.read_magic(file)]
        shape, _, dtype = read(file)
    if dtype.hasobject:
        raise InputError(f"{source}: holds Python objects, which are not read")
    claimed, left = math.prod(shape) * dtype.itemsize, len(held) - file.tell()
    if claimed != left or any(n < 0 for n in shape):
        given = " x ".join(map(str, shape))
        raise InputError(f"{source}: {given} entries take {claimed:,} bytes; {left:,} follow")
    with _refused(other):
        return np.asarray(np.load(io.BytesIO(held), allow_pickle=False))


def _saved_sparse(source: str, path: Path, members: dict[str, Array]) -> Entries:
    """The matrix of `scipy.sparse.save_npz`."""
    numbers(source, members["data"].dtype)
    if any(members[name].dtype.kind not in "iu" for name in _WHOLE if name in members):
        raise InputError(f"{source}: indices of the sparse matrix are not whole numbers")
    with _refused(f"{source}: parts of the sparse matrix do not fit together"):
        matrix = sp.load_npz(path)
        if matrix.format in ("csr", "csc", "bsr"):
            matrix.check_format(full_check=True)
        coo = matrix.tocoo()
    square(source, coo.shape)
    return Entries(source, coo.shape[0], coo.row, coo.col, coo.data)


_INDICES = (("ir", "jc"), ("indices", "indptr"))


def read_hdf5(path: Path, request: WantedMatrix) -> Entries:
    """Read a matrix of an HDF5 file."""
    file, inside = split_path(path)
    size = size_of(file)
    with _refused(f"{file}: not a readable HDF5 file"), opened(file) as held:
        place = request.name or (inside if request.alone else None)
        if place is None:
            place = chosen(str(file), _tables(held), request)
        return _matrix(str(file), held, place, room(size))


def split_path(path: Path) -> tuple[Path, str | None]:
    """The file, and the place in it behind a colon."""
    name, colon, inside = str(path).rpartition(":")
    of_tables = name.lower().endswith((".h5", ".hdf5", ".mat"))
    if colon and inside and of_tables and not os.path.exists(path):
        return Path(name), inside
    return path, None


def _tables(file: h5py.File) -> list[str]:
    """What at the top of a file may be a matrix."""
    found = []
    for name in list(file)[:1000]:
        item = file.get(name)
        full = isinstance(item, h5py.Dataset) and len(item.shape or ()) == 2
        if full or (isinstance(item, h5py.Group) and "data" in item):
            found.append(name)
    return found


def _matrix(source: str, file: h5py.File, inside: str, most: int) -> Entries:
    where, item = f"{source}:{inside}", _item(source, file, inside)
    of_matlab = "MATLAB_class" in item.attrs
    if isinstance(item, h5py.Dataset):
        array = _values(where, item, most)
        return _dense_entries(where, array.T if of_matlab else array)
    for row, column in _INDICES:
        if all(name in item and isinstance(_item(source, item, name), h5py.Dataset)
               for name in ("data", row, column)):  # fmt: skip
            parts = [_values(f"{where}/{name}", item[name], most) for name in ("data", row, column)]
            return _sparse(where, item, parts)
    raise InputError(f"{where}: neither a data set nor a sparse matrix (data, indices, indptr)")


def _item(source: str, group: h5py.Group, inside: str) -> h5py.Group | h5py.Dataset:
    """What is at a place, without leaving the file."""
    item: Any = group
    for name in inside.strip("/").split("/"):
        if not isinstance(item, h5py.Group) or not name or name not in item:
            raise NoMatrixError(f"{source}: there is no {inside[:80]!a} in it")
        if isinstance(item.get(name, getlink=True), h5py.ExternalLink):
            raise InputError(f"{source}: {inside[:80]!a} is a link to another file")
        item = item[name]
    if not isinstance(item, h5py.Group | h5py.Dataset):
        raise InputError(f"{source}: {inside[:80]!a} is not a data set")
    return item


def _values(where: str, data: h5py.Dataset, most: int) -> Array:
    """An array of numbers; MATLAB's complex ones are pairs of real and imag."""
    if data.external or data.is_virtual:
        raise InputError(f"{where}: its numbers are in another file")
    if data.shape is None or data.nbytes > most:
        raise InputError(f"{where}: claims {data.nbytes:,} bytes, which cannot stand in the file")
    if data.dtype.names == ("real", "imag"):
        pairs = data[()]
        real: Array = pairs["real"] + 1j * pairs["imag"]
        return real
    numbers(where, data.dtype)
    found: Array = np.asarray(data[()])
    return found


def _sparse(where: str, group: h5py.Group, parts: list[Array]) -> Entries:
    """Compressed columns."""
    data, row, pointer = parts
    n = len(pointer) - 1
    rows = group.attrs.get("MATLAB_sparse", n)
    shape = tuple(int(k) for k in np.ravel(group.attrs.get("shape", [rows, n]))[:2])
    square(where, shape)
    if shape[0] != n or any(each.ndim != 1 or each.dtype.kind not in "iu" for each in parts[1:]):
        raise InputError(f"{where}: parts of the sparse matrix do not fit together")
    row, pointer = row.astype(np.int64), pointer.astype(np.int64)
    counts = np.diff(pointer)
    if pointer[0] != 0 or (counts < 0).any() or not len(row) == len(data) == pointer[-1]:
        raise InputError(f"{where}: parts of the sparse matrix do not fit together")
    return Entries(where, n, row, np.repeat(np.arange(n), counts), data)


_NUMBERS = {"double", "single", "sparse"} | {
    f"{u}int{bits}" for u in ("", "u") for bits in (8, 16, 32, 64)
}


def read_mat(path: Path, request: WantedMatrix) -> Entries:
    """Read a variable of a .mat file."""
    source, held = str(path), content(path)
    if held[:9] == b"MATLAB 7." or held[512:520] == b"\x89HDF\r\n\x1a\n":
        return read_hdf5(path, request)
    with _refused(f"{source}: not a .mat file of version 4, 5 or 7.3"):
        listed = scipy.io.whosmat(io.BytesIO(held))
        variables = {name: (shape, kind) for name, shape, kind in listed}
    readable = [name for name, (_, kind) in variables.items() if kind in _NUMBERS]
    if request.name in variables and request.name not in readable:
        raise InputError(
            f"{source}: {request.name} is a {variables[request.name][1]}, not a matrix"
        )
    name = chosen(source, readable, request)
    shape, kind = variables[name]
    square(f"{source}: {name}", shape)
    if 8 * (shape[0] if kind == "sparse" else math.prod(shape)) > room(len(held)):
        raise InputError(f"{source}: {name}: {shape[0]} rows cannot stand in {len(held):,} bytes")
    with _refused(f"{source}: {name} cannot be read: not a whole .mat file"):
        found = scipy.io.loadmat(io.BytesIO(held), variable_names=[name], spmatrix=False)[name]
        if sp.issparse(found):
            compressed = found.tocsc()
            compressed.check_format(full_check=True)
            coo = compressed.tocoo()
            return Entries(f"{source}: {name}", coo.shape[0], coo.row, coo.col, coo.data)
        return _dense_entries(f"{source}: {name}", np.asarray(found))


def _dense_entries(source: str, array: Array) -> Entries:
    """Entries of a full square array."""
    square(source, array.shape)
    numbers(source, array.dtype)
    rows, columns = np.nonzero(array)
    return Entries(source, len(array), rows, columns, array[rows, columns])
