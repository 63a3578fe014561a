"""The page of a run, report.html: its sections in order, written when what it shows changed."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import vanelock
from vanelock.common.files.digests import file_digest
from vanelock.input.cases.names import words
from vanelock.pipeline.cache import code_of
from vanelock.quantities.run_result import RunResult
from vanelock.report import OfCase, Page, Picture, Section, Text, write_page
from vanelock.report.blocks import Block, Single
from vanelock.results.figures.pictures import draw
from vanelock.results.files.redrawn import REPORT
from vanelock.results.page_sections.curves import loops
from vanelock.results.page_sections.errors import convergence
from vanelock.results.page_sections.inputs import all_inputs, inputs
from vanelock.results.page_sections.models import begun, models, provenance
from vanelock.results.page_sections.summary import summary
from vanelock.results.page_sections.view import shapes

OPEN = ("summary", "shapes")
"""Sections that are not folded, beside those of analyses: what most readers came for."""


def show(run: RunResult) -> None:
    """Draw the pictures of a run and write its page, unless they show the same already."""
    draw(run)
    if "report" in run.given.outputs.show:
        run.output_files.draw(REPORT, shown(run), lambda path: write_page(path, page(run)))


def page(run: RunResult) -> Page:
    """The page."""
    about = f"Friction-damped vibration; vanelock {vanelock.__version__}, {begun(run)}"
    return Page(run.given.name, about, tuple(_sections(run)))


def _sections(run: RunResult) -> list[Section]:
    """All of its sections."""
    analysed = _analyses(run)
    made = [
        summary(run),
        inputs(run.given, [each.given for each in run.cases.values()]),
        *(section for section in analysed if not section.folded),
        shapes(run),
        loops(run),
        *(section for section in analysed if section.folded),
        pictures(run),
        convergence(run),
        models(run),
        provenance(run),
        all_inputs(run.given),
    ]
    shown = [section for section in made if section.blocks]
    return [s if s in analysed else replace(s, folded=s.id not in OPEN) for s in shown]


def _analyses(run: RunResult) -> list[Section]:
    """A section for each table that asks for analyses, and for each that needs none."""
    cases = {words(name): case for name, case in run.cases.items()}
    blocks: dict[str, list[Block]] = {}
    heads: dict[str, tuple[str, bool]] = {}
    for analysis in run.analyses:
        own = blocks.setdefault(table := analysis.table or analysis.key, [])
        heads.setdefault(table, (analysis.title.capitalize(), not analysis.open))
        if analysis.page is not None:
            own += analysis.page(run)
            continue
        made: list[Block] = [*analysis.tables(cases)]
        made += _by_case(run, [e for e in run.pictures if e.section == analysis.key])
        own += [Text(analysis.text), *made] if made and analysis.text else made
    return [
        Section(title, blocks[id], id=id, folded=folded) for id, (title, folded) in heads.items()
    ]


def _by_case(run: RunResult, pictures: Sequence[Picture]) -> list[OfCase]:
    return run.of_cases({each.case: [each] for each in pictures})


def pictures(run: RunResult) -> Section:
    """The run's figures that no other section shows, those of the chosen case last."""
    shown = [each for each in run.pictures if not each.section]
    own: dict[str, list[Single]] = {}
    for each in shown:
        if each.case:
            own.setdefault(each.case, []).append(each)
    shared = [each for each in shown if not each.case]
    return Section("Figures", [*shared, *run.of_cases(own)], id="figures")


def shown(run: RunResult) -> Any:
    """All that the page depends on, but for the date; as JSON can hold it."""
    return {
        "study": run.given.model_dump(mode="json"),
        "text": run.text,
        "cases": [
            [name, *each.solved_keys, each.linear_key, each.key_at("system")]
            for name, each in run.cases.items()
        ],
        "failed": {name: each.reason for name, each in run.failed.items()},
        "answers": [each.key for each in run.looked_into.values()],
        "pictures": [
            [str(e.path.name), e.title, e.caption, file_digest(e.path)] for e in run.pictures
        ],
        "code": code_of("analyses", "results", "quantities", "report"),
    }
