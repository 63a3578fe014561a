"""The page of a run, report.html: its sections in order, written when what it shows changed."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import vanelock
from vanelock.common.files.digests import file_digest
from vanelock.input.cases.names import words
from vanelock.pipeline.cache import code_of
from vanelock.quantities.run_result import RunResult
from vanelock.report import OfCase, Page, Picture, Section, Text, write_page
from vanelock.report.blocks import Block, Single
from vanelock.results.files.redrawn import REPORT
from vanelock.results.page_sections.curves import loops
from vanelock.results.page_sections.errors import convergence
from vanelock.results.page_sections.fatigue import fatigue
from vanelock.results.page_sections.inputs import all_inputs, inputs
from vanelock.results.page_sections.models import models, provenance, written
from vanelock.results.page_sections.moves import moves, scatter
from vanelock.results.page_sections.summary import summary
from vanelock.results.page_sections.view import shapes
from vanelock.results.page_sections.wear import damping, wear

OPEN = ("summary", "scatter", "moves", "shapes")
"""Sections that are not folded, beside those of analyses: what most readers came for."""


def write_report(run: RunResult) -> Path:
    """Write the page of a run into its folder, unless it is there and shows the same already."""
    output_files = run.output_files
    return output_files.draw(REPORT, shown(run), lambda path: write_page(path, page(run)))


def page(run: RunResult) -> Page:
    """The page."""
    about = f"Friction-damped vibration; vanelock {vanelock.__version__}, {written()}"
    return Page(run.given.name, about, tuple(sections(run)))


def sections(run: RunResult) -> list[Section]:
    """All of its sections."""
    analysed = analyses(run)
    made = [
        summary(run),
        scatter(run),
        inputs(run.given, [each.case.given for each in run.planned]),
        moves(run),
        *analysed,
        shapes(run),
        loops(run),
        fatigue(run),
        damping(run),
        wear(run),
        pictures(run),
        convergence(run),
        models(run),
        provenance(run),
        all_inputs(run.given),
    ]
    shown = [section for section in made if section.blocks]
    return [replace(s, folded=s not in analysed and s.id not in OPEN) for s in shown]


def analyses(run: RunResult) -> list[Section]:
    """A section for each table of the input file that asks for analyses."""
    cases = {words(name): case for name, case in run.cases.items()}
    blocks: dict[str, list[Block]] = {}
    titles: dict[str, str] = {}
    for analysis in run.analyses:
        own = blocks.setdefault(table := analysis.table or analysis.key, [])
        titles.setdefault(table, analysis.title.capitalize())
        made: list[Block] = [*analysis.tables(cases)]
        made += _by_case(run, [e for e in run.pictures if e.section == analysis.key])
        own += [Text(analysis.text), *made] if made and analysis.text else made
    return [Section(titles[id], each, id=id) for id, each in blocks.items()]


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
            [
                e.case.name,
                *(step.key for step in (*e.responses, *e.analysed)),
                e.linear.key,
                e.system.key,
            ]
            for e in run.planned
        ],
        "failed": {name: each.reason for name, each in run.failed.items()},
        "answers": [found.key for found in run.answers.values()],
        "pictures": [
            [str(e.path.name), e.title, e.caption, file_digest(e.path)] for e in run.pictures
        ],
        "code": code_of("analyses", "results", "quantities", "report"),
    }
