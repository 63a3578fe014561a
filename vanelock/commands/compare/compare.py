"""Two runs side by side: what they were given, what they found, and what they cost."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vanelock.commands.compare.load import CaseFound, Loaded, load_run
from vanelock.commands.compare.page import compare_page
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import write_columns
from vanelock.input.settings import flattened, same, told
from vanelock.pipeline.progress import Listener, Notice, silent
from vanelock.pipeline.tables import Cell, Column, Table
from vanelock.report import write_page

PAGE, TABLE = "compare.html", "compare.csv"

QUANTITIES = (
    ("peak_amplitude", "peak", 1e6, "µm", ".4g"),
    ("peak_frequency", "peak frequency", 1.0, "Hz", ".6g"),
    ("damping_ratio", "damping ratio, energy", 100.0, "%", ".3g"),
    ("bandwidth_ratio", "damping ratio, bandwidth", 100.0, "%", ".3g"),
    ("of_free", "of the linear peak, free", 1.0, "", ".4g"),
    ("of_stuck", "of the linear peak, stuck", 1.0, "", ".4g"),
    ("friction_share", "interlock's share of friction", 100.0, "%", ".4g"),
    ("alternating_stress", "alternating stress", 1e-6, "MPa", ".4g"),
    ("mean_stress", "mean stress", 1e-6, "MPa", ".4g"),
    ("goodman_reserve", "HCF reserve", 1.0, "", ".4g"),
    ("largest_slip", "largest slip a cycle", 1e6, "µm", ".4g"),
    ("harmonics", "harmonics", 1.0, "", ".0f"),
    ("points", "points", 1.0, "", ".0f"),
    ("converged", "converged", 1.0, "", ".0f"),
    ("seconds", "time", 1.0, "s", ".3g"),
)
"""Of a case: key in the results, words, factor to the unit shown, unit, format."""
COUNTS = ("harmonics", "points", "converged")
"""Of these, settings and counts, no relative difference is told."""


@dataclass(frozen=True)
class Pair:
    """A case of each run that belong together, and by what."""

    one: CaseFound
    other: CaseFound
    by: str

    @property
    def name(self) -> str:
        """What tables call it."""
        if self.one.name == self.other.name:
            return self.one.name
        return f"{self.one.name} | {self.other.name}"


@dataclass(frozen=True)
class Line:
    """A number of both runs: what it is of, what it is, its unit and both values."""

    of: str
    what: str
    unit: str
    form: str
    one: float | None
    other: float | None

    @property
    def change(self) -> float | None:
        """Relative difference, the other less the first over the first; None where undefined.

        None of counts, too.
        """
        if self.one is None or self.other is None or self.one == 0 or self.what in COUNTS:
            return None
        return self.other / self.one - 1


@dataclass(frozen=True)
class Comparison:
    """Two runs, their cases in pairs, and what could not be compared, a line each."""

    one: Loaded
    other: Loaded
    pairs: tuple[Pair, ...]
    notes: tuple[str, ...]

    @property
    def inputs(self) -> list[tuple[str, str, str]]:
        """Keys that differ, with both values in words."""
        return list(_differing(self.one, self.other))

    @property
    def results(self) -> list[Line]:
        """Numbers of all pairs of cases."""
        return [line for pair in self.pairs for line in _lines(pair)]

    @property
    def sizes(self) -> list[Line]:
        """Model sizes and times."""
        found = []
        for what in dict.fromkeys([*self.one.sizes, *self.other.sizes]):
            both = (self.one.sizes.get(what), self.other.sizes.get(what))
            found.append(Line("model", what, "", ",.0f", *both))
        for what in dict.fromkeys([*self.one.seconds, *self.other.seconds]):
            both_times = (self.one.seconds.get(what), self.other.seconds.get(what))
            found.append(Line("time", what, "s", ".3g", *both_times))
        return found


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
        Told the tables.

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
    for table in tables(found):
        listener(table)
    _write_csv(target / TABLE, found)
    write_page(target / PAGE, compare_page(found))
    listener(Notice(f"{target / PAGE} and {target / TABLE} written"))
    return found


def compared(one: Loaded, other: Loaded) -> Comparison:
    """Cases in pairs, and what is missing."""
    pairs, notes = matched(one, other)
    missing = [
        f"{run.folder}: the run is not complete; what it has, {len(run.cases)} cases, is compared"
        for run in (one, other)
        if not run.complete
    ]
    if one.monitor and other.monitor and one.monitor != other.monitor:
        missing.append(
            f"amplitudes are of different displacements: {one.monitor} in {one.label}, "
            f"{other.monitor} in {other.label}"
        )
    return Comparison(one, other, tuple(pairs), (*missing, *notes))


def matched(one: Loaded, other: Loaded) -> tuple[list[Pair], list[str]]:
    """Cases that belong together: by name, else by the values they share, else by their order."""
    pairs = [Pair(c, other.cases[n], "name") for n, c in one.cases.items() if n in other.cases]
    taken = {pair.one.name for pair in pairs}
    left = [case for name, case in one.cases.items() if name not in taken]
    right = [case for name, case in other.cases.items() if name not in taken]
    for case in list(left):
        alike = [each for each in right if _agree(case, each)]
        if len(alike) == 1 and [c for c in left if _agree(c, alike[0])] == [case]:
            pairs.append(Pair(case, alike[0], "values"))
            left.remove(case)
            right.remove(alike[0])
    pairs += [Pair(a, b, "order") for a, b in zip(left, right, strict=False)]
    notes = [
        f"{p.one.name} in {one.label} is compared with {p.other.name} in {other.label}, by {p.by}"
        for p in pairs
        if p.by != "name"
    ]
    alone = [(one, c) for c in left[len(right) :]] + [(other, c) for c in right[len(left) :]]
    notes += [f"{case.name} is in {run.label} alone" for run, case in alone]
    return pairs, notes


def _agree(one: CaseFound, other: CaseFound) -> bool:
    """Whether cases share swept keys and have the same values of all that they share."""
    shared = one.values.keys() & other.values.keys()
    return bool(shared) and all(same(one.values[key], other.values[key]) for key in shared)


def tables(found: Comparison) -> list[Table]:
    """What the terminal shows."""
    one, other = found.one.label, found.other.label
    inputs = Table(
        "inputs",
        "Inputs that differ" if found.inputs else "Inputs: all the same",
        (Column("key", "key"), Column("one", one), Column("other", other)),
        tuple(found.inputs),
    )
    versions = Table(
        "versions",
        "Programs",
        (Column("program", "program"), Column("one", one), Column("other", other)),
        tuple(_versions(found)),
    )
    return [
        inputs,
        _numbers("results", "Results", found.results, found, "case"),
        _numbers("sizes", "Models and times", found.sizes, found, "of"),
        versions,
    ]


def _versions(found: Comparison) -> Iterator[tuple[Cell, ...]]:
    yield "date", found.one.date, found.other.date
    one, other = found.one.versions, found.other.versions
    for name in dict.fromkeys([*one, *other]):
        if one.get(name) != other.get(name) or name == "vanelock":
            yield name, one.get(name), other.get(name)


def _numbers(key: str, title: str, lines: Sequence[Line], found: Comparison, of: str) -> Table:
    columns = (
        Column("of", of),
        Column("what", "what"),
        Column("one", found.one.label),
        Column("other", found.other.label),
        Column("change", "difference"),
    )
    rows = tuple(
        (line.of, line.what, shown(line, line.one), shown(line, line.other), change(line))
        for line in lines
    )
    return Table(key, title, columns, rows)


def shown(line: Line, value: float | None) -> str | None:
    """A number of a line with its unit."""
    return None if value is None else f"{value:{line.form}} {line.unit}".rstrip()


def change(line: Line) -> str | None:
    """Its relative difference in per cent."""
    if line.one == line.other:
        return "same"
    return None if line.change is None else f"{100 * line.change:+.3g} %"


def _lines(pair: Pair) -> Iterator[Line]:
    for key, what, factor, unit, form in QUANTITIES:
        values = [
            None if not np.isfinite(case.numbers.get(key, np.nan)) else factor * case.numbers[key]
            for case in (pair.one, pair.other)
        ]
        if any(value is not None for value in values):
            yield Line(pair.name, what, unit, form, *values)


def _differing(one: Loaded, other: Loaded) -> Iterator[tuple[str, str, str]]:
    first, second = flattened(one.settings), flattened(other.settings)
    for key in dict.fromkeys([*first, *second]):
        if same(first.get(key), second.get(key)):  # a key of a later version that is not set, too
            continue
        both = [told(key, known[key]) if key in known else "-" for known in (first, second)]
        yield key, both[0], both[1]


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
            line.unit,
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
