"""Compare two runs: tables, a page and a CSV file."""

import os
from pathlib import Path

from vanelock.commands.compare.comparison import Comparison, compared, tables
from vanelock.commands.compare.page import compare_page
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import write_columns
from vanelock.pipeline.progress import Listener, Notice, silent
from vanelock.report import write_page
from vanelock.results.reading.contents import load_run

PAGE, TABLE = "compare.html", "compare.csv"


def compare_runs(
    one: str | os.PathLike[str],
    other: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    listener: Listener = silent,
) -> Comparison:
    """Compare two runs: tables for the listener, compare.html and compare.csv in a folder.

    Parameters
    ----------
    one, other : path
        The runs' folders.
    output : path, optional
        Where the page and the table go; by default `compare_<one>_<other>` in the current folder.
    listener : callable
        Called with the tables.

    Raises
    ------
    InputError
        If a folder holds no results, both are the same, or the output would go into one of them.
    """
    folders = Path(one), Path(other)
    labels = _labels(*folders)
    first, second = (load_run(f, label) for f, label in zip(folders, labels, strict=True))
    if folders[0].resolve() == folders[1].resolve():
        raise InputError(f"{folders[1]}: the same folder as {folders[0]}: nothing to compare")
    target = Path(output) if output is not None else Path(f"compare_{labels[0]}_{labels[1]}")
    for folder in folders:
        if target.resolve().is_relative_to(folder.resolve()):
            raise InputError(
                f"--output {target}: lies in the run's folder {folder}; name one outside of it"
            )
    found = compared(first, second)
    for note in found.notes:
        listener(Notice(note))
    made = tables(found)
    for table in made:
        listener(table.without("meaning"))
    _write_csv(target / TABLE, found)
    write_page(target / PAGE, compare_page(found, made))
    listener(Notice(f"{target / PAGE} and {target / TABLE} written"))
    return found


def _labels(one: Path, other: Path) -> tuple[str, str]:
    """Short names of two folders that differ."""
    first, second = one.resolve(), other.resolve()
    if first.name != second.name:
        return first.name, second.name
    return f"{first.parent.name}-{first.name}", f"{second.parent.name}-{second.name}"


def _write_csv(path: Path, found: Comparison) -> None:
    """All differing inputs and all numbers, a line each."""
    inputs = [("input", key, "", a, b, "") for key, a, b in found.inputs]
    numbers = [
        (
            line.of,
            line.what,
            line.column.unit,
            *("" if v is None else f"{v:.10g}" for v in (line.one, line.other)),
            "" if line.change is None else f"{line.change:.6g}",
        )
        for line in [*found.results, *found.sizes]
    ]
    rows = [*inputs, *numbers]
    heads = ("of", "what", "unit", found.one.label, found.other.label, "relative difference")
    columns = {head: [row[i] for row in rows] for i, head in enumerate(heads)}
    notes = [f"{found.one.folder} against {found.other.folder}", *found.notes]
    write_columns(path, columns, notes)
