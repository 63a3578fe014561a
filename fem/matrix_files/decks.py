"""Matrices in decks: superelements and .mtx of Abaqus and CalculiX, DMIG entries of Nastran.

A superelement (`*SUBSTRUCTURE MATRIX OUTPUT`) is a user element:

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

DMIG entries are by grid point and component, in a deck or a punch file,

    DMIG  NAME  0   IFO  TIN  TOUT  POLAR        a head
    DMIG  NAME  GJ  CJ        G1  C1  A1  B1     a column: its row's grid, component, entry
          G2    C2  A2  B2 ...

in fields of 8 columns, of 16 (DMIG*), or between commas. IFO 6 is symmetric: one triangle; TIN 1
and 2 are real, 3 and 4 complex; with POLAR, B is the phase in degrees (MSC Nastran Quick Reference
Guide, DMIG). Component 0 is a scalar point, which holds a generalised coordinate.
"""

import re
from codecs import BOM_UTF8
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import (
    FULL,
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
from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.fem.matrix_files.sparse_text import read_market
from vanelock.mesh.files.abaqus import Line, keywords
from vanelock.mesh.files.nastran import cards, lines_of
from vanelock.mesh.files.raw import integer, real


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


def _labels(
    source: str, nodes: list[int], freedoms: dict[int, list[int]]
) -> tuple[Integers, Integers]:
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


@dataclass
class _Matrix:
    """A head and the entries below it."""

    form: int
    kind: int
    polar: bool
    rows: list[tuple[int, int]] = field(default_factory=list)
    columns: list[tuple[int, int]] = field(default_factory=list)
    values: list[complex] = field(default_factory=list)


def read_dmig(path: Path, request: WantedMatrix) -> Entries:
    """Read the DMIG matrix that is wanted."""
    source = str(path)
    found: dict[str, list[tuple[str, list[str]]]] = {}
    for number, keyword, fields in cards(lines_of(text(path))):
        if keyword == "DMIG":
            name = fields[0].upper()
            where = f"{source}: line {number}: DMIG"
            if not re.fullmatch(r"[A-Z]\w{0,7}", name):
                raise InputError(f"{where}: {fields[0][:16]!a} is not a matrix's name")
            found.setdefault(name, []).append((f"{where} {name}", fields))
    name = chosen(source, list(found), request)
    matrix = _matrix(name, found[name])
    labels = sorted(set(matrix.rows) | set(matrix.columns))
    if not labels:
        raise InputError(f"{source}: DMIG {name} has no entries")
    place = {label: k for k, label in enumerate(labels)}
    values = np.array(matrix.values)
    node, component = np.array(labels, np.int64).T
    return Entries(
        f"{source}: {name}",
        len(labels),
        np.array([place[label] for label in matrix.rows], np.int64),
        np.array([place[label] for label in matrix.columns], np.int64),
        values if matrix.kind > 2 else values.real,
        SYMMETRIC if matrix.form == 6 else FULL,
        node,
        np.where(component == 0, GENERALISED, component - 1),
        leaves_out=True,
    )


def _matrix(name: str, lines: list[tuple[str, list[str]]]) -> _Matrix:
    matrix: _Matrix | None = None
    for where, fields in lines:
        if fields[1] != "0":
            if matrix is None:
                raise InputError(f"{where}: a column before the head (DMIG {name} 0 ...)")
            _column(where, fields, matrix)
        elif matrix is not None:
            raise InputError(f"{where}: a second head of that name")
        else:
            matrix = _head(where, fields)
    assert matrix is not None
    return matrix


def _head(where: str, fields: list[str]) -> _Matrix:
    form, kind = integer(fields[2], where), integer(fields[3], where)
    polar = integer("".join(fields[5:6]) or "0", where)  # beyond the only line of large fields
    if form not in (1, 6):
        raise InputError(f"{where}: form {form}: square (1) and symmetric (6) matrices are read")
    if kind not in (1, 2, 3, 4):
        raise InputError(f"{where}: type {kind}: 1 to 4 are real or complex")
    return _Matrix(form, kind, polar != 0)


def _column(where: str, fields: list[str], matrix: _Matrix) -> None:
    column = _label(where, fields[1], fields[2])
    entries = fields[4:]
    for k in range(0, len(entries), 4):
        grid, component, a, b = entries[k : k + 4]
        if not any((grid, component, a, b)):
            continue
        value = complex(real(a, where), real(b or "0", where))
        if matrix.kind < 3 and b:
            raise InputError(f"{where}: an imaginary part in a real matrix")
        if matrix.polar:
            value = value.real * np.exp(1j * np.deg2rad(value.imag))
        matrix.rows.append(_label(where, grid, component))
        matrix.columns.append(column)
        matrix.values.append(value)


def _label(where: str, grid: str, component: str) -> tuple[int, int]:
    found = integer(grid, where), integer(component or "0", where)
    if found[0] < 1 or not 0 <= found[1] <= 6:
        raise InputError(
            f"{where}: grid {found[0]}, component {found[1]}: grids are numbered from 1, "
            "components are 0 to 6"
        )
    return found
