"""`vanelock compare`: two runs side by side, as tables, a page and a CSV file."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import vanelock
from vanelock.commands.stored.contents import StoredRun, load_run
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import write_columns
from vanelock.common.tables import Cell, Column, Table, counted, heads
from vanelock.files import Study
from vanelock.input.cases.names import fixed, words
from vanelock.input.settings import as_text, described, flattened, same
from vanelock.pipeline.progress import Listener, Notice, kind_of, silent
from vanelock.quantities.case_result import CaseResult
from vanelock.render import Curve
from vanelock.report import Answer, Answers, Page, Plot, Section, Text, curve_plot, write_page
from vanelock.stages.response.summary import figures

PAGE, TABLE = "compare.html", "compare.csv"
QUANTITIES = (
    Column("peak", "µm", ".4g", "peak_amplitude"),
    Column("peak frequency", "Hz", ".6g", "peak_frequency"),
    Column("lower bound of the peak", "µm", ".4g", "lowest_peak_amplitude"),
    Column("upper bound of the peak", "µm", ".4g", "highest_peak_amplitude"),
    Column("growth per cycle", "", ".4g", "growth_in_a_period"),
    Column("damping ratio by energy", "%", ".3g", "damping_ratio"),
    Column("damping ratio by bandwidth", "%", ".3g", "bandwidth_ratio"),
    Column("relative to the free linear peak", key="of_free"),
    Column("relative to the stuck linear peak", key="of_stuck"),
    Column("interlock's share of friction", "%", ".4g", "friction_share"),
    Column("alternating stress", "MPa", ".4g", "alternating_stress"),
    Column("mean stress", "MPa", ".4g", "mean_stress"),
    Column("HCF safety factor", key="goodman_reserve"),
    Column("largest slip per cycle", "µm", ".4g", "largest_slip"),
    Column("harmonics", form=".0f"),
    Column("points", form=".0f"),
    Column("converged", form=".0f"),
    Column("time", "s", ".3g", "seconds"),
)
"""Of a case, by their keys in the results."""
COUNTS = ("harmonics", "points", "converged")
"""Of these, settings and counts, no relative difference is reported."""
CARDS = {
    "peak": "Peak",
    "peak frequency": "Frequency",
    "damping ratio by energy": "Damping ratio",
    "HCF safety factor": "HCF safety factor",
}
"""Results that stand on top."""
MOST = 2
"""Cases on top, those that change most."""


class Line(NamedTuple):
    """A number of both runs: what it is of, what it is, and both values in the unit shown."""

    of: str
    column: Column
    values: tuple[float | None, float | None]

    @property
    def change(self) -> float | None:
        """Relative difference, the other less the first over the first; None where undefined."""
        one, other = self.values
        if not one or other is None or self.column.head in COUNTS:
            return None
        return other / one - 1

    @property
    def row(self) -> tuple[Cell, ...]:
        """A line of a table: both values with their unit, and the difference in per cent."""
        text, unit = self.column.text, self.column.unit
        both = (None if v is None else f"{text(v)} {unit}".rstrip() for v in self.values)
        change = None if self.change is None else f"{100 * self.change:+.3g} %"
        same = self.values[0] == self.values[1]
        return self.of, self.column.head, *both, "same" if same else change


@dataclass(frozen=True)
class _Comparison:
    """Two runs, their cases in pairs, and what could not be compared, a line each."""

    runs: tuple[StoredRun, StoredRun]
    pairs: Sequence[tuple[CaseResult, CaseResult]]
    notes: Sequence[str]

    @cached_property
    def inputs(self) -> list[tuple[str, str, str]]:
        """Keys that differ, with both values in words."""
        one, other = (flattened(run.settings) for run in self.runs)
        differ = (k for k in {**one, **other} if not same(one.get(k), other.get(k)))
        texts = (
            (k, [as_text(k, of[k]) if k in of else "-" for of in (one, other)]) for k in differ
        )
        return [(key, both[0], both[1]) for key, both in texts]

    @cached_property
    def results(self) -> list[Line]:
        """Numbers of all pairs of cases."""
        return [line for pair in self.pairs for line in _lines(*pair)]

    @cached_property
    def sizes(self) -> list[Line]:
        """Model sizes and times."""
        sizes, times = [run.sizes for run in self.runs], [_seconds(run) for run in self.runs]
        kinds = ("model", sizes, "", ",.0f"), ("time", times, "s", ".3g")
        return [
            Line(of, Column(what, unit, form), (one.get(what), other.get(what)))
            for of, (one, other), unit, form in kinds
            for what in {**one, **other}
        ]

    @cached_property
    def tables(self) -> list[Table]:
        """Differing inputs, results, sizes and times, and programs."""
        both = [
            Column(r.label, key=key) for r, key in zip(self.runs, ("one", "other"), strict=True)
        ]
        title = "Inputs that differ, defaults included" if self.inputs else "Inputs: all the same"
        rows = [(key, described(key, Study)[0], *values) for key, *values in self.inputs]
        made = [Table(title, (*heads("key", "what it is"), *both), rows, key="inputs")]
        columns = (*heads("of", "what"), *both, Column("difference", key="change"))
        for key, title, lines in (
            ("results", "Results", self.results),
            ("sizes", "Models and times", self.sizes),
        ):
            made.append(Table(title, columns, [line.row for line in lines], key=key))
        one, other = (run.versions for run in self.runs)
        programs = [
            ("folder", *(str(run.folder) for run in self.runs)),
            ("date", *(run.date for run in self.runs)),
            ("complete", *("yes" if run.complete else "NO" for run in self.runs)),
            *((name, one.get(name), other.get(name)) for name in {**one, **other}),
        ]
        shown = [row for row in programs if row[1] != row[2] or row[0] == "vanelock"]
        return [*made, Table("Programs", (*heads("program"), *both), shown, key="versions")]


def _called(one: CaseResult, other: CaseResult) -> str:
    """What tables call a pair."""
    return " | ".join(dict.fromkeys((one.name, other.name)))


def _lines(one: CaseResult, other: CaseResult) -> Iterator[Line]:
    both = [_numbers(each) for each in (one, other)]
    for column in QUANTITIES:
        values = [each.get(column.name, np.nan) for each in both]
        if np.isfinite(values).any():
            shown: list[Any] = [column.shown(v) if np.isfinite(v) else None for v in values]
            yield Line(_called(one, other), column, (shown[0], shown[1]))


def _numbers(case: CaseResult) -> dict[str, float]:
    known = {name: v for name, (v, _) in case.numbers.items() if isinstance(v, int | float)}
    return figures(case.summary) | known


def _seconds(run: StoredRun) -> dict[str, float]:
    """What computing took, by kind of stage; empty while a run is not complete."""
    found: dict[str, float] = {}
    for each in run.times.values():
        kind = kind_of(each.stage)
        found[kind] = found.get(kind, 0.0) + each.seconds
    return found


def compare_runs(
    one: str | os.PathLike[str],
    other: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    listener: Listener = silent,
) -> _Comparison:
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
    labels = [folder.resolve().name for folder in folders]
    if labels[0] == labels[1]:
        labels = ["-".join(folder.resolve().parts[-2:]) for folder in folders]
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
    for table in found.tables:
        listener(table.without("what it is"))
    _write_csv(target / TABLE, found)
    write_page(target / PAGE, compare_page(found))
    listener(Notice(f"{target / PAGE} and {target / TABLE} written"))
    return found


def compared(one: StoredRun, other: StoredRun) -> _Comparison:
    """Cases in pairs, and what is missing."""
    pairs, notes = matched(one, other)
    missing = [
        f"{run.folder}: the run is not complete; compared: {counted(len(run.cases), 'case')}"
        for run in (one, other)
        if not run.complete
    ]
    names = one.monitor.name, other.monitor.name
    if all(names) and names[0] != names[1]:
        missing.append(
            f"amplitudes are of different displacements: {names[0]} in {one.label}, "
            f"{names[1]} in {other.label}"
        )
    return _Comparison((one, other), pairs, (*missing, *notes))


def matched(
    one: StoredRun, other: StoredRun
) -> tuple[list[tuple[CaseResult, CaseResult]], list[str]]:
    """Cases that belong together: by name, else by the values they share, else by their order."""
    pairs = [(case, other.cases[n]) for n, case in one.cases.items() if n in other.cases]
    left, right = (
        [case for name, case in run.cases.items() if name not in (one.cases.keys() & other.cases)]
        for run in (one, other)
    )
    by: list[str] = []
    for case in list(left):
        alike = [each for each in right if _agree(case, each)]
        if len(alike) == 1 and [c for c in left if _agree(c, alike[0])] == [case]:
            pairs.append((case, alike[0]))
            by.append("values")
            left.remove(case)
            right.remove(alike[0])
    in_order = list(zip(left, right, strict=False))
    others = zip(
        [*pairs[len(pairs) - len(by) :], *in_order], [*by, *["order"] * len(in_order)], strict=True
    )
    notes = [
        f"{a.name} in {one.label} is compared with {b.name} in {other.label}, by {how}"
        for (a, b), how in others
    ]
    alone = [(one, c) for c in left[len(right) :]] + [(other, c) for c in right[len(left) :]]
    notes += [f"{case.name} is in {run.label} alone" for run, case in alone]
    return [*pairs, *in_order], notes


def _agree(one: CaseResult, other: CaseResult) -> bool:
    """Whether cases share swept keys and have the same values of all that they share."""
    shared = one.values.keys() & other.values.keys()
    return bool(shared) and all(same(one.values[key], other.values[key]) for key in shared)


def _write_csv(path: Path, found: _Comparison) -> None:
    """All differing inputs and all numbers, a line each."""
    rows: list[tuple[str, ...]] = [("input", key, "", a, b, "") for key, a, b in found.inputs]
    for line in [*found.results, *found.sizes]:
        numbers = ("" if v is None else f"{v:.10g}" for v in line.values)
        change = "" if line.change is None else f"{line.change:.6g}"
        rows.append((line.of, line.column.head, line.column.unit, *numbers, change))
    names = ("of", "what", "unit", *(run.label for run in found.runs), "relative difference")
    columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    notes = [" against ".join(str(run.folder) for run in found.runs), *found.notes]
    write_columns(path, columns, notes)


def compare_page(found: _Comparison) -> Page:
    """Curves over one another, and tables of all that differs."""
    inputs, results, *others = found.tables
    rows = [(fixed(_words(str(name))), *rest) for name, *rest in results.rows]
    return Page(
        " against ".join(run.label for run in found.runs),
        f"Two runs side by side; vanelock {vanelock.__version__}",
        [
            Section("Summary", _summary(found)),
            Section("Curves", [_plot(found)]),
            *(
                Section(each.title, [replace(each, title="")])
                for each in (inputs, replace(results, rows=rows), *others)
            ),
        ],
    )


def _summary(found: _Comparison) -> list[Answers | Text]:
    by_case: dict[str, list[Line]] = {}
    for line in found.results:
        if line.column.head in CARDS:
            by_case.setdefault(line.of, []).append(line)
    order = sorted(by_case, key=lambda case: -max(abs(e.change or 0.0) for e in by_case[case]))
    answers = [_answer(found, line) for case in order[:MOST] for line in by_case[case]]
    notices = [f"**{note}.**" for note in found.notes]
    if len(order) > MOST:
        notices.append(
            f"Above: of {len(order)} cases the {MOST} whose peak, frequency, damping or safety "
            "factor changes most."
        )
    count = len(found.inputs)
    differ = f"different: {counted(count, 'input')}" if count else "all inputs are the same"
    both = " against ".join(str(run.folder) for run in found.runs)
    notices.append(f"{both}: {differ}. Differences are those of the second run, over the first.")
    return [Answers(tuple(answers)), Text("\n\n".join(notices))]


def _answer(found: _Comparison, line: Line) -> Answer:
    one, other = (text or "-" for text in line.row[2:4])
    case = "" if line.of == "nominal" else f", {_words(line.of)}"
    note = ", ".join(f"{t} in {r.label}" for t, r in zip((one, other), found.runs, strict=True))
    value = f"{100 * line.change:+.3g} %" if line.change is not None else other
    return Answer(f"{CARDS[line.column.head]}{case}", value, note)


def _words(name: str) -> str:
    """A case's name, or those of two that differ."""
    return " | ".join(map(words, name.split(" | ")))


def _plot(found: _Comparison) -> Plot:
    curves = []
    for pair in found.pairs:
        group = _words(_called(*pair)) if len(found.pairs) > 1 else ""
        for run, case in zip(found.runs, pair, strict=True):
            curves.append(Curve(*case.line, group, variant=run.label))
    one, other = found.runs
    what = {run.monitor.name for run in found.runs} - {""}
    return curve_plot(
        curves,
        "Forced responses",
        f"Half the peak-to-peak of {' and '.join(sorted(what))}. Solid: {one.label}; dashed: "
        f"{other.label}; cases that belong together share a colour.",
    )
