"""Nastran's DMIG entries: matrices by grid point and component, in a deck or a punch file.

    DMIG  NAME  0   IFO  TIN  TOUT  POLAR        a head
    DMIG  NAME  GJ  CJ        G1  C1  A1  B1     a column: its row's grid, component, entry
          G2    C2  A2  B2 ...

in fields of 8 columns, of 16 (DMIG*), or between commas. IFO 6 is symmetric: one triangle; TIN 1
and 2 are real, 3 and 4 complex; with POLAR, B is the phase in degrees (MSC Nastran Quick Reference
Guide, DMIG). Component 0 is a scalar point, which holds a generalised coordinate.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.choosing import WantedMatrix, chosen
from vanelock.fem.matrix_files.contents import text
from vanelock.fem.matrix_files.entries import FULL, SYMMETRIC, Entries
from vanelock.fem.matrix_files.model import GENERALISED

_REAL = re.compile(r"([+-]?(?:\d+(?:\.\d*)?|\.\d+))(?:[EeDd]?([+-]\d{1,3})|[EeDd](\d{1,3}))?")


@dataclass
class _Matrix:
    """A head and the entries below it."""

    form: int
    kind: int
    polar: bool
    rows: list[tuple[int, int]] = field(default_factory=list)
    columns: list[tuple[int, int]] = field(default_factory=list)
    values: list[complex] = field(default_factory=list)


def read_dmig(path: Path, wanted: WantedMatrix) -> Entries:
    """Read the DMIG matrix that is wanted.

    Raises
    ------
    InputError
        One line with the file's name and the line's number.
    """
    source = str(path)
    matrices: dict[str, _Matrix] = {}
    for number, fields in _cards(text(path)):
        where = f"{source}: line {number}: DMIG"
        name = fields[0].upper()
        if not re.fullmatch(r"[A-Z]\w{0,7}", name):
            raise InputError(f"{where}: {fields[0][:16]!a} is not a matrix's name")
        if fields[1] == "0":
            if name in matrices:
                raise InputError(f"{where} {name}: a second head of that name")
            matrices[name] = _head(f"{where} {name}", fields)
        elif name not in matrices:
            raise InputError(f"{where} {name}: a column before the head (DMIG {name} 0 ...)")
        else:
            _column(f"{where} {name}", fields, matrices[name])
    name = chosen(source, list(matrices), wanted)
    matrix = matrices[name]
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


def _head(where: str, fields: list[str]) -> _Matrix:
    form, kind, polar = (_integer(where, fields[k], "0" if k == 5 else "") for k in (2, 3, 5))
    if form not in (1, 6):
        raise InputError(f"{where}: form {form}: square (1) and symmetric (6) matrices are read")
    if kind not in (1, 2, 3, 4):
        raise InputError(f"{where}: type {kind}: 1 to 4 are real or complex")
    return _Matrix(form, kind, polar != 0)


def _column(where: str, fields: list[str], matrix: _Matrix) -> None:
    column = _label(where, fields[1], fields[2])
    entries = fields[4:]
    for k in range(0, len(entries), 4):
        grid, component, real, imaginary = (*entries[k : k + 4], "", "", "", "")[:4]
        if not any((grid, component, real, imaginary)):
            continue
        value = complex(_real(where, real), _real(where, imaginary) if imaginary else 0.0)
        if matrix.kind < 3 and imaginary:
            raise InputError(f"{where}: an imaginary part in a real matrix")
        if matrix.polar:
            value = value.real * np.exp(1j * np.deg2rad(value.imag))
        matrix.rows.append(_label(where, grid, component))
        matrix.columns.append(column)
        matrix.values.append(value)


def _label(where: str, grid: str, component: str) -> tuple[int, int]:
    found = _integer(where, grid), _integer(where, component, "0")
    if found[0] < 1 or not 0 <= found[1] <= 6:
        raise InputError(
            f"{where}: grid {found[0]}, component {found[1]}: grids are numbered from 1, "
            "components are 0 to 6"
        )
    return found


def _integer(where: str, word: str, absent: str = "") -> int:
    word = word or absent
    if not re.fullmatch(r"[+-]?\d{1,15}", word):
        raise InputError(f"{where}: {word[:16]!a} is not a whole number")
    return int(word)


def _real(where: str, word: str) -> float:
    found = _REAL.fullmatch(word)
    if found is None:
        raise InputError(f"{where}: {word[:24]!a} is not a number")
    return float(f"{found[1]}e{found[2] or found[3] or 0}")


def _cards(held: str) -> Iterator[tuple[int, list[str]]]:
    """The fields after the keyword of each DMIG, those of its continuations after them."""
    current: tuple[int, list[str]] | None = None
    for number, line in enumerate(held.splitlines(), start=1):
        line = line.partition("$")[0].rstrip()
        if not line:
            continue
        keyword, fields = _fields(line)
        if keyword.upper().rstrip("*") == "DMIG":
            if current is not None:
                yield current
            current = number, fields
        elif current is not None and (not keyword or keyword[0] in "+*"):
            current[1].extend(fields)
        else:
            if current is not None:
                yield current
            current = None
    if current is not None:
        yield current


def _fields(line: str) -> tuple[str, list[str]]:
    """Keyword and 8 fields (4 where they are wide) of a line, empty ones too."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        wide = words[0].endswith("*") or words[0].startswith("*")
        count = 4 if wide else 8
        return words[0], (words[1:] + [""] * count)[:count]
    line = line.expandtabs(8)
    keyword = line[:8].strip()
    wide = keyword.endswith("*") or keyword.startswith("*")
    width, count = (16, 4) if wide else (8, 8)
    return keyword, [line[8 + width * k : 8 + width * (k + 1)].strip() for k in range(count)]
