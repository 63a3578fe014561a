"""Nastran's DMIG entries: matrices by grid point and component, in a deck or a punch file.

    DMIG  NAME  0   IFO  TIN  TOUT  POLAR        a head
    DMIG  NAME  GJ  CJ        G1  C1  A1  B1     a column: its row's grid, component, entry
          G2    C2  A2  B2 ...

in fields of 8 columns, of 16 (DMIG*), or between commas. IFO 6 is symmetric: one triangle; TIN 1
and 2 are real, 3 and 4 complex; with POLAR, B is the phase in degrees (MSC Nastran Quick Reference
Guide, DMIG). Component 0 is a scalar point, which holds a generalised coordinate.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import FULL, SYMMETRIC, Entries, WantedMatrix, chosen, text
from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.mesh.files.nastran import cards, lines_of
from vanelock.mesh.files.numbers import integer, real


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
