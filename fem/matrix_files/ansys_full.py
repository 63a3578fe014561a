"""Ansys's .full: assembled stiffness and mass, one triangle, with the freedoms that are held.

Read by ansys-mapdl-reader (an optional library), in a child process first: its compiled part trusts
the numbers in the file. Rows of held freedoms are left out, as the solver leaves them out.
"""

from pathlib import Path
from typing import Any

import numpy as np

from vanelock.common.arrays import Integers
from vanelock.common.errors import InputError
from vanelock.common.files.files import by_library
from vanelock.common.lazy import library
from vanelock.fem.matrix_files.contents import (
    SYMMETRIC,
    Entries,
    NoMatrixError,
    WantedMatrix,
    size_of,
)


def read_full(path: Path, request: WantedMatrix) -> Entries:
    """Read stiffness or mass."""
    source, size = str(path), size_of(path)
    letter = {"stiffness": "K", "mass": "M"}.get(request.what)
    if letter is None or (request.name is not None and request.name.upper() != letter):
        raise NoMatrixError(f"{source}: holds the stiffness K and the mass M")
    library("ansys.mapdl.reader", "ansys", source, "ansys-mapdl-reader")
    label, held, equations, matrices = by_library(
        lambda: _contents(source), source, size, "a .full file"
    )
    if equations:
        raise InputError(f"{source}: constraint equations of the model are not read")
    if matrices[letter] is None:
        raise NoMatrixError(f"{source}: holds no {request.what} matrix")
    if (label[:, 1] > 5).any() or (label[:, 1] < 0).any() or (label[:, 0] < 1).any():
        raise InputError(f"{source}: displacements and rotations of nodes are read, nothing else")
    fixed = frozenset(map(tuple, held.tolist()))
    free = np.array([tuple(each) not in fixed for each in label.tolist()], bool)
    number = np.cumsum(free) - 1
    matrix = matrices[letter].tocoo()
    kept = free[matrix.row] & free[matrix.col]
    return Entries(
        source,
        int(free.sum()),
        number[matrix.row[kept]],
        number[matrix.col[kept]],
        matrix.data[kept],
        SYMMETRIC,
        label[free, 0],
        label[free, 1],
        fixed=fixed,
    )


def _contents(source: str) -> tuple[Integers, Integers, int, dict[str, Any]]:
    """Labels of the rows, those that are held, number of constraint equations, and K and M."""
    from ansys.mapdl.reader import read_binary

    full = read_binary(source)
    try:
        label, K, M = full.load_km(sort=False)
    except NotImplementedError as error:
        raise InputError(f"{source}: {str(error).splitlines()[0][:150]}") from None
    held = np.asarray(full.const, np.int64).reshape(-1, 2)
    return np.asarray(label, np.int64), held, full._header.get("ncefull", 0), {"K": K, "M": M}
