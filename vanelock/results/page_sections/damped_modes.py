"""Damped modes and flutter on a run's page."""

from vanelock.input.cases.names import words
from vanelock.report import Section, Text
from vanelock.report.blocks import Block
from vanelock.results.assessment.damped_modes import damped_modes_table, flutter_table
from vanelock.results.figures.damped_modes import DAMPED
from vanelock.results.page_sections.content import PageContent

MODES = (
    "With friction a natural frequency and its damping ratio depend on the amplitude: contacts "
    "stick, slip and open. Each mode is the periodic motion that a force along its velocity keeps "
    "up against all damping (extended periodic motion concept), all harmonics and the mean "
    "included, without excitation."
)
FLUTTER = (
    "The air's work in a cycle is that of the given influence coefficients, in travelling waves of "
    "each nodal diameter, on the fundamental of one mode whose shape it does not change. Where it "
    "equals what structure and friction take, the ring vibrates by itself: it returns to a "
    "**limit cycle** after a small change; a kick beyond the last amplitude grows without end."
)


def damped_modes(content: PageContent) -> Section:
    """Tables and curves of damped modes, where they are asked for."""
    found = {words(name): each for name, each in content.assessments.items()}
    blocks: list[Block] = []
    if (table := damped_modes_table(found)) is not None:
        blocks += [Text(MODES), table]
    if (table := flutter_table(found)) is not None:
        blocks += [Text(FLUTTER), table]
    drawn = [each for each in content.pictures if each.title == DAMPED]
    blocks += content.of_cases({each.case: [each] for each in drawn})
    return Section("Damped modes", blocks, id="damped_modes")
