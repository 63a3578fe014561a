"""The page of a run, report.html: its sections in order, written when what it shows changed."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import vanelock
from vanelock.common.files.digests import file_digest
from vanelock.input.cases.names import words
from vanelock.pipeline.cache import code_of
from vanelock.report import OfCase, Page, Picture, Section, Text, write_page
from vanelock.report.blocks import Block, Single
from vanelock.results.files.redrawn import REPORT
from vanelock.results.page_sections.content import PageContent
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


def write_report(content: PageContent) -> Path:
    """Write the page of a run into its folder, unless it is there and shows the same already."""
    output_files = content.run_data.output_files
    return output_files.draw(REPORT, shown(content), lambda path: write_page(path, page(content)))


def page(content: PageContent) -> Page:
    """The page."""
    about = f"Friction-damped vibration; vanelock {vanelock.__version__}, {written()}"
    return Page(content.run_data.given.name, about, tuple(sections(content)))


def sections(content: PageContent) -> list[Section]:
    """All of its sections."""
    analysed = analyses(content)
    made = [
        summary(content),
        scatter(content),
        inputs(content.run_data.given, [each.case.given for each in content.run_data.planned]),
        moves(content),
        *analysed,
        shapes(content),
        loops(content),
        fatigue(content),
        damping(content),
        wear(content),
        pictures(content),
        convergence(content),
        models(content),
        provenance(content),
        all_inputs(content.run_data.given),
    ]
    shown = [section for section in made if section.blocks]
    return [replace(s, folded=s not in analysed and s.id not in OPEN) for s in shown]


def analyses(content: PageContent) -> list[Section]:
    """A section for each table of the input file that asks for analyses."""
    cases = {words(name): case for name, case in content.results.items()}
    blocks: dict[str, list[Block]] = {}
    titles: dict[str, str] = {}
    for analysis in content.run_data.analyses:
        own = blocks.setdefault(table := analysis.table or analysis.key, [])
        titles.setdefault(table, analysis.title.capitalize())
        made: list[Block] = [*analysis.tables(cases)]
        made += _by_case(content, [e for e in content.pictures if e.section == analysis.key])
        own += [Text(analysis.text), *made] if made and analysis.text else made
    return [Section(titles[id], each, id=id) for id, each in blocks.items()]


def _by_case(content: PageContent, pictures: Sequence[Picture]) -> list[OfCase]:
    return content.of_cases({each.case: [each] for each in pictures})


def pictures(content: PageContent) -> Section:
    """The run's figures that no other section shows, those of the chosen case last."""
    shown = [each for each in content.pictures if not each.section]
    own: dict[str, list[Single]] = {}
    for each in shown:
        if each.case:
            own.setdefault(each.case, []).append(each)
    shared = [each for each in shown if not each.case]
    return Section("Figures", [*shared, *content.of_cases(own)], id="figures")


def shown(content: PageContent) -> Any:
    """All that the page depends on, but for the date; as JSON can hold it."""
    run_data = content.run_data
    return {
        "study": run_data.given.model_dump(mode="json"),
        "text": content.text,
        "cases": [
            [
                e.case.name,
                *(step.key for step in (*e.responses, *e.analysed)),
                e.linear.key,
                e.system.key,
            ]
            for e in run_data.planned
        ],
        "failed": {name: each.reason for name, each in content.failed.items()},
        "answers": [found.key for found in content.answers.values()],
        "pictures": [
            [str(e.path.name), e.title, e.caption, file_digest(e.path)] for e in content.pictures
        ],
        "code": code_of("analyses", "results", "quantities", "report"),
    }
