"""A case as tables, pictures and the page see it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from vanelock.input.cases.values import Given
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages
from vanelock.quantities.curves_and_fields import Drawn
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.summary import Peak, Summary

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis
    from vanelock.quantities.answers import CaseAnswers


class State(NamedTuple):
    """Another state of a case: its steps, the peak there, and the curve that it is of."""

    planned: Planned
    peak: Peak
    curve: Drawn


@dataclass(frozen=True)
class CaseResult:
    """What is known of a case; products are read when they are first asked for.

    Attributes
    ----------
    planned : Planned
        Its steps, as solved, the response with the higher peak first.
    stages : Stages
        Where their products are.
    monitor : Monitor
        The displacement in the curves.
    summary : Summary
        The case in numbers.
    answers : CaseAnswers or None
        Stresses, wear and energies at the peak, of a case that is looked into.
    """

    planned: Planned
    stages: Stages
    monitor: Monitor
    summary: Summary
    answers: "CaseAnswers | None" = None

    @property
    def name(self) -> str:
        """The case's name."""
        return self.planned.case.name

    @property
    def given(self) -> Given:
        """What its file says."""
        return self.planned.case.given

    @property
    def peak(self) -> Peak | None:
        """Its largest point; None where none converged."""
        return self.summary.peak

    @property
    def response(self) -> Response:
        """The response with the higher peak."""
        return self.stages.get(self.planned.response)

    def key_of(self, analysis: str) -> list[str]:
        """Hashes of what an analysis has found."""
        return [each.key for each in self.planned.analyses.get(analysis, ())]

    def found(self, analysis: str) -> list[Any]:
        """Products of an analysis by its key; none where it is not asked for."""
        return [self.stages.get(each) for each in self.planned.analyses.get(analysis, ())]

    def curve(self, response: Response) -> Drawn:
        """Frequencies, amplitudes and whether they converged, of a response."""
        return response.frequency, self.monitor.amplitude(response), response.converged


def case_result(
    analyses: "Sequence[Analysis[Any, Any]]",
    planned: Planned,
    stages: Stages,
    monitor: Monitor,
    summary: Summary,
) -> CaseResult:
    """A case whose summary has the numbers of its analyses."""
    result = CaseResult(planned, stages, monitor, summary)
    for analysis in analyses:
        if products := result.found(analysis.key):
            result = replace(result, summary=analysis.summarise(result.summary, products))
    return result
