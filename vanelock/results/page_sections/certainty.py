"""What the peaks are worth, on a run's page: scatter, bounds over static friction, stability."""

from vanelock.input.cases.names import words
from vanelock.quantities.scatter import percentile_table, sensitivity_table
from vanelock.report import Section, Text
from vanelock.report.blocks import Block
from vanelock.results.assessment import bounds_table, stability_table
from vanelock.results.page_sections.content import PageContent

BOUNDS = (
    "Contacts that stick throughout may carry any static friction within Coulomb's limit; it "
    "depends on assembly and load history, which the model does not know. It changes the load on "
    "the joints that slip, and so the peak. The curve assumes assembly without stress; the bounds "
    "are the lowest and the highest peak found over all admissible static friction."
)
STABILITY = (
    "A periodic solution need not be stable. Small disturbances of all nodal diameters are "
    "linearised about it, including the memory of friction (Floquet): where one grows, the ring "
    "leaves the periodic wave and its vibration is modulated; neither its largest amplitude nor "
    "its friction work is then that of the wave."
)


def scatter(content: PageContent) -> Section:
    """How far the peaks scatter, and what with, where keys scatter."""
    found = content.scattered
    made = (
        ()
        if found is None
        else (percentile_table(found, content.monitor), sensitivity_table(found))
    )
    return Section("Scatter", made, id="scatter")


def certainty(content: PageContent) -> Section:
    """Bounds and stability, where they are asked for."""
    blocks: list[Block] = []
    if any(each.found for each in content.bounds.values()):
        found = {words(name): each for name, each in content.bounds.items()}
        blocks += [Text(f"**Static friction.** {BOUNDS}"), bounds_table(found)]
    if content.stability:
        waves = {words(name): each for name, each in content.stability.items()}
        blocks += [Text(f"**Stability.** {STABILITY}"), stability_table(waves)]
    return Section("Bounds and stability", blocks, id="certainty")
