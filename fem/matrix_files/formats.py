"""Which reader a file is for, by its ending and its first bytes."""

import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.choosing import WantedMatrix
from vanelock.fem.matrix_files.entries import Entries

Reader = Callable[[Path, WantedMatrix], Entries]

READERS = {
    ".mtx": ("abaqus_mtx", "read_mtx"),
    ".mm": ("market", "read_market"),
    ".mmf": ("market", "read_market"),
    ".hb": ("harwell", "read_harwell"),
    ".rb": ("harwell", "read_harwell"),
    ".rsa": ("harwell", "read_harwell"),
    ".matrix": ("harwell", "read_harwell"),
    ".pch": ("dmig", "read_dmig"),
    ".dmig": ("dmig", "read_dmig"),
    ".bdf": ("dmig", "read_dmig"),
    ".dat": ("dmig", "read_dmig"),
    ".mat": ("matlab", "read_mat"),
    ".h5": ("hdf5", "read_hdf5"),
    ".hdf5": ("hdf5", "read_hdf5"),
    ".full": ("ansys_full", "read_full"),
    ".npy": ("numpy_files", "read_npy"),
    ".npz": ("numpy_files", "read_npz"),
}
"""Module and function by ending, without .gz."""
SEVERAL = {
    ".npz", ".mat", ".h5", ".hdf5", ".full", ".pch", ".dmig", ".bdf", ".dat", ".mtx"
}  # fmt: skip
"""Endings of files that may hold several matrices."""


def ending(path: Path) -> str:
    """A file's ending, without .gz and without a path into an HDF5 file."""
    name = re.sub(r"(\.h5|\.hdf5|\.mat):.*", r"\1", str(path).lower()).removesuffix(".gz")
    name = name.rpartition("/")[2]
    return "." + name.rpartition(".")[2] if "." in name else ""


def holds_several(path: Path) -> bool:
    """Whether a file of this format may hold more matrices than one."""
    return ending(path) in SEVERAL


def read_entries(path: Path, wanted: WantedMatrix) -> Entries:
    """Read the matrix that is wanted from a file."""
    found = READERS.get(ending(path))
    if found is None:
        known = " ".join(sorted(READERS))
        raise InputError(f"{path}: matrices are read from files that end in {known}")
    module, function = found
    reader: Reader = getattr(import_module(f"vanelock.fem.matrix_files.readers.{module}"), function)
    return reader(path, wanted)
