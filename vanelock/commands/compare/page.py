"""The page on which two runs stand side by side."""

from collections.abc import Sequence
from dataclasses import replace

import vanelock
from vanelock.commands.compare.comparison import Comparison, Line
from vanelock.common.tables import Table, counted
from vanelock.input.cases.names import fixed, words
from vanelock.render import Curve
from vanelock.report import Answer, Answers, Page, Plot, Section, Text, curve_plot
from vanelock.report.blocks import Block
from vanelock.results.page_sections.models import written

CARDS = {
    "peak": "Peak",
    "peak frequency": "Frequency",
    "damping ratio by energy": "Damping ratio",
    "HCF safety factor": "HCF safety factor",
}
"""Results that stand on top."""
MOST = 2
"""Cases on top, those that change most."""


def compare_page(found: Comparison, tables: Sequence[Table]) -> Page:
    """Curves over one another, and tables of all that differs."""
    inputs, results, *others = tables
    rows = [(fixed(_words(str(name))), *rest) for name, *rest in results.rows]
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


def _summary(found: Comparison) -> list[Block]:
    lines = [line for line in found.results if line.what in CARDS]
    by_case = {line.of: [each for each in lines if each.of == line.of] for line in lines}
    order = sorted(by_case, key=lambda case: -_largest(by_case[case]))
    answers = [_answer(found, line) for case in order[:MOST] for line in by_case[case]]
    notices = [f"**{note}.**" for note in found.notes]
    if len(order) > MOST:
        notices.append(
            f"Above: of {len(order)} cases the {MOST} whose peak, frequency, damping or safety "
            "factor changes most."
        )
    count = len(found.inputs)
    notices.append(
        f"{found.one.folder} against {found.other.folder}: "
        + ("all inputs are the same." if not count else f"different: {counted(count, 'input')}.")
        + " Differences are those of the second run, over the first."
    )
    return [Answers(tuple(answers)), Text("\n\n".join(notices))]


def _largest(lines: "list[Line]") -> float:
    """The largest relative difference, either way; 0 where none is known."""
    return max((abs(line.change) for line in lines if line.change is not None), default=0.0)


def _answer(found: Comparison, line: Line) -> Answer:
    both = [line.text(value) or "-" for value in (line.one, line.other)]
    case = "" if line.of == "nominal" else f", {_words(line.of)}"
    change = "" if line.change is None else f"{100 * line.change:+.3g} %"
    note = f"{both[0]} in {found.one.label}, {both[1]} in {found.other.label}"
    return Answer(f"{CARDS[line.what]}{case}", change or both[1], note)


def _words(name: str) -> str:
    """A case's name, or those of two that differ."""
    return " | ".join(map(words, name.split(" | ")))


def _plot(found: Comparison) -> Plot:
    curves = []
    for pair in found.pairs:
        group = _words(pair.name) if len(found.pairs) > 1 else ""
        for run, case in ((found.one, pair.one), (found.other, pair.other)):
            curves.append(Curve(case.frequency, case.amplitude, group, variant=run.label))
    what = {found.one.monitor, found.other.monitor} - {""}
    return curve_plot(
        curves,
        "Forced responses",
        f"Half the peak-to-peak of {' and '.join(sorted(what))}. Solid: {found.one.label}; dashed: "
        f"{found.other.label}; cases that belong together share a colour.",
    )
