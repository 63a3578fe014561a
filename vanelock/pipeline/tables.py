"""The tables that end a run: plain data, printed by the progress display that is in use."""

from dataclasses import dataclass
from typing import Any, TypeAlias

from rich.box import SIMPLE_HEAD
from rich.table import Table as RichTable

from vanelock.common.errors import printable

Cell: TypeAlias = str | float | int | None


@dataclass(frozen=True)
class Column:
    """A table's column: its name for machines, its head and the format of its numbers."""

    key: str
    head: str
    form: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of text and numbers under a title.

    Attributes
    ----------
    key : str
        Name for machines.
    title : str
        Heading.
    columns : tuple of Column
        Columns; `form` is the format of a number, such as ".1f".
    rows : tuple of tuples
        Cells: text, numbers, None where there is nothing.
    notes : tuple of str
        Lines below the table.
    """

    key: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()

    def record(self) -> dict[str, Any]:
        """The table for machines: a list of rows by column key."""
        keys = [column.key for column in self.columns]
        rows = [dict(zip(keys, row, strict=True)) for row in self.rows]
        return {"table": self.key, "rows": rows, "notes": list(self.notes)}

    def rich(self) -> RichTable:
        """The table for people, without its title."""
        table = RichTable(box=SIMPLE_HEAD, pad_edge=False)
        for i, column in enumerate(self.columns):
            numbers = any(isinstance(row[i], int | float) for row in self.rows)
            table.add_column(
                printable(column.head), justify="right" if numbers else "left", no_wrap=True
            )
        for row in self.rows:
            cells = zip(row, self.columns, strict=True)
            table.add_row(*(_text(cell, column.form) for cell, column in cells))
        return table


def _text(cell: Cell, form: str) -> str:
    if cell is None:
        return "-"
    return printable(cell) if isinstance(cell, str) else format(cell, form)
