"""What the responses of a case are worth, where its file asks for it: steps and numbers."""

from dataclasses import replace

from vanelock.input.schema.assessment import assessable
from vanelock.stages.assessment.bounds import HIGH, LOW, Count, bounds_step
from vanelock.stages.assessment.stability import stability_step, verdict_at, whole_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.summary import Summary
from vanelock.stages.sweep.retries import Solved


def silent_count(done: int, total: int | None, amplitude: float) -> None:
    """Say nothing."""


def assessed(planned: Planned, first: Planned, count: Count) -> Planned:
    """A case with the steps of its bounds and stability.

    Parameters
    ----------
    planned : Planned
        The case.
    first : Planned
        The one whose linear response says which displacement is monitored.
    count : callable
        Called with how far each step is.
    """
    given = planned.case.given
    if not assessable(given.response):
        return planned
    if given.bounds is not None:
        planned = replace(planned, bounds=bounds_step(planned, first, count))
    if given.stability is not None:
        whole = whole_step(planned)
        steps = [stability_step(planned, first, whole, each, count) for each in planned.responses]
        planned = replace(planned, stability=tuple(steps))
    return planned


def with_assessment(found: Summary, solved: Solved) -> Summary:
    """A case in numbers, with its bounds and what becomes of its wave."""
    wave = None
    if solved.stability and found.peak is not None:
        wave = verdict_at(solved.stability[0], found.peak.frequency)
    if (bounds := solved.bounds) is None:
        return replace(found, wave=wave)
    return replace(found, lowest=bounds.peak(LOW), highest=bounds.peak(HIGH), wave=wave)
