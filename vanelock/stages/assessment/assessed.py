"""What the responses of a case are worth, where its file asks for it: steps and numbers."""

from dataclasses import dataclass, replace

from vanelock.input.schema.assessment.checks import assessable
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Stability
from vanelock.pipeline.step import Stages
from vanelock.stages.assessment.bounds import HIGH, LOW, BoundedPeak, Count, bounds_step
from vanelock.stages.assessment.damped_modes import FollowedMode, damped_mode_steps
from vanelock.stages.assessment.settled import FollowedPeak, settled_step
from vanelock.stages.assessment.stability import stability_step, verdict_at, whole_step
from vanelock.stages.assessment.unlike import UnlikeRings, unlike_step
from vanelock.stages.assessment.wear import WornCase, wear_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.summary import Summary


@dataclass(frozen=True)
class Assessment:
    """What the responses of a case are worth, as far as its file asks for it.

    Attributes
    ----------
    bounds : BoundedPeak or None
        Bounds of the peak over static friction.
    stability : tuple of Stability
        Of its responses, that of the higher peak first.
    settled : tuple of FollowedPeak
        What the ring does at the peaks of these responses, where it is followed.
    unlike : UnlikeRings or None
        Rings of unlike segments.
    damped_modes : tuple of FollowedMode
    wear : WornCase or None
        Wear over cycles.
    """

    bounds: BoundedPeak | None = None
    stability: tuple[Stability, ...] = ()
    settled: tuple[FollowedPeak, ...] = ()
    unlike: UnlikeRings | None = None
    damped_modes: tuple[FollowedMode, ...] = ()
    wear: WornCase | None = None

    def shortened(self) -> "Assessment":
        """The same without what only curves and files show."""
        return replace(self, bounds=self.bounds and self.bounds.shortened())


def silent_count(done: int, total: int | None, amplitude: float) -> None:
    """Say nothing."""


def assessed(planned: Planned, first: Planned, count: Count) -> Planned:
    """A case with the steps of all that its file asks for beyond its responses."""
    given = planned.case.given
    if not assessable(given.response):
        return planned
    if given.bounds is not None:
        planned = replace(planned, bounds=bounds_step(planned, first, count))
    if given.stability is not None:
        whole = whole_step(planned)
        steps = [stability_step(planned, first, whole, each, count) for each in planned.responses]
        planned = replace(planned, stability=tuple(steps))
        if given.stability.follow:
            followed = tuple(
                settled_step(planned, first, whole, response, stability, count)
                for response, stability in zip(planned.responses, steps, strict=True)
            )
            planned = replace(planned, settled=followed)
    if given.unlike is not None:
        unlike, rings = unlike_step(planned, first, whole_step(planned), count)
        planned = replace(planned, unlike=unlike, rings=rings)
    if isinstance(given, Study):
        planned = _of_a_study(planned, given, first, count)
    return planned


def _of_a_study(planned: Planned, study: Study, first: Planned, count: Count) -> Planned:
    """A case with the steps that a study alone has."""
    if study.damped_modes is not None:
        steps = tuple(damped_mode_steps(planned, first, whole_step(planned), count))
        planned = replace(planned, damped_modes=steps)
    if study.wear is not None:
        planned = replace(planned, wear=wear_step(planned, first, count))
    return planned


def assessment_of(planned: Planned, stages: Stages) -> Assessment:
    """The products of those steps."""
    return Assessment(
        bounds=None if planned.bounds is None else stages.get(planned.bounds),
        stability=tuple(map(stages.get, planned.stability)),
        settled=tuple(map(stages.get, planned.settled)),
        unlike=None if planned.unlike is None else stages.get(planned.unlike),
        damped_modes=tuple(map(stages.get, planned.damped_modes)),
        wear=None if planned.wear is None else stages.get(planned.wear),
    )


def with_assessment(found: Summary, assessment: Assessment) -> Summary:
    """A case in numbers, with its bounds and what becomes of its wave."""
    wave = None
    if assessment.stability and found.peak is not None:
        wave = verdict_at(assessment.stability[0], found.peak.frequency)
    if wave is not None and assessment.settled:
        wave = replace(wave, settled=assessment.settled[0].settled)
    if (bounds := assessment.bounds) is None:
        return replace(found, wave=wave)
    return replace(found, lowest=bounds.peak(LOW), highest=bounds.peak(HIGH), wave=wave)
