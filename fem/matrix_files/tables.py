"""Text files of nodes and columns: who is in contact, and which row of a matrix is which.

The latter is said by a table, the order of the nodes or Ansys's mapping file. Ansys's `HBMAT` and
`*EXPORT` write matrices without labels; beside them, `HBMAT,,,,,,,YES` writes `Fname.mapping`, a
line for each row with its number, its node and the name of its freedom (Mechanical APDL Command
Reference, HBMAT).
"""

import csv
import re
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.files.files import PathLike
from vanelock.fem.matrix_files.contents import text
from vanelock.fem.matrix_files.model import GENERALISED

_Column = Integers | Floats | NDArray[np.str_]
_WHOLE = re.compile(r"[+-]?\d{1,18}")
_NUMBER = re.compile(r"[+-]?(\d+(?:\.\d*)?|\.\d+)([eEdD][+-]?\d+)?")


def load_nodes(path: PathLike) -> Integers:
    """Read a list of nodes' numbers, in the file's order.

    Spaces, commas, semicolons or new lines between numbers; a first line of words and what follows
    a # are left out.

    Parameters
    ----------
    path : path
        A text file, such as .txt or .csv.

    Returns
    -------
    (k,) int
        At least one, all different, all positive.

    Raises
    ------
    InputError
        One line with the file's name and the line's number.
    """
    path = Path(path)
    found: list[int] = []
    first = True
    for number, line in _lines(path):
        words = re.split(r"[\s,;]+", line.strip(" ,;\t"))
        if first and not any(re.match(r"[+-]?\.?\d", word) for word in words):
            first = False
            continue
        first = False
        for word in words:
            if not _WHOLE.fullmatch(word) or int(word) < 1:
                raise InputError(f"{path}: line {number}: {_short(word)} is not a node's number")
            found.append(int(word))
    if not found:
        raise InputError(f"{path}: no nodes in it")
    nodes = np.array(found, np.int64)
    if again := _repeated(nodes):
        raise InputError(f"{path}: node {again} is listed twice")
    return nodes


def load_pairs(path: PathLike) -> Mapping[str, _Column]:
    """Read columns under a line of their names, as spreadsheets write them.

    A comma, semicolon or tab separates columns; blank lines and what follows a # are left out.

    Parameters
    ----------
    path : path
        A .csv file.

    Returns
    -------
    dict of str to (k,) array
        Columns by name, in the file's order: int where all cells are whole numbers, float where
        they are finite numbers, else text.

    Raises
    ------
    InputError
        One line with the file's name and the line's number.
    """
    path = Path(path)
    lines = list(_lines(path))
    if not lines:
        raise InputError(f"{path}: no line of column names in it")
    number, head = lines[0]
    separator = next((each for each in ";\t," if each in head), ",")
    names = _cells(path, number, head, separator)
    if any(not name or _NUMBER.fullmatch(name) for name in names):
        raise InputError(f"{path}: line {number}: a line of column names is needed first")
    again, most = Counter(names).most_common(1)[0]
    if most > 1:
        raise InputError(f"{path}: line {number}: column {_short(again)} is named twice")
    rows = []
    for number, line in lines[1:]:
        cells = _cells(path, number, line, separator)
        if len(cells) != len(names) or not all(cells):
            filled = sum(map(bool, cells))
            raise InputError(f"{path}: line {number}: {filled} cells for {len(names)} columns")
        rows.append(cells)
    if not rows:
        raise InputError(f"{path}: no rows below its column names")
    return {name: _column(path, name, [row[k] for row in rows]) for k, name in enumerate(names)}


def _lines(path: Path) -> list[tuple[int, str]]:
    """Lines that say something, with their numbers."""
    found = []
    for number, line in enumerate(text(path).splitlines(), start=1):
        said = line.partition("#")[0].strip()
        if said.strip(",;"):
            found.append((number, said))
    return found


def _cells(path: Path, number: int, line: str, separator: str) -> list[str]:
    try:
        (cells,) = csv.reader([line], delimiter=separator, skipinitialspace=True)
    except (csv.Error, ValueError):
        raise InputError(f"{path}: line {number}: not cells of a table") from None
    return [cell.strip() for cell in cells]


def _column(path: Path, name: str, cells: list[str]) -> _Column:
    """Whole numbers, numbers or text; a column that begins with numbers must go on with them."""
    if all(map(_WHOLE.fullmatch, cells)):
        return np.array([int(cell) for cell in cells], np.int64)
    if not any(map(_NUMBER.fullmatch, cells)):
        return np.array(cells, str)
    for cell in cells:
        if not _NUMBER.fullmatch(cell) or not np.isfinite(_float(cell)):
            raise InputError(f"{path}: column {_short(name)}: {_short(cell)} is not a number")
    return np.array([_float(cell) for cell in cells])


def _float(cell: str) -> float:
    return float(re.sub("[dD]", "e", cell))


def _repeated(values: Integers) -> int | None:
    """The first value that is there more than once."""
    distinct, count = np.unique(values, return_counts=True)
    return int(distinct[count > 1][0]) if (count > 1).any() else None


def _short(word: str) -> str:
    return ascii(word if len(word) <= 30 else word[:27] + "...")


_NAMES = {
    **{"x": 0, "y": 1, "z": 2, "rx": 3, "ry": 4, "rz": 5},
    **{"ux": 0, "uy": 1, "uz": 2, "rotx": 3, "roty": 4, "rotz": 5},
    "modal": GENERALISED,
}
"""Directions by name."""
_MAPPED = re.compile(r"\s*(\d{1,12})\s+(\d{1,12})\s+([A-Za-z]\w{0,7})\s*")

Labels = tuple[Integers, Integers]


def read_labels(path: Path, size: int) -> Labels:
    """Node and direction of each row."""
    if path.suffix.lower() == ".mapping":
        order, node, direction = _mapping(path)
    else:
        order, node, direction = _table(path)
    if len(node) != size:
        raise InputError(f"{path}: {len(node):,} lines for a matrix of {size:,} rows")
    wrong = np.sort(order) != np.arange(1, size + 1)
    if wrong.any():
        raise InputError(
            f"{path}: rows are not numbered 1 to {size}, each once "
            f"({int(np.flatnonzero(wrong)[0]) + 1} is missing or repeated)"
        )
    place = np.argsort(order)
    return node[place], direction[place]


def check_labels(source: str, node: Integers, direction: Integers) -> Labels:
    """Refuse labels that are not unique; generalised coordinates have no node."""
    own = direction != GENERALISED
    if (wrong := own & (node < 1)).any():
        k = int(np.flatnonzero(wrong)[0])
        raise InputError(f"{source}: row {k + 1}: node {int(node[k])}: nodes are numbered from 1")
    keys = np.sort(node[own] * (GENERALISED + 1) + direction[own])
    again = keys[1:][keys[1:] == keys[:-1]]
    if len(again):
        at, way = divmod(int(again[0]), GENERALISED + 1)
        raise InputError(f"{source}: node {at}, direction {named(way)} labels two rows")
    return np.where(own, node, 0), direction


def named(direction: int) -> str:
    """A direction's name."""
    return next(name for name, number in _NAMES.items() if number == direction)


def _mapping(path: Path) -> tuple[Integers, Integers, Integers]:
    """Lines of row, node and freedom under a heading."""
    rows: list[tuple[int, int, int]] = []
    for number, line in enumerate(text(path).splitlines(), start=1):
        found = _MAPPED.fullmatch(line)
        if found is None:
            if rows and line.strip():
                raise InputError(f"{path}: line {number}: not a row, a node and a freedom")
            continue
        direction = _NAMES.get(found[3].lower())
        if direction is None:
            raise InputError(
                f"{path}: line {number}: {found[3]}: displacements and rotations are read "
                "(UX, UY, UZ, ROTX, ROTY, ROTZ)"
            )
        rows.append((int(found[1]), int(found[2]), direction))
    if not rows:
        raise InputError(f"{path}: no line with a row, a node and a freedom")
    order, node, direction = np.array(rows, np.int64).T
    return order, node, direction


def _table(path: Path) -> tuple[Integers, Integers, Integers]:
    columns = {name.lower(): values for name, values in load_pairs(path).items()}
    for name in ("node", "dof" if "dof" in columns else "direction"):
        if name not in columns:
            raise InputError(
                f"{path}: no column {name!r}: needed are node, and direction (x, y, z, rx, ry, rz, "
                "modal) or dof (1 to 6)"
            )
    node = _whole(path, "node", columns["node"])
    if "dof" in columns:
        dof = _whole(path, "dof", columns["dof"])
        if ((dof < 0) | (dof > 6)).any():
            raise InputError(f"{path}: column 'dof': 1 to 6 are directions, 0 is modal")
        direction = np.where(dof == 0, GENERALISED, dof - 1)
    else:
        words = [str(word).lower() for word in columns["direction"]]
        if unknown := next((word for word in words if word not in _NAMES), None):
            raise InputError(
                f"{path}: column 'direction': {unknown[:20]!a}: x, y, z, rx, ry, rz or modal"
            )
        direction = np.array([_NAMES[word] for word in words], np.int64)
    order = columns.get("row")
    rows = np.arange(1, len(node) + 1) if order is None else _whole(path, "row", order)
    return rows, node, direction


def _whole(path: Path, name: str, values: object) -> Integers:
    found = np.asarray(values)
    if found.dtype.kind != "i":
        raise InputError(f"{path}: column {name!r}: whole numbers are needed")
    return found.astype(np.int64)
