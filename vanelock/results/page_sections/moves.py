"""What moves the peaks and how far they scatter, on a run's page."""

from vanelock.quantities.run_result import RunResult
from vanelock.quantities.scatter import percentile_table, sensitivity_table
from vanelock.quantities.sensitivities import sensitivities_table
from vanelock.report import Section, Text
from vanelock.report.blocks import Single

MOVES = (
    "By how many per cent the peak and its frequency move where one key grows by one per cent, all "
    "others held: the gradient of the solution at the peak, exact for small changes. Far from here "
    "it changes, and where contacts change their state it may jump."
)


def moves(run: RunResult) -> Section:
    """What moves the peak of each case that is looked into."""
    found: dict[str, list[Single]] = {}
    for name, each in run.answers.items():
        if (known := each.sensitivities) is not None:
            reason = Text(f"Not known: {known.reason}.")
            found[name] = [reason if known.reason else sensitivities_table(known)]
    blocks = [Text(MOVES), *run.of_cases(found)] if found else []
    return Section("What moves the peak", blocks, id="moves")


def scatter(run: RunResult) -> Section:
    """How far the peaks scatter, and what with, where keys scatter."""
    found = run.scattered
    made = (
        ()
        if found is None
        else (percentile_table(found, run.monitor.name), sensitivity_table(found))
    )
    return Section("Scatter", made, id="scatter")
