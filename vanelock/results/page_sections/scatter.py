"""Percentiles of the peaks on a run's page, where keys scatter."""

from vanelock.quantities.scatter import percentile_table, sensitivity_table
from vanelock.report import Section
from vanelock.results.page_sections.content import PageContent


def scatter(content: PageContent) -> Section:
    """How far the peaks scatter, and what with."""
    found = content.scattered
    made = (
        ()
        if found is None
        else (percentile_table(found, content.monitor), sensitivity_table(found))
    )
    return Section("Scatter", made, id="scatter")
