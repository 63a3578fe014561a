"""The page on which two runs stand side by side."""

from typing import TYPE_CHECKING

import vanelock
from vanelock.commands.compare.load import Loaded
from vanelock.input.cases.names import fixed, words
from vanelock.input.settings import described
from vanelock.report import Answer, Answers, Page, Plot, Section, Table, Text, Trace
from vanelock.report.blocks import Block, Cell
from vanelock.results.page_sections.provenance import written

if TYPE_CHECKING:
    from vanelock.commands.compare.compare import Comparison, Line

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
CARDS = {
    "peak": "Peak",
    "peak frequency": "Frequency",
    "damping ratio, energy": "Damping ratio",
    "HCF reserve": "HCF reserve",
}
"""Results that stand on top."""
MOST = 2
"""Cases on top, those that change most."""


def compare_page(found: "Comparison") -> Page:
    """Curves over one another, and tables of all that differs."""
    one, other = found.one, found.other
    return Page(
        f"{one.label} against {other.label}",
        f"Two runs side by side; vanelock {vanelock.__version__}, {written()}",
        [
            Section("Summary", _summary(found)),
            Section("Curves", [_plot(found)]),
            Section("Inputs that differ", [_inputs(found)]),
            Section("Results", [_numbers(found, found.results, "case")]),
            Section("Models and times", [_numbers(found, found.sizes, "of")]),
            Section("Programs", [_programs(one, other)]),
        ],
    )


def _summary(found: "Comparison") -> list[Block]:
    lines = [line for line in found.results if line.what in CARDS]
    by_case = {line.of: [each for each in lines if each.of == line.of] for line in lines}
    order = sorted(by_case, key=lambda case: -_largest(by_case[case]))
    answers = [_answer(found, line) for case in order[:MOST] for line in by_case[case]]
    told = [f"**{note}.**" for note in found.notes]
    if len(order) > MOST:
        told.append(
            f"Above: of {len(order)} cases the {MOST} whose peak, frequency, damping or reserve "
            "changes most."
        )
    count = len(found.inputs)
    told.append(
        f"{found.one.folder} against {found.other.folder}: "
        + ("all inputs are the same." if not count else f"{count} inputs differ.")
        + " Differences are those of the second run, over the first."
    )
    return [Answers(tuple(answers)), Text("\n\n".join(told))]


def _largest(lines: "list[Line]") -> float:
    """The largest relative difference, either way; 0 where none is known."""
    return max((abs(line.change) for line in lines if line.change is not None), default=0.0)


def _answer(found: "Comparison", line: "Line") -> Answer:
    both = [
        "-" if v is None else f"{v:{line.form}} {line.unit}".rstrip()
        for v in (line.one, line.other)
    ]
    case = "" if line.of == "nominal" else f", {words(line.of)}"
    change = "" if line.change is None else f"{100 * line.change:+.3g} %"
    note = f"{both[0]} in {found.one.label}, {both[1]} in {found.other.label}"
    return Answer(f"{CARDS[line.what]}{case}", change or both[1], note)


def _plot(found: "Comparison") -> Plot:
    traces = []
    for i, pair in enumerate(found.pairs):
        colour = COLOURS[i % len(COLOURS)]
        for run, case, dash in ((found.one, pair.one, "solid"), (found.other, pair.other, "dash")):
            name = run.label if case.name == "nominal" else f"{run.label}: {words(case.name)}"
            traces.append(
                Trace(
                    case.frequency,
                    1e6 * case.amplitude,
                    name,
                    dash="dash" if dash == "dash" else "solid",
                    colour=colour,
                )
            )
    what = {found.one.monitor, found.other.monitor} - {""}
    return Plot(
        traces,
        "frequency (Hz)",
        "amplitude (µm)",
        "Forced responses",
        f"Half the peak-to-peak of {' and '.join(sorted(what))}. Solid: {found.one.label}; dashed: "
        f"{found.other.label}; cases that belong together share a colour.",
    )


def _inputs(found: "Comparison") -> Table:
    rows: list[tuple[Cell, ...]] = [
        (key, described(key)[0], one, other) for key, one, other in found.inputs
    ]
    header = ("key", "what it is", found.one.label, found.other.label)
    return Table(header, rows, "Inputs that differ, defaults included")


def _numbers(found: "Comparison", lines: "list[Line]", of: str) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (
            fixed(words(line.of)) if of == "case" else line.of,
            line.what,
            _cell(line.one, line.form),
            _cell(line.other, line.form),
            line.unit,
            None if line.change is None else round(100 * line.change, 3),
        )
        for line in lines
    ]
    header = (of, "what", found.one.label, found.other.label, "unit", "difference")
    return Table(header, rows, units=("", "", "", "", "", "%"))


def _cell(value: float | None, form: str) -> Cell:
    if value is None:
        return None
    return round(value) if form.endswith(".0f") else value


def _programs(one: Loaded, other: Loaded) -> Table:
    rows: list[tuple[Cell, ...]] = [
        ("folder", str(one.folder), str(other.folder)),
        ("date", one.date, other.date),
        ("complete", *("yes" if run.complete else "NO" for run in (one, other))),
    ]
    for name in dict.fromkeys([*one.versions, *other.versions]):
        rows.append((name, one.versions.get(name), other.versions.get(name)))
    return Table(("", one.label, other.label), rows, "Where the numbers come from")
