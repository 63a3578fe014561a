"""All tables of what responses are worth and of what follows from them."""

from collections.abc import Iterator, Mapping

from vanelock.common.tables import Table
from vanelock.results.assessment.damped_modes import damped_modes_table, flutter_table
from vanelock.results.assessment.peaks import (
    bounds_table,
    settled_table,
    stability_table,
    unlike_table,
)
from vanelock.results.assessment.wear import wear_table
from vanelock.stages.assessment.assessed import Assessment


def assessment_tables(found: Mapping[str, Assessment]) -> Iterator[Table]:
    """Those that there is something for."""
    of_peaks = bounds_table, stability_table, settled_table, unlike_table
    made = (*of_peaks, damped_modes_table, flutter_table, wear_table)
    return (table for each in made if (table := each(found)) is not None)
