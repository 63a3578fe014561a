"""Tables of what was found, for a terminal, a page, a file and machines alike.

Rows are in SI units; a column gives the unit in which it is shown, as a study file's keys convert.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final, Literal, TypeAlias

import numpy as np

MOST_CASES = 24
"""Cases that a table by case has; of more it says so."""
Cell: TypeAlias = str | float | int | np.generic | None
Shown: TypeAlias = str | float | int | None
Flag = Literal["", "good", "warn", "bad"]

FACTORS: Final = {
    "%": 1e2,
    "µm": 1e6,
    "mm": 1e3,
    "mm²": 1e6,
    "mm³": 1e9,
    "cm³": 1e6,
    "µJ": 1e6,
    "mW": 1e3,
    "MPa": 1e-6,
    "ms": 1e3,
}
"""What a number in SI units is multiplied by, by the unit shown up to its "/"."""


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    head : str
        What stands above it.
    unit : str
        In which its numbers are shown: "µm", "µJ/cycle"; its cells are in that of the SI.
    form : str
        Format of its numbers, such as ".1f"; by default whole numbers are given in full, others to
        four significant digits.
    key : str
        Its name for machines, by default the head.
    note : str
        An explanation, which then stands below the table.
    minor : bool
        Whether a terminal that is too narrow for all columns does without it.
    """

    head: str
    unit: str = ""
    form: str = ""
    key: str = ""
    note: str = ""
    minor: bool = False

    @property
    def name(self) -> str:
        """Its name for machines."""
        return self.key or self.head

    def shown(self, cell: Cell) -> Shown:
        """A cell in the unit shown; None where there is nothing, not a number included."""
        value: Shown = cell.item() if isinstance(cell, np.generic) else cell
        if value is None or value != value or isinstance(value, str):
            return value if isinstance(value, str) else None
        factor = FACTORS.get(self.unit.partition("/")[0])
        return value if factor is None else factor * value

    def text(self, value: Shown) -> str:
        """A cell in the unit shown as text; "-" where there is nothing."""
        if value is None or isinstance(value, str):
            return "-" if value is None else value
        if isinstance(value, bool):
            return "yes" if value else "no"
        return format(value, self.form or ("," if isinstance(value, int) else ".4g"))


@dataclass(frozen=True)
class Table:
    """Rows of text and numbers under a title.

    Attributes
    ----------
    title : str
        Heading.
    columns : sequence of Column
    rows : sequence of sequences of cells
        Text, numbers in SI units, None or NaN where there is nothing.
    notes : sequence of str
        Lines below the table.
    key : str
        Name for machines.
    flags : sequence of {"", "good", "warn", "bad"}
        One for each row, or none at all; a page shows them.
    folded : bool
        A page shows it only when it is asked for, and on paper.
    """

    title: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    notes: Sequence[str] = ()
    key: str = ""
    flags: Sequence[Flag] = ()
    folded: bool = False

    @property
    def lines(self) -> list[str]:
        """What stands below it: notes of its columns, then its own."""
        message = "; ".join(column.note for column in self.columns if column.note)
        return [*([f"{message}."] if message else []), *self.notes]

    @cached_property
    def shown(self) -> list[list[Shown]]:
        """The rows in the units of their columns."""
        return [
            [column.shown(cell) for column, cell in zip(self.columns, row, strict=True)]
            for row in self.rows
        ]

    def record(self) -> dict[str, Any]:
        """The table for machines: a list of rows by column name."""
        names = [column.name for column in self.columns]
        rows = [dict(zip(names, row, strict=True)) for row in self.shown]
        return {"table": self.key, "rows": rows, "notes": self.lines}

    def by_head(self) -> dict[str, list[Any]]:
        """The columns by head and unit, as CSV files have them: "peak (µm)"."""
        units = [column.unit.replace("²", "^2").replace("³", "^3") for column in self.columns]
        heads = [
            f"{column.head} ({unit})" if unit else column.head
            for column, unit in zip(self.columns, units, strict=True)
        ]
        return {head: [row[i] for row in self.shown] for i, head in enumerate(heads)}

    def without(self, *names: str) -> "Table":
        """The same without some columns."""
        kept = [i for i, column in enumerate(self.columns) if column.name not in names]
        columns = tuple(self.columns[i] for i in kept)
        return replace(self, columns=columns, rows=[[row[i] for i in kept] for row in self.rows])

    def without_empty(self, *names: str) -> "Table":
        """The same without those of some columns that have nothing."""
        cells = zip(*self.shown, strict=True)
        empty = [c.name for c, own in zip(self.columns, cells, strict=False) if set(own) <= {None}]
        return self.without(*set(names).intersection(empty))


def counted(count: int, noun: str) -> str:
    """A number of things: "1 contact", "2,000 meshes"."""
    plural = "es" if noun.endswith(("s", "sh", "x")) else "s"
    return f"{count:,} {noun}{'' if count == 1 else plural}"


def heads(*names: str) -> tuple[Column, ...]:
    """Columns of text."""
    return tuple(map(Column, names))


def by_case(made: Table, count: int) -> list[Table]:
    """A table that begins with the case, of so many cases: what it leaves out is said.

    None where it has no rows.
    """
    if count == 1:
        made = made.without("case")
    elif count > MOST_CASES:
        rest = f"the first {MOST_CASES} of {count} cases; results.h5 has all"
        made = replace(made, notes=[*made.notes, rest])
    return [made] if made.rows else []
