"""Matrices that Abaqus and CalculiX write: superelements (`*SUBSTRUCTURE MATRIX OUTPUT`), .mtx.

    *USER ELEMENT, NODES= 3, LINEAR
    ** ELEMENT NODES
    ** 101, 102, 205
    1, 2, 3                       freedoms at the first node and at those after it
    3, 1, 2                       from the third on
    *MATRIX, TYPE=STIFFNESS       one triangle, row by row: K11, K21, K22, K31, ...

(Abaqus Keywords Reference, *USER ELEMENT and *MATRIX; CalculiX's substructure.f.)

An .mtx is a global matrix (`*MATRIX OUTPUT`), or a Matrix Market file. `FORMAT=MATRIX INPUT`, the
default, lists `row node, freedom, column node, freedom, entry`, one triangle or both of a symmetric
matrix (Abaqus Keywords Reference, *MATRIX INPUT, *MATRIX OUTPUT); `FORMAT=COORDINATE` lists `row
column entry` without labels or a line of sizes. A freedom with a boundary condition has 1e36 on the
stiffness's diagonal: it is fixed, and left out.
"""

import re
from codecs import BOM_UTF8
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import (
    SYMMETRIC,
    Entries,
    WantedMatrix,
    as_integers,
    chosen,
    content,
    number_table,
    refuse_unless_alone,
    text,
)
from vanelock.fem.matrix_files.sparse_text import read_market
from vanelock.mesh.files.abaqus import Line, keywords
from vanelock.mesh.files.numbers import integer, real


def _read_superelement(source: str, held: str, request: WantedMatrix) -> Entries:
    """Read the matrix that is wanted from a superelement's text."""
    freedoms: dict[int, list[int]] = {}
    matrices: dict[str, list[float]] = {}
    for number, keyword, options, lines in keywords(source, held):
        where = f"{source}: line {number}"
        if keyword == "USERELEMENT":
            if freedoms:
                raise InputError(f"{where}: a second element: one superelement is read")
            freedoms = _freedoms(source, lines)
        elif keyword == "MATRIX":
            kind = "".join(options.get("TYPE", "").split()).upper()
            if kind in matrices:
                raise InputError(f"{where}: a second matrix {kind}")
            matrices[kind] = [real(*word) for word in _words(source, lines)]
    names = {
        ("damping" if key == "VISCOUSDAMPING" else key.lower()): values
        for key, values in matrices.items()
    }
    values = names[chosen(source, list(names), request)]
    node, direction = _labels(source, _nodes(held), freedoms)
    n = len(node)
    if len(values) != n * (n + 1) // 2:
        raise InputError(
            f"{source}: {len(values):,} entries: one triangle of {n} freedoms has "
            f"{n * (n + 1) // 2:,}"
        )
    rows, columns = np.tril_indices(n)
    return Entries(source, n, rows, columns, np.array(values), SYMMETRIC, node, direction)


def _words(source: str, lines: list[Line]) -> Iterator[tuple[str, str]]:
    """Words of lines that may end in a comma, and where each stands."""
    for number, words in lines:
        for word in words if words[-1] else words[:-1]:
            yield word, f"{source}: line {number}"


def _nodes(held: str) -> list[int]:
    """The element's nodes, which stand in comments."""
    nodes: list[int] = []
    comment = ""
    for line in held.splitlines():
        if line.lstrip().startswith("**"):
            text = line.strip("* \t").upper()
            if comment == "ELEMENT NODES" and re.fullmatch(r"[\d\s,-]+", text):
                nodes += [int(word) for word in re.findall(r"-?\d{1,12}", text)]
            else:
                comment = text
    return nodes


def _freedoms(source: str, lines: list[Line]) -> dict[int, list[int]]:
    """Those at the first node, in a line without its place, and after the places of others."""
    freedoms: dict[int, list[int]] = {}
    for line in lines:
        numbers = [integer(*word) for word in _words(source, [line])]
        place = numbers.pop(0) if freedoms else 1
        if place in freedoms or place < 1 or any(not 1 <= freedom <= 6 for freedom in numbers):
            raise InputError(
                f"{source}: line {line[0]}: freedoms 1 to 6 are read, once for a place among the "
                "nodes"
            )
        freedoms[place] = numbers
    return freedoms


def _labels(source: str, nodes: list[int], freedoms: dict[int, list[int]]) -> tuple[
    np.ndarray[tuple[int], np.dtype[np.int64]], np.ndarray[tuple[int], np.dtype[np.int64]]
]:  # fmt: skip
    """Node and direction of each row, from the first node on."""
    if not nodes or not freedoms:
        raise InputError(f"{source}: the superelement lists no nodes or no freedoms")
    if max(freedoms) > len(nodes):
        raise InputError(f"{source}: freedoms of place {max(freedoms)} among {len(nodes)} nodes")
    node, direction = [], []
    active: list[int] = []
    for place, number in enumerate(nodes, start=1):
        active = freedoms.get(place, active)
        node += [number] * len(active)
        direction += [freedom - 1 for freedom in active]
    return np.array(node, np.int64), np.array(direction, np.int64)


_FIXED = 1e36  # stiffness on the diagonal that stands for a boundary condition


def read_mtx(path: Path, request: WantedMatrix) -> Entries:
    """Read a .mtx file of whichever kind it is."""
    source = str(path)
    if content(path).removeprefix(BOM_UTF8).lstrip()[:1] == b"%":
        refuse_unless_alone(source, request)
        return read_market(path, request)
    held = text(path)
    if "*USER ELEMENT" in held[:100_000].upper():
        return _read_superelement(source, held, request)
    refuse_unless_alone(source, request)
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
    rows, columns = (as_integers(source, table[:, k], "row or column", 1) - 1 for k in (0, 1))
    if (table[:, 2] == _FIXED).any():
        raise InputError(
            f"{source}: boundary conditions (1e36) without labels: write FORMAT=MATRIX INPUT"
        )
    n = int(max(rows.max(), columns.max())) + 1
    return Entries(source, n, rows, columns, table[:, 2], SYMMETRIC)


def _labelled(source: str, table: Floats) -> Entries:
    """Entries by node and freedom; the rows are in the labels' order."""
    nodes = np.concatenate([as_integers(source, table[:, k], "node") for k in (0, 2)])
    freedoms = np.concatenate([as_integers(source, table[:, k], "freedom") for k in (1, 3)])
    if (nodes < 1).any():
        raise InputError(f"{source}: node {int(nodes.min())}: Abaqus's internal nodes are not read")
    if ((freedoms < 1) | (freedoms > 6)).any():
        wrong = int(freedoms[(freedoms < 1) | (freedoms > 6)][0])
        raise InputError(f"{source}: freedom {wrong}: 1 to 6 are displacements and rotations")
    keys, place = np.unique(nodes * 8 + freedoms, return_inverse=True)
    rows, columns = np.split(place, 2)
    values = table[:, 4]
    fixed = np.zeros(len(keys), bool)
    fixed[rows[(rows == columns) & (values == _FIXED)]] = True
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
