"""A run as tables, pictures and the page see it: its cases, their products, and where files go."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from vanelock.common.arrays import Floats
from vanelock.common.files.csv_table import write_columns
from vanelock.input.cases.names import words
from vanelock.input.cases.values import Given
from vanelock.input.measured.curve import Measured
from vanelock.input.schema.study import Study
from vanelock.pipeline.progress import Done
from vanelock.pipeline.tasks import Failure
from vanelock.quantities.case_result import CaseResult
from vanelock.report import OfCase, Picture
from vanelock.report.blocks import Single
from vanelock.results.files.redrawn import OutputFiles
from vanelock.stages.accuracy.errors import Errors
from vanelock.stages.accuracy.left_out import LeftOut
from vanelock.stages.response.limits import Limit
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.summary import Peak, Summary

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis
    from vanelock.analyses.scatter import Scattered


@dataclass
class RunResult:
    """A run; whole products are read again where they are needed, since cases may be many.

    Attributes
    ----------
    given : Study or Scene
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

    given: Given
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
        assert isinstance(self.given, Study)
        return self.given

    @property
    def shapes(self) -> bool:
        """Whether pictures of shapes are asked for."""
        return "shapes" in self.given.outputs.show

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
        return max(reversed(self.known), key=_height, default=None)

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


def _height(summary: Summary) -> float:
    assert summary.peak is not None
    return summary.peak.amplitude
