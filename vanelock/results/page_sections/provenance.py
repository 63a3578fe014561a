"""Where the numbers of a page come from: versions, date, the study file, hashes."""

import platform
from datetime import UTC, datetime

import vanelock
from vanelock.common.process.version import installed
from vanelock.common.tables import Cell, Table, heads
from vanelock.input.cases.names import words
from vanelock.report import Section, Text
from vanelock.report.blocks import Block
from vanelock.results.page_sections.content import PageContent
from vanelock.results.record import LIBRARIES


def provenance(content: PageContent) -> Section:
    """Versions, date, command, study file, and the hash of every response."""
    hashes: list[tuple[Cell, ...]] = [
        (words(each.case.name), each.response.key, each.system.key)
        for each in content.run_data.planned
    ]
    blocks: list[Block] = [
        Text(
            f"Written {written()} by `vanelock run`, from `results.h5` beside this page, which "
            "holds every mesh, reduced model and response with their units. The page shows the "
            "results of the file below and nothing else; it is written again when any of them "
            "changes. Terms are explained by `vanelock manual glossary`."
        ),
        Table("Versions", heads("program", "version"), versions()),
        Table(
            "Hashes of all inputs and code behind each response and system",
            heads("case", "response", "system"),
            hashes,
        ),
    ]
    if content.text.strip():
        lines = [(line,) for line in content.text.rstrip().splitlines()]
        blocks.append(Table("As it was given", heads("the file"), lines))
    return Section("Provenance", blocks, id="provenance")


def versions() -> list[tuple[Cell, ...]]:
    """Rows of programs and their versions."""
    return [
        ("vanelock", vanelock.__version__),
        ("python", platform.python_version()),
        ("system", f"{platform.system()} {platform.machine()}"),
        *((library, installed(library)) for library in LIBRARIES),
    ]


def written() -> str:
    """The date."""
    return datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
