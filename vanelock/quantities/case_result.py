"""A case as tables, pictures and the page see it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vanelock.input.cases.values import Given
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages
from vanelock.quantities.run_result import Drawn
from vanelock.stages.accuracy.errors import Errors
from vanelock.stages.accuracy.left_out import LeftOut
from vanelock.stages.campbell.campbell import Campbell
from vanelock.stages.parts.gauges import Strain
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.solved import drawn
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
    """What is known of a case; products are read when they are asked for.

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
    curves : dict of str to (frequency, amplitude, converged)
        Its responses by direction, "" where there is but one; the higher one first.
    ends : tuple of curve
        Between which it may lie.
    verdicts : dict of str to (p,) int
        Of the points of each curve, STABLE, UNSTABLE, UNDECIDED, or -1 where nothing is known.
    strain : Strain or None
        What gauges read.
    errors : (Errors, list of LeftOut) or None
        Estimated errors, with an accuracy.
    campbell : Campbell or None
        Its Campbell diagram, unless another case has the same.
    answers : CaseAnswers or None
        Stresses, wear and energies at the peak, of a case that is looked into.
    """

    planned: Planned
    stages: Stages
    monitor: Monitor
    summary: Summary
    curves: Mapping[str, Drawn] = field(default_factory=dict)
    ends: tuple[Drawn, ...] = ()
    verdicts: Mapping[str, NDArray[np.int64]] = field(default_factory=dict)
    strain: Strain | None = None
    errors: tuple[Errors, Sequence[LeftOut]] | None = None
    campbell: Campbell | None = None
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
    def static(self) -> Response:
        """Its state at rest."""
        return self.stages.get(self.planned.preload)

    @property
    def responses(self) -> list[Response]:
        """Its responses, that with the higher peak first."""
        return [self.stages.get(each) for each in self.planned.responses]

    @property
    def drawn(self) -> Drawn:
        """The curve of the first of them."""
        return next(iter(self.curves.values()))

    def key_of(self, analysis: str) -> list[str]:
        """Hashes of what an analysis has found."""
        return [each.key for each in self.planned.analyses.get(analysis, ())]

    def found(self, analysis: str) -> list[Any]:
        """Products of an analysis by its key; none where it is not asked for."""
        return [self.stages.get(each) for each in self.planned.analyses.get(analysis, ())]

    def curve(self, response: Response) -> Drawn:
        """Frequencies, amplitudes and whether they converged, of a response."""
        return response.frequency, self.monitor.amplitude(response), response.converged


def with_curves(case: CaseResult, analyses: "Sequence[Analysis[Any, Any]]") -> CaseResult:
    """A case with its curves, and what its analyses have to say of them and of its summary."""
    responses = case.responses
    made = [case.curve(each) for each in responses]
    if case.given.response.frequencies is None:
        made[0] = drawn(responses[0], made[0][1])
    names = [""]
    if len(responses) > 1:
        names = [f"sweeping {each.direction or 'up'}" for each in responses]
    case = replace(case, curves=dict(zip(names, made, strict=True)))
    for analysis in analyses:
        if not (products := case.found(analysis.key)):
            continue
        case = replace(case, summary=analysis.summarise(case.summary, products))
        lines = analysis.lines(products)
        if lines.ends:
            case = replace(case, ends=tuple(map(case.curve, lines.ends)))
        if lines.verdicts:
            verdicts = {
                name: np.array([known.get(f, -1) for f in curve[0].tolist()])
                for (name, curve), known in zip(case.curves.items(), lines.verdicts, strict=False)
            }
            case = replace(case, verdicts=verdicts)
    return case
