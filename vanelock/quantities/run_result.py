"""A run as tables, pictures and the page see it: its cases, their products, and where files go.

Sweeps of many cases: a band of percentiles and a few named cases instead of every one.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Floats
from vanelock.common.files.csv_table import write_columns
from vanelock.input.cases.names import words
from vanelock.input.cases.sweep import SAMPLE
from vanelock.input.cases.values import Problem
from vanelock.input.measured.curve import Measured
from vanelock.input.schema.study import Study
from vanelock.pipeline.progress import Done
from vanelock.pipeline.tasks import Failure
from vanelock.quantities.case_result import CaseResult
from vanelock.render import Band
from vanelock.report import OfCase, Picture
from vanelock.report.blocks import Single
from vanelock.results.files.run_folder import OutputFiles
from vanelock.stages.accuracy.errors import Errors, LeftOut
from vanelock.stages.response.limits import Limit
from vanelock.stages.response.responses import Monitor
from vanelock.stages.response.summary import Peak, Summary

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis
    from vanelock.analyses.scatter import Scattered


@dataclass
class RunResult:
    """A run; whole products are read again where they are needed, since cases may be many.

    Attributes
    ----------
    problem : Study or Scene
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
    date : str
        When its results were begun, ISO 8601.
    versions : dict of str to str
        Of what computed it.
    cases : dict of str to CaseResult
        Those that are solved, in their order.
    failed : dict of str to Failure
        Those that could not be computed.
    times : dict of str to Done
        What each stage took, by key.
    limits : dict of (name, "free" | "stuck") to (frequency, amplitude)
        Linear responses; without "stuck" where no contacts open in the free limit.
    scattered : Scattered or None
        Percentiles of the peaks, where keys scatter.
    pictures : list of Picture
        In their order.
    shared : dict
        What its cases have in common.
    """

    problem: Problem
    monitor: Monitor
    output_files: OutputFiles
    analyses: "Sequence[Analysis[Any, Any]]" = ()
    opens: str = "all contacts"
    measured: tuple[Measured, ...] = ()
    text: str = ""
    date: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    cases: dict[str, CaseResult] = field(default_factory=dict)
    failed: dict[str, Failure] = field(default_factory=dict)
    times: Mapping[str, Done] = field(default_factory=dict)
    limits: dict[tuple[str, Limit], tuple[Floats, Floats]] = field(default_factory=dict)
    scattered: "Scattered | None" = None
    pictures: list[Picture] = field(default_factory=list)
    shared: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def study(self) -> Study:
        """What is given, where only a study has what is drawn."""
        assert isinstance(self.problem, Study)
        return self.problem

    @property
    def shapes(self) -> bool:
        """Whether pictures of shapes are asked for."""
        return "shapes" in self.problem.outputs.show

    @property
    def first(self) -> CaseResult:
        """Its first case."""
        return next(iter(self.cases.values()))

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

    @property
    def largest(self) -> Summary | None:
        """The case with the largest peak; of equal ones the last."""
        peaks = self.peaks
        name = max(reversed(peaks), key=lambda name: peaks[name].amplitude, default=None)
        return None if name is None else self.cases[name].summary

    @property
    def errors(self) -> dict[str, tuple[Errors, Sequence[LeftOut]]]:
        """Estimated errors by case, where an accuracy is asked for."""
        return {name: each.errors for name, each in self.cases.items() if each.errors is not None}

    @property
    def looked_into(self) -> dict[str, CaseResult]:
        """The cases whose stresses, wear and damping are looked at."""
        return {name: case for name, case in self.cases.items() if case.detailed}

    @property
    def main(self) -> CaseResult | None:
        """The case with the largest peak, where it is looked into."""
        return None if self.largest is None else self.looked_into.get(self.largest.case)

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


MANY = 24
"""More cases than that are drawn as a band; each has a line of its own otherwise."""
DETAILED = 8
"""More cases than that have no pictures of their own but for a few, nor are looked into."""
PERCENT = (5, 25, 50, 75, 95)
_POINTS = 400
"""Frequencies of a band, where the cases' own differ."""
_SHARE = 0.5
"""Of the cases, how many a band needs at a frequency."""


def _lowest_first(peaks: Mapping[str, Peak]) -> list[str]:
    """Cases by the height of their peaks; of equal ones the last case counts as the highest."""
    return sorted(peaks, key=lambda name: peaks[name].amplitude)


def looked_into_names(run: RunResult) -> list[str]:
    """Names of the cases that are looked into, in order.

    All if they are few; of samples those that have pictures, of other sweeps the first, the last
    and those of the extreme peaks.
    """
    peaks = run.peaks
    names = list(peaks)
    if len(names) <= DETAILED:
        return names
    if _sampled(run):
        return [each.name for each in named(run)]
    order = _lowest_first(peaks)
    chosen = names[0], names[-1], order[0], order[-1]
    return [name for name in names if name in chosen]


def named(run: RunResult) -> list[CaseResult]:
    """Cases with a peak that have pictures of their own, in their order.

    All if they are few; of samples those of the lowest, the middle and the largest peak, of other
    sweeps the first and the last.
    """
    peaks = run.peaks
    cases = [each for name, each in run.cases.items() if name in peaks]
    if len(cases) <= DETAILED:
        return cases
    if not _sampled(run):
        return [cases[0], cases[-1]]
    order = _lowest_first(peaks)
    chosen = order[0], order[len(order) // 2], order[-1]
    return [each for each in cases if each.name in chosen]


def _sampled(run: RunResult) -> bool:
    """Whether the cases are samples of keys that scatter."""
    return next(iter(run.cases)).startswith(f"{SAMPLE}=")


def in_words(run: RunResult) -> str:
    """Which cases are named, in words."""
    if _sampled(run):
        return "the lowest, the middle and the largest peak"
    return "the first and the last case"


def band(run: RunResult) -> Band | None:
    """Percentiles of the curves of many cases; None where each has its own."""
    if len(run.cases) <= MANY:
        return None
    curves = []
    for frequency, amplitude, converged in (case.drawn for case in run.cases.values()):
        order = np.argsort(frequency, kind="stable")
        solved = order[converged[order]]
        curves.append((frequency[solved], amplitude[solved]))
    curves = [each for each in curves if len(each[0])]
    if not curves:
        return None
    first = curves[0][0]
    if all(np.array_equal(f, first) for f, _ in curves):
        at = first
    else:
        at = np.linspace(min(f[0] for f, _ in curves), max(f[-1] for f, _ in curves), _POINTS)
    table = np.array([np.interp(at, f, a, left=np.nan, right=np.nan) for f, a in curves])
    enough = np.isfinite(table).sum(axis=0) >= _SHARE * len(run.cases)
    at, table = at[enough], table[:, enough]
    if not len(at):
        return None
    kind = "samples" if _sampled(run) else "cases"
    return Band(at, np.nanpercentile(table, PERCENT, axis=0), f"{len(run.cases)} {kind}")
