"""What the peaks are worth, on a run's page: scatter, bounds over static friction, stability."""

from vanelock.input.cases.names import words
from vanelock.quantities.scatter import percentile_table, sensitivity_table
from vanelock.report import Section, Text
from vanelock.report.blocks import Block
from vanelock.results.assessment import bounds_table, stability_table
from vanelock.results.page_sections.content import PageContent

BOUNDS = (
    "Contacts that stick for good may hold any friction within Coulomb's limit: which, the way in "
    "which the parts were assembled and last loaded decides, and no model knows it. It loads the "
    "joints that slip, and so moves the peak. The curve assumes parts assembled without stress; "
    "looked for were the least and the largest peak that other static friction allows."
)
STABILITY = (
    "A periodic wave solves the equations; whether a ring that is disturbed comes back to it is "
    "another question. Small departures of all nodal diameters are followed, with the memory of "
    "friction: where one grows, the ring leaves the wave, and its vibration is then modulated: "
    "neither its largest amplitude nor its friction work is the wave's."
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
