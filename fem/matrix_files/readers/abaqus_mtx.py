"""Abaqus's .mtx files of a global matrix (`*MATRIX OUTPUT`), and Matrix Market's of that name.

`FORMAT=MATRIX INPUT`, the default, lists `row node, freedom, column node, freedom, entry`, one
triangle or both of a symmetric matrix (Abaqus Keywords Reference, *MATRIX INPUT, *MATRIX OUTPUT);
`FORMAT=COORDINATE` lists `row column entry` without labels or a line of sizes. A freedom with a
boundary condition has 1e36 on the stiffness's diagonal: it is fixed, and left out.
"""

from codecs import BOM_UTF8
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import WantedMatrix, content, refuse_unless_alone, text
from vanelock.fem.matrix_files.entries import SYMMETRIC, Entries, number_table, whole
from vanelock.fem.matrix_files.readers.market import read_market
from vanelock.fem.matrix_files.readers.superelement import read_superelement

FIXED = 1e36
"""Stiffness on the diagonal that stands for a boundary condition."""


def read_mtx(path: Path, wanted: WantedMatrix) -> Entries:
    """Read a .mtx file of whichever kind it is."""
    source = str(path)
    if content(path).removeprefix(BOM_UTF8).lstrip()[:1] == b"%":
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
    table = number_table(source, held, delimiter="," if commas else None, comments="*")
    if table.shape[1] != count:
        raise InputError(f"{source}: lines of {count} numbers are needed")
    if count == 5:
        return _labelled(source, table)
    entries = len(table) - 1
    sizes = first.split()[-1] == str(entries) and table[:, :2].max() == table[0, :2].max()
    if entries and sizes:
        raise InputError(
            f'{source}: its first line looks like sizes, "{first.strip()[:60]}": the banner of a '
            "Matrix Market file (%%MatrixMarket matrix coordinate real ...) is missing before it"
        )
    rows, columns = (whole(source, table[:, k], "row or column", 1) - 1 for k in (0, 1))
    if (table[:, 2] == FIXED).any():
        raise InputError(
            f"{source}: boundary conditions (1e36) without labels: write FORMAT=MATRIX INPUT"
        )
    n = int(max(rows.max(), columns.max())) + 1
    return Entries(source, n, rows, columns, table[:, 2], SYMMETRIC)


def _labelled(source: str, table: Floats) -> Entries:
    """Entries by node and freedom; the rows are in the labels' order."""
    nodes = np.concatenate([whole(source, table[:, k], "node") for k in (0, 2)])
    freedoms = np.concatenate([whole(source, table[:, k], "freedom") for k in (1, 3)])
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
