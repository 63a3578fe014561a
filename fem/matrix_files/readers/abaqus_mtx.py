"""Abaqus's .mtx files of a global matrix (`*MATRIX OUTPUT`), and Matrix Market's of that name.

`FORMAT=MATRIX INPUT`, the default, lists `row node, freedom, column node, freedom, entry`, one
triangle or both of a symmetric matrix (Abaqus Keywords Reference, *MATRIX INPUT, *MATRIX OUTPUT);
`FORMAT=COORDINATE` lists `row column entry` without labels or a line of sizes. A freedom with a
boundary condition has 1e36 on the stiffness's diagonal: it is fixed, and left out.
"""

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.choosing import WantedMatrix, refuse_unless_alone
from vanelock.fem.matrix_files.contents import content, text
from vanelock.fem.matrix_files.entries import SYMMETRIC, Entries, Integers
from vanelock.fem.matrix_files.readers.market import read_market
from vanelock.fem.matrix_files.readers.superelement import read_superelement

FIXED = 1e36
"""Stiffness on the diagonal that stands for a boundary condition."""


def read_mtx(path: Path, wanted: WantedMatrix) -> Entries:
    """Read a .mtx file of whichever kind it is.

    Raises
    ------
    InputError
        One line with the file's name.
    """
    source = str(path)
    if content(path).lstrip()[:1] == b"%":
        refuse_unless_alone(source, wanted)
        return read_market(path, wanted)
    held = text(path)
    if "*USER ELEMENT" in held[:100_000].upper():
        return read_superelement(source, held, wanted)
    refuse_unless_alone(source, wanted)
    return _global(source, held)


def _global(source: str, held: str) -> Entries:
    """A list of entries, with labels or without."""
    first = next(
        (line for line in held.splitlines() if line.strip() and line.lstrip()[0] != "*"), ""
    )
    commas = "," in first
    count = len(first.replace(",", " ").split())
    if count not in (3, 5):
        raise InputError(
            f"{source}: neither Matrix Market nor Abaqus: a line has {count} numbers, not "
            "5 (node, freedom, node, freedom, entry) or 3 (row, column, entry)"
        )
    try:
        table = np.loadtxt(
            io.StringIO(held), delimiter="," if commas else None, comments="*", ndmin=2
        )
    except (ValueError, OverflowError) as error:
        raise InputError(f"{source}: {_reason(error)}") from None
    if table.shape[1] != count:
        raise InputError(f"{source}: lines of {count} numbers are needed")
    if count == 5:
        return _labelled(source, table)
    rows, columns = (_whole(source, table[:, k]) - 1 for k in (0, 1))
    if (table[:, 2] == FIXED).any():
        raise InputError(
            f"{source}: boundary conditions (1e36) without labels: write FORMAT=MATRIX INPUT"
        )
    n = int(max(rows.max(), columns.max())) + 1
    return Entries(source, n, rows, columns, table[:, 2], SYMMETRIC)


def _labelled(source: str, table: NDArray[np.float64]) -> Entries:
    """Entries by node and freedom; the rows are in the labels' order."""
    nodes = np.concatenate([_whole(source, table[:, k]) for k in (0, 2)])
    freedoms = np.concatenate([_whole(source, table[:, k]) for k in (1, 3)])
    if (nodes < 1).any():
        raise InputError(f"{source}: node {int(nodes.min())}: Abaqus's internal nodes are not read")
    if ((freedoms < 1) | (freedoms > 6)).any():
        wrong = int(freedoms[(freedoms < 1) | (freedoms > 6)][0])
        raise InputError(f"{source}: freedom {wrong}: 1 to 6 are displacements and rotations")
    keys, place = np.unique(nodes * 8 + freedoms, return_inverse=True)
    rows, columns = np.split(place, 2)
    values = table[:, 4]
    fixed = np.zeros(len(keys), bool)
    fixed[rows[(rows == columns) & (values == FIXED)]] = True
    kept = ~(fixed[rows] | fixed[columns])
    number = np.cumsum(~fixed) - 1
    if not kept.any():
        raise InputError(f"{source}: every freedom is fixed")
    left = keys[~fixed]
    return Entries(
        source,
        len(left),
        number[rows[kept]],
        number[columns[kept]],
        values[kept],
        SYMMETRIC,
        left // 8,
        left % 8 - 1,
        leaves_out=True,
        fixed=frozenset(
            zip((keys[fixed] // 8).tolist(), (keys[fixed] % 8 - 1).tolist(), strict=True)
        ),
    )


def _whole(source: str, values: NDArray[np.float64]) -> Integers:
    with np.errstate(invalid="ignore"):
        wrong = ~((np.abs(values) < 1e15) & (values == np.round(values)))
    if wrong.any():
        raise InputError(f"{source}: {values[wrong][0]:g} is not a node, freedom, row or column")
    return values.astype(np.int64)


def _reason(error: Exception) -> str:
    """One line of the library's message."""
    return (str(error).strip().splitlines() or ["not a table of numbers"])[0][:150]
