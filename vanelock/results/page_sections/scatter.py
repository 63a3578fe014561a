"""Percentiles of the peaks on a run's page, where keys scatter."""

from vanelock.pipeline.tables import Table as Listed
from vanelock.quantities.scatter import percentile_table, sensitivity_table
from vanelock.report import Section, Table, Text
from vanelock.report.blocks import Block
from vanelock.results.page_sections.content import PageContent


def scatter(told: PageContent) -> Section:
    """How far the peaks scatter, and what with."""
    found = told.scattered
    blocks: list[Block] = []
    if found is not None:
        for each in (percentile_table(found, told.monitor), sensitivity_table(found)):
            blocks += [_table(each), Text(" ".join(map(_sentence, each.notes)))]
    return Section("Scatter", blocks, id="scatter")


def _sentence(note: str) -> str:
    return f"{note[:1].upper()}{note[1:]}."


def _table(listed: Listed) -> Table:
    """A terminal's table for the page: units under the heads, with its digits."""
    heads = [column.head.rstrip("]").partition(" [") for column in listed.columns]
    rows = [
        tuple(
            format(cell, column.form) if isinstance(cell, int | float) else cell or "-"
            for cell, column in zip(row, listed.columns, strict=True)
        )
        for row in listed.rows
    ]
    units = tuple(unit.replace("um", "µm") for _, _, unit in heads)
    return Table(tuple(head for head, _, _ in heads), rows, listed.title, units)
