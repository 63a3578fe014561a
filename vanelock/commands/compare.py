"""`vanelock compare`: two runs side by side, as tables and a page."""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import vanelock
from vanelock.commands.stored.contents import StoredRun, load_run
from vanelock.common.errors import InputError
from vanelock.common.tables import Cell, Column, Table, counted, heads
from vanelock.input.cases.names import words
from vanelock.input.settings import as_text, flattened, same
from vanelock.pipeline.progress import Listener, Notice, silent
from vanelock.quantities.case_result import CaseResult
from vanelock.render import Curve
from vanelock.report import Page, Plot, Section, Text, curve_plot, write_page
from vanelock.results.listing import CASE_COLUMNS, case_row

PAGE = "compare.html"
_Pair = tuple[CaseResult, CaseResult]


def compare_runs(
    one: str | os.PathLike[str],
    other: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    listener: Listener = silent,
) -> tuple[Table, Table]:
    """Compare two runs: tables for the listener, and compare.html in a folder.

    Parameters
    ----------
    one, other : path
        The runs' folders.
    output : path, optional
        Where the page goes; by default `compare_<one>_<other>` in the current folder.
    listener : callable
        Called with notes on what cannot be compared, and with the tables.

    Returns
    -------
    tuple of Table
        Inputs that differ, and the numbers of cases that belong together.

    Raises
    ------
    InputError
        If a folder holds no results, both are the same, or the output would go into one of them.
    """
    folders = Path(one), Path(other)
    runs = [load_run(folder) for folder in folders]
    if runs[0].label == runs[1].label:
        for run, folder in zip(runs, folders, strict=True):
            run.label = "-".join(folder.resolve().parts[-2:])
    labels = [run.label for run in runs]
    if folders[0].resolve() == folders[1].resolve():
        raise InputError(f"{folders[1]}: the same folder as {folders[0]}: nothing to compare")
    target = Path(f"compare_{labels[0]}_{labels[1]}" if output is None else output)
    for folder in folders:
        if target.resolve().is_relative_to(folder.resolve()):
            raise InputError(
                f"--output {target}: lies in the run's folder {folder}; name one outside of it"
            )
    notes, inputs, results, plot = compared(*runs)
    for note in notes:
        listener(Notice(note))
    listener(inputs)
    listener(results)
    said = Text("\n\n".join(f"**{note}.**" for note in notes))
    subtitle = f"Two runs side by side; vanelock {vanelock.__version__}"
    sections = [Section("Comparison", [said, plot, inputs, results])]
    page = write_page(target / PAGE, Page(" against ".join(labels), subtitle, sections))
    listener(Notice(f"{page} written"))
    return inputs, results


def compared(one: StoredRun, other: StoredRun) -> tuple[list[str], Table, Table, Plot]:
    """What cannot be compared, a line each; inputs that differ, numbers and curves of pairs."""
    pairs, alone = matched(one, other)
    notes = [
        f"{run.folder}: the run is not complete; compared: {counted(len(run.cases), 'case')}"
        for run in (one, other)
        if not run.complete
    ]
    watched = one.monitor.name, other.monitor.name
    if all(watched) and watched[0] != watched[1]:
        both = f"{watched[0]} in {one.label}, {watched[1]} in {other.label}"
        notes.append(f"amplitudes are of different displacements: {both}")
    settings = [flattened(run.settings) for run in (one, other)]
    inputs = [
        (key, *(as_text(key, of[key]) if key in of else "-" for of in settings))
        for key in settings[0] | settings[1]
        if not same(settings[0].get(key), settings[1].get(key))
    ]
    title = "Inputs that differ, defaults included" if inputs else "Inputs: all the same"
    labels = one.label, other.label
    columns = (*heads("of", "what", *labels), Column("difference", key="change"))
    curves = [
        Curve(*case.line, _called(pair, words) if len(pairs) > 1 else "", variant=label)
        for pair in pairs
        for label, case in zip(labels, pair, strict=True)
    ]
    plot = curve_plot(
        curves,
        "Forced responses",
        f"Half the peak-to-peak of {' and '.join(sorted({*watched} - {''}))}. Solid: {one.label}; "
        f"dashed: {other.label}; cases that belong together share a colour.",
    )
    return (
        [*notes, *alone],
        Table(title, heads("key", *labels), inputs, key="inputs"),
        Table("Results", columns, [row for pair in pairs for row in _rows(pair)], key="results"),
        plot,
    )


def matched(one: StoredRun, other: StoredRun) -> tuple[Sequence[_Pair], list[str]]:
    """Cases that belong together: by name, else by the values they share, else by their order.

    And a note on each that has no namesake.
    """
    pairs = [(case, other.cases[name]) for name, case in one.cases.items() if name in other.cases]
    left = [case for name, case in one.cases.items() if name not in other.cases]
    right = [case for name, case in other.cases.items() if name not in one.cases]
    notes = []
    for how in ("values", "order"):
        for case in list(left):
            alike = [each for each in right if how == "order" or _agree(case, each)]
            if len(alike) == 1 or (alike and how == "order"):
                pairs.append((case, alike[0]))
                left.remove(case)
                right.remove(alike[0])
                text = f"{case.name} in {one.label} is compared with {alike[0].name}"
                notes.append(f"{text} in {other.label}, by {how}")
    for run, alone in (one, left), (other, right):
        notes += [f"{case.name} is in {run.label} alone" for case in alone]
    return pairs, notes


def _agree(one: CaseResult, other: CaseResult) -> bool:
    """Whether cases share swept keys and have the same values of all that they share."""
    shared = one.values.keys() & other.values.keys()
    return bool(shared) and all(same(one.values[key], other.values[key]) for key in shared)


def _called(pair: _Pair, name: Callable[[str], str] = str) -> str:
    """What tables and curves call a pair."""
    return " | ".join(dict.fromkeys(name(case.name) for case in pair))


def _rows(pair: _Pair) -> Iterator[tuple[Cell, ...]]:
    """The numbers of a pair of cases, and how far, in per cent, the second is off the first."""
    a, b = (case_row(case.summary, case.numbers) for case in pair)
    for column in CASE_COLUMNS[1:]:
        one, other = column.shown(a[column.name]), column.shown(b[column.name])
        if one is other is None:
            continue
        change = "same" if one == other else ""
        if not change and isinstance(one, float) and isinstance(other, float) and one:
            change = f"{100 * (other / one - 1):+.3g} %"
        unit = f" {column.unit}".rstrip()
        both = (None if v is None else column.text(v) + unit for v in (one, other))
        yield _called(pair), column.head, *both, change
