"""The page on which two runs stand side by side."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import vanelock
from vanelock.common.tables import Table
from vanelock.input.cases.names import fixed, words
from vanelock.report import Answer, Answers, Page, Plot, Section, Text, Trace
from vanelock.report.blocks import Block
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


def compare_page(found: "Comparison", tables: Sequence[Table]) -> Page:
    """Curves over one another, and tables of all that differs."""
    inputs, results, *others = tables
    rows = [(fixed(words(str(name))), *rest) for name, *rest in results.rows]
    return Page(
        f"{found.one.label} against {found.other.label}",
        f"Two runs side by side; vanelock {vanelock.__version__}, {written()}",
        [
            Section("Summary", _summary(found)),
            Section("Curves", [_plot(found)]),
            *(
                Section(each.title, [replace(each, title="")])
                for each in (inputs, replace(results, rows=rows), *others)
            ),
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
    both = [line.text(value) or "-" for value in (line.one, line.other)]
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
