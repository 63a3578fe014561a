"""Text files with lists of nodes and with columns: who is in contact, which row is which."""

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

Column = Integers | Floats | NDArray[np.str_]
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


def load_pairs(path: PathLike) -> Mapping[str, Column]:
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


def _column(path: Path, name: str, cells: list[str]) -> Column:
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
