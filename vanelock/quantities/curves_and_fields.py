"""What the pictures of a run are drawn from: its cases, its products and its responses' peaks."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock import fem, rom
from vanelock.common.files.csv_table import write_columns
from vanelock.common.process.memory import latest
from vanelock.input.cases.values import Given
from vanelock.input.measured.curve import Measured
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages
from vanelock.report import Picture
from vanelock.results.files.redrawn import OutputFiles
from vanelock.stages.campbell.campbell import Campbell
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.loads import growth
from vanelock.stages.parts.recoveries import recovery_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.responses import Limit
from vanelock.stages.response.solved import as_solved, drawn
from vanelock.stages.response.summary import Peak
from vanelock.stages.sweep.retries import Solved

if TYPE_CHECKING:
    from vanelock.analyses.analysis import Analysis
    from vanelock.quantities.case_result import CaseResult

Floats = NDArray[np.float64]
Shape = NDArray[np.complex128]
Drawn: TypeAlias = tuple[Floats, Floats, NDArray[np.bool_]]


@dataclass
class Shown:
    """What the pictures need of all responses, collected while the cases run.

    It is small, since a sweep may have many cases; whole products are read again where needed.

    Attributes
    ----------
    monitor : Monitor
        The displacement in the curves.
    linear : dict of (name, "free" | "stuck") to (frequency, amplitude)
        Linear responses; without "stuck" where no contacts open in the free limit.
    curve : dict of str to (frequency, amplitude, converged)
        Nonlinear responses by case.
    peak : dict of str to Peak
        The largest point of each case, if any.
    harmonics : dict of str to int
        Highest harmonic of each case.
    sweeps : dict of str to dict of str to curve
        Curves of both directions by name, for the cases that were swept in both.
    campbell : dict of str to Campbell
        Campbell diagrams by case.
    measured : tuple of Measured
        Measured curves.
    ends : dict of str to tuple of curve
        Curves with the least and the largest peak that static friction allows, by case.
    verdicts : dict of str to dict of str to (p,) int
        Of the points of each curve, STABLE, UNSTABLE, UNDECIDED, or -1 where nothing is known.
    opens : str
        What opens in the free limit, in words; "" where nothing does.
    """

    monitor: Monitor
    linear: dict[tuple[str, Limit], tuple[Floats, Floats]] = field(default_factory=dict)
    curve: dict[str, Drawn] = field(default_factory=dict)
    peak: dict[str, Peak] = field(default_factory=dict)
    harmonics: dict[str, int] = field(default_factory=dict)
    sweeps: dict[str, dict[str, Drawn]] = field(default_factory=dict)
    campbell: dict[str, Campbell] = field(default_factory=dict)
    measured: tuple[Measured, ...] = ()
    ends: dict[str, tuple[Drawn, ...]] = field(default_factory=dict)
    verdicts: dict[str, dict[str, NDArray[np.int64]]] = field(default_factory=dict)
    opens: str = "all contacts"

    def collect(
        self, solved: Solved, result: "CaseResult", analyses: "Sequence[Analysis[Any, Any]]"
    ) -> None:
        """Keep what is drawn of a case's responses."""
        name, given = result.name, result.given
        every = (solved.response, solved.other)
        made = [result.curve(each) for each in every if each is not None]
        if given.response.frequencies is None:
            made[0] = drawn(solved.response, made[0][1])
        self.curve[name] = made[0]
        if solved.other is not None:
            names = [f"sweeping {each.direction}" for each in result.summary.sweeps]
            self.sweeps[name] = dict(zip(names, made, strict=True))
        for analysis in analyses:
            if not (products := result.found(analysis.key)):
                continue
            lines = analysis.lines(products)
            if lines.ends:
                self.ends[name] = tuple(map(result.curve, lines.ends))
            if lines.verdicts:
                every_curve = zip(self.curves(name), made, lines.verdicts, strict=False)
                self.verdicts[name] = {
                    variant: np.array([known.get(f, -1) for f in curve[0].tolist()])
                    for variant, curve, known in every_curve
                }

    def curves(self, case: str) -> dict[str, Drawn]:
        """The curves of a case by their direction, which is "" where there is but one."""
        return self.sweeps.get(case) or {"": self.curve[case]}


@dataclass(frozen=True)
class Around:
    """The contacts at some points of a response, k of them.

    Attributes
    ----------
    headings : tuple of str
        Where each is, such as "at the peak".
    frequency : (k,) float
        Hz.
    state : (k, c) int
        As of `Response`.
    dissipation : (k, c) float
        J in a cycle.
    """

    headings: tuple[str, ...]
    frequency: Floats
    state: NDArray[np.int64]
    dissipation: Floats

    @classmethod
    def of(cls, response: Response, amplitude: Floats, peak: int) -> "Around":
        """The peak and, on either side, the converged point nearest to half its amplitude."""
        frequency, solved = response.frequency, np.flatnonzero(response.converged)
        chosen, headings = [], []
        for side, heading in ((-1, "below the peak"), (0, "at the peak"), (1, "above the peak")):
            points = solved[np.sign(frequency[solved] - frequency[peak]) == side]
            if side == 0:
                points = np.array([peak])
            if len(points):
                apart = np.abs(amplitude[points] - 0.5 * amplitude[peak])
                chosen.append(int(points[apart.argmin()]))
                headings.append(heading)
        at = np.array(chosen)
        return cls(tuple(headings), frequency[at], response.state[at], response.dissipation[at])


@dataclass
class RunData:
    """All that pictures are drawn from, and where they go."""

    given: Given
    planned: Sequence[Planned]
    stages: Stages
    shown: Shown
    output_files: OutputFiles
    analyses: "Sequence[Analysis[Any, Any]]" = ()
    results: "Mapping[str, CaseResult]" = field(default_factory=dict)
    _harmonics: dict[tuple[str, int], list[Shape]] = field(default_factory=dict, repr=False)
    _recoveries: dict[str, rom.Recovery] = field(default_factory=dict, repr=False)

    @property
    def study(self) -> Study:
        """What is given, where only a study has what is drawn."""
        assert isinstance(self.given, Study)
        return self.given

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
        return as_solved(self.stages.get(each.response), self.shown.peak[each.case.name].point)

    def around(self, each: Planned) -> Around:
        """The contacts of a case around its largest point."""
        response = self.stages.get(each.response)
        amplitude = self.shown.monitor.amplitude(response)
        return Around.of(response, amplitude, self.shown.peak[each.case.name].point)

    def parts(self, each: Planned) -> list[Part]:
        """Vane segment and casing sector of a case."""
        return [self.stages.get(step) for step in each.meshes.values()]

    def fields(self, each: Planned, x: Shape, k: int) -> list[Shape]:
        """Displacement of every node of both parts from joined coordinates."""
        components = [self.stages.get(each.part(part, k)) for part in PARTS]
        pieces = rom.split(*components, x)
        return [
            self.recovery(each, part, k).displacement(q, k)
            for part, q in zip(PARTS, pieces, strict=True)
        ]

    def recovery(self, each: Planned, part: str, k: int) -> rom.Recovery:
        """What takes a part's reduced coordinates at a nodal diameter to its nodes."""
        step = recovery_step(each.case.study, part, each.part(part, k))

        def made() -> rom.Recovery:
            found = self.stages.get(step)
            self.stages.drop([step.key])  # those of many cases do not fit
            return found

        return latest(self._recoveries, step.key, made, len(PARTS))

    def stresses(self, each: Planned) -> Shape:
        """(H + 1, nodes, 6) harmonics of the vane's nodal stresses at a case's peak, Pa."""
        top = self.top(each)
        return np.stack([self._stress(each, top, h) for h in range(top.harmonics + 1)])

    def _stress(self, each: Planned, top: Response, h: int) -> Shape:
        k = int(top.harmonic_diameters[h])
        parts = [self.stages.get(each.part(part, k)) for part in PARTS]
        coordinates = rom.split(*parts, np.asarray(top.x[h][0], complex))[0]
        recovery = self.recovery(each, "vane", k)
        grown = None if h else growth(each.case.study, "vane", recovery.model.part)
        return np.asarray(recovery.stress(coordinates, k, growth=grown))

    def harmonic(self, each: Planned, h: int) -> list[Shape]:
        """Harmonic h of both parts' displacement at a case's peak, m."""
        key = each.case.name, h
        if key not in self._harmonics:
            top = self.top(each)
            x = np.asarray(top.x[h][0], complex)
            self._harmonics[key] = self.fields(each, x, int(top.harmonic_diameters[h]))
        return self._harmonics[key]


def stress_over_a_period(harmonics: Shape) -> tuple[Floats, Floats]:
    """(nodes,) largest von Mises stress over a period, Pa: in all, and of the vibration alone."""
    moving = harmonics.copy()
    moving[0] = 0
    return fem.peak_von_mises(harmonics), fem.peak_von_mises(moving)
