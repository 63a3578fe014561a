"""What the peaks are worth, on a run's page: what moves them, scatter, bounds, stability."""

from vanelock.input.cases.names import words
from vanelock.quantities.scatter import percentile_table, sensitivity_table
from vanelock.quantities.sensitivities import sensitivities_table
from vanelock.report import Section, Text
from vanelock.report.blocks import Block, Single
from vanelock.results.assessment.peaks import (
    bounds_table,
    settled_table,
    stability_table,
    unlike_table,
)
from vanelock.results.figures.scatter import RINGS
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
UNLIKE = (
    "The segments of a real ring differ, and one of them vibrates more than all would if they were "
    "alike. The balances of all segments are solved together, for every ring drawn; whether these "
    "solutions are stable is not decided."
)


MOVES = (
    "By how many per cent the peak and its frequency move where one key grows by one per cent, all "
    "others held: the gradient of the solution at the peak, exact for small changes. Far from here "
    "it changes, and where contacts change their state it may jump."
)


def moves(content: PageContent) -> Section:
    """What moves the peak of each case that is looked into."""
    found: dict[str, list[Single]] = {}
    for name, each in content.answers.items():
        if (known := each.sensitivities) is not None:
            reason = Text(f"Not known: {known.reason}.")
            found[name] = [reason if known.reason else sensitivities_table(known)]
    blocks = [Text(MOVES), *content.of_cases(found)] if found else []
    return Section("What moves the peak", blocks, id="moves")


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
    """Bounds, stability and unlike segments, where they are asked for."""
    blocks: list[Block] = []
    found = {words(name): each for name, each in content.assessments.items()}
    for what, text, table in (
        ("Static friction", BOUNDS, bounds_table(found)),
        ("Stability", STABILITY, stability_table(found)),
        ("Unlike segments", UNLIKE, unlike_table(found)),
    ):
        if table is not None:
            blocks += [Text(f"**{what}.** {text}"), table]
        if what == "Stability" and (followed := settled_table(found)) is not None:
            blocks.append(followed)
    rings = [each for each in content.pictures if each.title == RINGS]
    blocks += content.of_cases({each.case: [each] for each in rings})
    title = "Bounds, stability, unlike segments" if rings else "Bounds and stability"
    return Section(title, blocks, id="certainty")
