"""What the page of a run is written from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from vanelock.input.cases.names import words
from vanelock.pipeline.executor.tasks import Failure
from vanelock.quantities.answers import CaseAnswers
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.contacts.energy import EnergyBalance
from vanelock.quantities.curves_and_fields import RunData
from vanelock.quantities.scatter import Scattered
from vanelock.quantities.selection import lowest_first
from vanelock.report import OfCase, Picture
from vanelock.report.blocks import Single
from vanelock.stages.accuracy.errors import Errors
from vanelock.stages.accuracy.left_out import LeftOut
from vanelock.stages.parts.gauges import Strain
from vanelock.stages.response.summary import Peak, Summary


@dataclass(frozen=True)
class PageContent:
    """A run's objects, for the sections of its page.

    Attributes
    ----------
    run_data : RunData
        Study, cases, stages, curves and where files go.
    summaries : sequence of Summary
        One for each case.
    pictures : sequence of Picture
        Pictures in their order.
    answers : dict of str to CaseAnswers
        Of the cases that are looked into.
    wear : dict of str to Path
        CSV files of their contacts.
    strains : dict of str to (Strain, Peak)
        What gauges read, by case.
    worth : dict of str to (Errors, list of LeftOut)
        Estimated errors, by case, where an accuracy is asked for.
    results : dict of str to CaseResult
        What is known of each case, with its answers.
    linear : dict of str to dict of "free" | "stuck" to Peak or None
        Linear peaks by the name of their limits, "" where cases share them.
    text : str
        The study file.
    balances : dict of str to EnergyBalance
        Energies at the peak, of all cases unless there are many.
    failed : dict of str to Failure
        Cases that could not be computed.
    scattered : Scattered or None
        Percentiles of the peaks, where keys scatter.
    """

    run_data: RunData
    summaries: Sequence[Summary]
    pictures: Sequence[Picture]
    answers: Mapping[str, CaseAnswers]
    wear: Mapping[str, Path] = field(default_factory=dict)
    strains: Mapping[str, tuple[Strain, Peak]] = field(default_factory=dict)
    worth: Mapping[str, tuple[Errors, Sequence[LeftOut]]] = field(default_factory=dict)
    results: Mapping[str, CaseResult] = field(default_factory=dict)
    linear: Mapping[str, Mapping[str, Peak | None]] = field(default_factory=dict)
    text: str = ""
    balances: Mapping[str, EnergyBalance] = field(default_factory=dict)
    failed: Mapping[str, Failure] = field(default_factory=dict)
    scattered: Scattered | None = None

    @property
    def monitor(self) -> str:
        """The displacement in the curves."""
        return self.run_data.shown.monitor.name

    @property
    def known(self) -> list[Summary]:
        """Cases with a peak."""
        return [each for each in self.summaries if each.peak is not None]

    @property
    def largest(self) -> Summary | None:
        """The case with the largest peak."""
        found = {each.case: each for each in self.known}
        order = lowest_first({name: each.peak for name, each in found.items() if each.peak})
        return found[order[-1]] if order else None

    def of_cases(self, blocks: Mapping[str, Sequence[Single]]) -> list[OfCase]:
        """Blocks of cases for their reader to choose from, that of the largest peak first."""
        most = self.largest
        names = sorted(blocks, key=lambda name: most is None or name != most.case)
        return [OfCase(words(name), blocks[name]) for name in names if blocks[name]]

    @property
    def main(self) -> CaseAnswers | None:
        """Answers of that case."""
        return None if self.largest is None else self.answers.get(self.largest.case)
