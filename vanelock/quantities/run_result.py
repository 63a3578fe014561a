"""A run as tables, pictures and the page see it: its cases, their products, and where files go."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock import rom
from vanelock.common.files.csv_table import write_columns
from vanelock.common.process.memory import latest
from vanelock.input.cases.names import words
from vanelock.input.cases.values import Given
from vanelock.input.measured.curve import Measured
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages
from vanelock.pipeline.tasks import Failure
from vanelock.quantities.scatter import Scattered
from vanelock.report import OfCase, Picture
from vanelock.report.blocks import Single
from vanelock.results.files.redrawn import OutputFiles
from vanelock.stages.accuracy.errors import Errors
from vanelock.stages.accuracy.left_out import LeftOut
from vanelock.stages.parts.components import PARTS, recovery_step
from vanelock.stages.parts.gauges import Strain
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.responses import Limit
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import Peak, Summary

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis
    from vanelock.quantities.answers import CaseAnswers
    from vanelock.quantities.case_result import CaseResult
    from vanelock.quantities.contacts.energy import EnergyBalance

Floats = NDArray[np.float64]
Shape = NDArray[np.complex128]
Drawn: TypeAlias = tuple[Floats, Floats, NDArray[np.bool_]]


@dataclass
class RunResult:
    """A run; whole products are read again where they are needed, since cases may be many.

    Attributes
    ----------
    given : Study or Scene
    stages : Stages
        Where products are.
    monitor : Monitor
        The displacement in the curves.
    output_files : OutputFiles
        Where pictures and tables go.
    analyses : sequence of Analysis
        All that there are.
    opens : str
        What opens in the free limit, in words; "" where nothing does.
    measured : tuple of Measured
        Measured curves.
    text : str
        The file's text.
    cases : dict of str to CaseResult
        Those that are solved, in their order.
    failed : dict of str to Failure
        Those that could not be computed.
    limits : dict of (name, "free" | "stuck") to (frequency, amplitude)
        Linear responses; without "stuck" where no contacts open in the free limit.
    scattered : Scattered or None
        Percentiles of the peaks, where keys scatter.
    pictures : list of Picture
        In their order.
    wear : dict of str to Path
        CSV files of the contacts of cases.
    """

    given: Given
    stages: Stages
    monitor: Monitor
    output_files: OutputFiles
    analyses: "Sequence[Analysis[Any, Any]]" = ()
    opens: str = "all contacts"
    measured: tuple[Measured, ...] = ()
    text: str = ""
    cases: "dict[str, CaseResult]" = field(default_factory=dict)
    failed: dict[str, Failure] = field(default_factory=dict)
    limits: dict[tuple[str, Limit], tuple[Floats, Floats]] = field(default_factory=dict)
    scattered: Scattered | None = None
    pictures: list[Picture] = field(default_factory=list)
    wear: dict[str, Path] = field(default_factory=dict)
    _harmonics: dict[tuple[str, int], list[Shape]] = field(default_factory=dict, repr=False)
    _recoveries: dict[str, rom.Recovery] = field(default_factory=dict, repr=False)

    @property
    def study(self) -> Study:
        """What is given, where only a study has what is drawn."""
        assert isinstance(self.given, Study)
        return self.given

    @property
    def planned(self) -> list[Planned]:
        """Steps of all cases, as solved."""
        return [case.planned for case in self.cases.values()]

    @property
    def summaries(self) -> list[Summary]:
        """All cases in numbers."""
        return [case.summary for case in self.cases.values()]

    @property
    def known(self) -> list[Summary]:
        """Cases with a peak."""
        return [each for each in self.summaries if each.peak is not None]

    @property
    def peaks(self) -> dict[str, Peak]:
        """The largest point of each case that has one."""
        return {each.case: each.peak for each in self.summaries if each.peak is not None}

    def peak(self, name: str) -> Peak:
        """The largest point of a case that has one."""
        peak = self.cases[name].peak
        assert peak is not None
        return peak

    @property
    def largest(self) -> Summary | None:
        """The case with the largest peak; of equal ones the last."""
        return max(reversed(self.known), key=_height, default=None)

    @property
    def errors(self) -> dict[str, tuple[Errors, Sequence[LeftOut]]]:
        """Estimated errors by case, where an accuracy is asked for."""
        return {name: each.errors for name, each in self.cases.items() if each.errors is not None}

    @property
    def strains(self) -> dict[str, tuple[Strain, Peak]]:
        """What gauges read, by case."""
        return {
            name: (each.strain, each.peak)
            for name, each in self.cases.items()
            if each.strain is not None and each.peak is not None
        }

    @cached_property
    def answers(self) -> "dict[str, CaseAnswers]":
        """Margins, wear and damping of the cases that are looked into."""
        from vanelock.quantities.answers import answers

        return answers(self)

    @cached_property
    def balances(self) -> "dict[str, EnergyBalance]":
        """Energies at the peaks of all cases, unless there are many."""
        from vanelock.quantities.answers import balances

        return balances(self)

    @property
    def main(self) -> "CaseAnswers | None":
        """Answers of the case with the largest peak."""
        return None if self.largest is None else self.answers.get(self.largest.case)

    def of_cases(self, blocks: Mapping[str, Sequence[Single]]) -> list[OfCase]:
        """Blocks of cases for a reader to choose from, that of the largest peak first."""
        most = self.largest
        names = sorted(blocks, key=lambda name: most is None or name != most.case)
        return [OfCase(words(name), blocks[name]) for name in names if blocks[name]]

    def table(
        self,
        name: str,
        shows: Any,
        columns: Callable[[], Mapping[str, ArrayLike]],
        notes: Sequence[str] = (),
    ) -> Path:
        """The CSV file `name` of some columns; `shows` is all that they depend on."""
        return self.output_files.draw(
            name,
            [shows, list(notes)],
            lambda path: write_columns(path, columns(), notes),
            quick=True,
        )

    def picture(
        self,
        name: str,
        heading: str,
        shows: Any,
        draw: Callable[[Path], object],
        columns: Callable[[], Mapping[str, ArrayLike]],
        notes: Sequence[str],
        caption: str,
    ) -> Picture:
        """The picture `name`, and a CSV file of that name with its numbers."""
        path = self.output_files.draw(f"{name}.png", shows, draw)
        return Picture(path, heading, caption, (self.table(f"{name}.csv", shows, columns, notes),))

    def top(self, each: Planned) -> Response:
        """The largest point of a case, alone."""
        return as_solved(self.stages.get(each.response), self.peak(each.case.name).point)

    def parts(self, each: Planned) -> list[Part]:
        """Vane segment and casing sector of a case."""
        return [self.stages.get(step) for step in each.meshes.values()]

    def fields(self, each: Planned, x: Shape, k: int) -> list[Shape]:
        """Displacement of every node of both parts from joined coordinates."""
        own = self.stages.get(each.structure.system([k])).at(k).split(x)
        return [self.recovery(each, part, k).displacement(own[part], k) for part in PARTS]

    def recovery(self, each: Planned, part: str, k: int) -> rom.Recovery:
        """What takes a part's reduced coordinates at a nodal diameter to its nodes."""
        step = recovery_step(each.case.study, part, each.structure.folded(k))

        def made() -> rom.Recovery:
            found = self.stages.get(step)
            self.stages.drop([step.key])  # those of many cases do not fit
            return found

        return latest(self._recoveries, step.key, made, len(PARTS))

    def stresses(self, each: Planned) -> Shape:
        """(H + 1, nodes, 6) harmonics of the vane's nodal stresses at a case's peak, Pa."""
        from vanelock.quantities.stress.cycles import harmonics_of

        return harmonics_of(self, each, self.top(each), "vane")

    def harmonic(self, each: Planned, h: int) -> list[Shape]:
        """Harmonic h of both parts' displacement at a case's peak, m."""
        key = each.case.name, h
        if key not in self._harmonics:
            top = self.top(each)
            x = np.asarray(top.x[h][0], complex)
            self._harmonics[key] = self.fields(each, x, int(top.harmonic_diameters[h]))
        return self._harmonics[key]


def _height(summary: Summary) -> float:
    assert summary.peak is not None
    return summary.peak.amplitude
