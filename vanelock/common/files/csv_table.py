"""Columns of numbers as a CSV file, which spreadsheets and every language read.

One header line with each column's name and unit, such as "frequency (Hz)", a line for each row,
commas between, points in numbers. A number is the shortest one that reads back as itself; what is
not a number is an empty cell. Notes, if any, come first, each on a line that starts with "# ".
"""

import csv
import io
from collections.abc import Mapping, Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array
from vanelock.common.files.files import placed


def write_columns(
    path: str | Path, columns: Mapping[str, ArrayLike], notes: Sequence[str] = ()
) -> Path:
    """Write columns as a CSV file, as a whole or not at all, and return the path."""
    cells = [_cells(np.asarray(values)) for values in columns.values()]
    text = io.StringIO()
    for note in notes:
        text.write("".join(f"# {line}\n" for line in note.splitlines()))
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(_harmless, columns))
    writer.writerows(zip_longest(*cells, fillvalue=""))
    target = Path(path)
    with placed(target) as temporary:
        temporary.write_bytes(text.getvalue().encode("utf-8", "replace"))
    return target


def _cells(values: Array) -> list[str]:
    """A column's cells."""
    numbers = values.astype(int) if values.dtype.kind == "b" else values
    return [_cell(value) for value in numbers.tolist()]


def _cell(value: object) -> str:
    if value is None or value != value:
        return ""
    return _harmless(value) if isinstance(value, str) else str(value)


def _harmless(text: str) -> str:
    """Text that a spreadsheet would take for a formula, behind the mark that makes it text."""
    if not text.startswith(("=", "+", "-", "@", "\t", "\r")):
        return text
    try:
        float(text)
    except ValueError:
        return text if text == "-" else f"'{text}"
    return text


def rows_of_cells(text: str) -> list[tuple[int, list[str]]]:
    """Lines of a CSV file of the user with their numbers, as cells; the first names the columns.

    Blank lines and those that begin with # are left out; a semicolon, tab or comma separates cells,
    as the first line says.
    """
    numbered = enumerate(text.splitlines(), 1)
    lines = [(i, line) for i, line in numbered if line.partition("#")[0].strip()]
    mark = max(";\t,", key=lines[0][1].count) if lines else ","
    return [(i, [cell.strip().strip('"').strip() for cell in s.split(mark)]) for i, s in lines]


def short(values: ArrayLike) -> list[float]:
    """Numbers to six significant digits, for tables of all nodes."""
    return [float(f"{v:.6g}") for v in np.asarray(values, float).ravel()]
