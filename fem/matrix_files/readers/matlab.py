"""MATLAB's files: .mat of version 5 by SciPy, of version 7.3, which is HDF5, by h5py.

Only arrays of numbers, full or sparse: cells, structures and objects are refused unread.
"""

import io
import math
import zlib
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse as sp

from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import WantedMatrix, chosen, content, room
from vanelock.fem.matrix_files.entries import Entries, dense_entries, square
from vanelock.fem.matrix_files.readers.hdf5 import read_hdf5

_NUMBERS = {"double", "single", "sparse"} | {
    f"{u}int{bits}" for u in ("", "u") for bits in (8, 16, 32, 64)
}
_FAULTS = (
    ValueError, TypeError, KeyError, IndexError, OSError, EOFError, MemoryError, OverflowError,
    RuntimeError, NotImplementedError, AttributeError, zlib.error,
    scipy.io.matlab.MatReadError,
)  # fmt: skip


def read_mat(path: Path, wanted: WantedMatrix) -> Entries:
    """Read a variable of a .mat file."""
    source, held = str(path), content(path)
    if held[:9] == b"MATLAB 7." or held[512:520] == b"\x89HDF\r\n\x1a\n":
        return read_hdf5(path, wanted)
    try:
        variables = {
            name: (shape, kind) for name, shape, kind in scipy.io.whosmat(io.BytesIO(held))
        }
    except _FAULTS:
        raise InputError(f"{source}: not a .mat file of version 4, 5 or 7.3") from None
    readable = [name for name, (_, kind) in variables.items() if kind in _NUMBERS]
    if wanted.name in variables and wanted.name not in readable:
        raise InputError(f"{source}: {wanted.name} is a {variables[wanted.name][1]}, not a matrix")
    name = chosen(source, readable, wanted)
    shape, kind = variables[name]
    square(f"{source}: {name}", shape)
    if kind != "sparse" and 8 * math.prod(shape) > room(len(held)):
        raise InputError(f"{source}: {name}: {shape[0]} rows cannot stand in {len(held):,} bytes")
    if shape[0] > room(len(held)) // 8:
        raise InputError(f"{source}: {name}: {shape[0]} rows cannot stand in {len(held):,} bytes")
    try:
        found = scipy.io.loadmat(io.BytesIO(held), variable_names=[name], spmatrix=False)[name]
        if sp.issparse(found):
            compressed = found.tocsc()
            compressed.check_format(full_check=True)
            coo = compressed.tocoo()
            return Entries(f"{source}: {name}", coo.shape[0], coo.row, coo.col, coo.data)
        return dense_entries(f"{source}: {name}", np.asarray(found))
    except _FAULTS:
        raise InputError(f"{source}: {name} cannot be read: not a whole .mat file") from None
