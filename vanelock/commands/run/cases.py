"""A run under way: case after case computed, written and shown."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from vanelock.analyses import ANALYSES
from vanelock.analyses.solved_case import with_analyses
from vanelock.commands.run.doubts import doubts, load_lines_of, opening
from vanelock.commands.run.graph import done_by, parts_of, steps_of
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import Given
from vanelock.input.measured.curve import load_measured
from vanelock.input.schema.structure.own_mesh import OwnVane, refuse_without_areas
from vanelock.input.schema.study import Study
from vanelock.input.settings import unusual
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Failed, Listener, Notice, silent
from vanelock.pipeline.step import Stages, Step
from vanelock.pipeline.tasks import Failure, TaskFailed, Workers
from vanelock.quantities import warnings
from vanelock.quantities.case_result import CaseResult, with_curves
from vanelock.quantities.jumps import notes
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.scatter import (
    FEWEST,
    percentile_table,
    scattered,
    sensitivity_table,
    spacing,
)
from vanelock.results import listing
from vanelock.results.case_table import response_table
from vanelock.results.figures.campbell import crossings_table
from vanelock.results.files import results_file
from vanelock.results.files.redrawn import OutputFiles
from vanelock.results.record import Record
from vanelock.stages.accuracy.choose_mesh import choose_mesh
from vanelock.stages.accuracy.errors import error_table
from vanelock.stages.accuracy.evidence import judged
from vanelock.stages.accuracy.left_out import left_out_table
from vanelock.stages.accuracy.mesh_sizes import most_dofs
from vanelock.stages.campbell.campbell import Campbell, campbell
from vanelock.stages.campbell.speed_lines import lines_step
from vanelock.stages.campbell.temperature_speed import with_temperature_speeds
from vanelock.stages.linear import Linear
from vanelock.stages.matrices.scene_structure import at_rest, motions_step
from vanelock.stages.parts.gauges import Strain
from vanelock.stages.parts.temperatures import described
from vanelock.stages.plan import Planned, plan
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.responses import LIMITS
from vanelock.stages.response.rest import constant_loads, not_held, undetermined
from vanelock.stages.response.summary import Peak, Summary, by_height, peak_of, summarise, sweep_of
from vanelock.stages.sweep.retries import attempt
from vanelock.stages.sweep.time_left import Clock

C = TypeVar("C")
BY_RESPONSE = {each.key for each in ANALYSES if each.by_response}
"""Analyses with a product of each response."""
MOST_TABLES = 8
"""Tables of a kind that are printed; a sweep of a stiffness has linear limits of its own by case.
"""


class OngoingRun:
    """A run under way."""

    run: RunResult
    """What is known of it, from its first case's linear responses on."""

    def __init__(
        self,
        given: Given,
        folder: Path,
        listener: Listener,
        stages: Stages,
        found: Sequence[Case],
        output_files: OutputFiles,
        workers: Workers | None = None,
        memory: float | None = None,
        text: str = "",
    ) -> None:
        self.given, self.listener, self.stages = given, listener, stages
        self._output_files, self._text = output_files, text
        self.failed: dict[str, Failure] = {}
        self._workers = workers
        self.measured = load_measured(given)  # refused before the long stages
        found = with_temperature_speeds(found, stages)
        self._every = found
        studies = [case.given for case in found if isinstance(case.given, Study)]
        self._say(*unusual(given), *filter(None, dict.fromkeys(map(described, studies))))
        most = most_dofs(memory)
        choices = [None if s.accuracy is None else choose_mesh(s, stages, most) for s in studies]
        planned = plan(found, self._point, choices)
        self.planned = tuple(
            with_analyses(each, planned[0], ANALYSES, self._count) for each in planned
        )
        givens = [case.given for case in found]
        hanging = at_rest(givens, lambda *of: stages.get(motions_step(*of)))
        self._say(*self.planned[0].structure.apart, *hanging)  # what joins what is not swept
        self.record = Record(folder, stages)
        self._clock = Clock(self.planned)
        self._peaks: dict[str, dict[str, Peak | None]] = {}
        self._spacings: list[float] = []
        self._lines: set[str] = set()
        self._top = 0.0
        self._loose: dict[str, bool] = {}
        self._preloads: set[str] = set()

    def background(self) -> AbstractContextManager[None]:
        """Have other processes compute all cases, where that is wanted."""
        for each in self.planned:
            study = each.case.given
            if isinstance(study, Study) and isinstance(study.vane, OwnVane):
                refuse_without_areas(study, self.stages.get(each.meshes["vane"]))
        seen = self.listener, lambda: self._top, self.record.flush_if_due
        return done_by(self._workers, self.planned, self.stages, *seen)

    def all_cases(self) -> tuple[Summary, ...]:
        """Everything but the pictures and the `answer`."""
        self._each(self._parts, self._show_parts)
        self._each(self._solve, self._show)
        for analysis in ANALYSES:
            for table in analysis.tables(self.run.cases):
                self.listener(table)
        if strains := self.run.strains:
            self.listener(listing.gauge_table(strains))
        for name, case in self.run.cases.items():
            if case.campbell is not None:
                only = "" if len(self.planned) == 1 else name
                self.listener(crossings_table(only, case.campbell))
        for name, (errors, without) in self.run.errors.items():
            self.listener(error_table(name, errors, self.run.monitor.name))
            self.listener(left_out_table(name, without))
        return tuple(self.run.summaries)

    def answer(self) -> None:
        """What failed, and the responses: the last tables, since they are what was asked for."""
        if self.failed:
            self.listener(listing.failed_table(self.failed))
        table = response_table(self.run.summaries, self.run.monitor.name, len(self.failed))
        self.listener(table)

    def _each(self, compute: Callable[[Planned], C], show: Callable[[Planned, C], object]) -> None:
        """Compute something of each case and show it; what cannot be computed is left out."""
        kept = []
        alone = len(self.planned) + len(self.failed) == 1
        for i, each in enumerate(self.planned):
            try:
                computed = (
                    compute(each) if alone else attempt(compute, each, each.case.name, self.stages)
                )
            except TaskFailed as error:
                self._fail(each, error.failure)
            else:
                show(each, computed)
                kept.append(each)
            if i + 1 < len(self.planned):  # pictures need the last one's products again
                self.stages.retain(steps_of(self.planned[i + 1]))
        if not kept:
            name, failure = next(iter(self.failed.items()))
            raise InputError(f"no case can be computed: {name}: {failure.reason}")
        self.planned = tuple(kept)

    def _fail(self, planned: Planned, failure: Failure) -> None:
        name = planned.case.name
        self.failed[name] = failure
        self.listener(Failed(name, failure.reason, failure.attempts))
        self.record.failed(name, planned.case.values, failure)

    def _parts(self, planned: Planned) -> None:
        """Meshes, reduced parts and linear limits of a case."""
        for step in parts_of(planned):
            self.stages.get(step)

    def _show_parts(self, planned: Planned, computed: None) -> None:
        linear = planned.linear
        if not self._peaks:
            self.record.parts(planned)
            system = self.stages.get(planned.system)
            if not planned.meshes:
                pieces = [
                    self.stages.get(planned.part(name, 0)) for name in planned.structure.names
                ]
                self.listener(listing.components_table(pieces, system))
            self._say(*load_lines_of(planned, self.stages))
            for name, count in constant_loads(system).items():
                text = f"nothing moves along the normal of {count} of its contacts: their load"
                self._say(f"{name}: {text} stays kn times interference")
            if count := not_held(system):
                self._say(f"{count} {warnings.FREE}")
            free = self.stages.get(linear.responses["free"])
            watched = monitor(self.given.outputs.monitor, system, free)
            self.run = RunResult(
                self.given,
                self.stages,
                watched,
                self._output_files,
                ANALYSES,
                opening(system.contacts),
                self.measured,
                self._text,
                failed=self.failed,
            )
        if linear.key not in self._peaks:
            self.record.linear(linear, len(self._peaks) < MOST_TABLES)
            self._linear(linear)

    def scatter(self) -> None:
        """Percentiles of the peaks, where keys scatter: written, shown."""
        if self.given.scatter is None:
            return
        found = scattered(self._every, self.run.summaries, self._spacings)
        if found is None:
            self._say(f"percentiles need at least {FEWEST} samples with a peak")
            return
        self.run.scattered = found
        self.record.product("scatter", found)
        self.listener(percentile_table(found, self.run.monitor.name))
        self.listener(sensitivity_table(found))

    def _linear(self, linear: Linear) -> None:
        """Linear modes and peaks of a set of limits."""
        peaks: dict[str, Peak | None] = {}
        limits = self.stages.get(linear.limits)
        for which in LIMITS:
            response = self.stages.get(linear.responses[which])
            amplitude = self.run.monitor.amplitude(response)
            peaks[which] = peak_of(response, amplitude)
            if which == "free" or limits.opens:
                self.run.limits[linear.name, which] = response.frequency, amplitude
        self._peaks[linear.key] = peaks
        if self._few(len(self._peaks), "linear limits"):
            self.listener(listing.limits_table({linear.name: limits}))
            self.listener(listing.linear_table(peaks, self.run.monitor.name, linear.name))
            self._say(*warnings.beside_range(self.given.response, limits))

    def _say(self, *texts: str) -> None:
        for text in texts:
            self.listener(Notice(text))

    def _few(self, count: int, what: str) -> bool:
        """Whether so many tables of a kind are few enough to print."""
        if count == MOST_TABLES + 1:
            self.listener(Notice(f"{what} of further cases: see {results_file.NAME}"))
        return count <= MOST_TABLES

    def _solve(self, planned: Planned) -> CaseResult:
        """Preload and responses of a case, and all that follows from them."""
        self.stages.get(planned.preload)
        found = [self._response(planned, step) for step in planned.responses]
        planned, response = self._as_solved(planned, found)
        strain, errors = self._strain(planned, response), None
        if planned.choice is not None:
            errors = judged(planned, response, self.stages, self.run.monitor)
        diagram = self._campbell(planned)
        for analysed in planned.analysed:
            self.stages.get(analysed)
        case = self._case(planned)
        case = replace(case, strain=strain, errors=errors, campbell=diagram)
        return with_curves(case, ANALYSES)

    def _response(self, planned: Planned, step: Step[Response]) -> Response:
        self._clock.begin(planned, step)
        found = self.stages.get(step)
        self._clock.end(not self.stages.done[step.key].cached)
        return found

    def _as_solved(self, planned: Planned, responses: list[Response]) -> tuple[Planned, Response]:
        """A case whose responses are known, and the one with the higher peak, which comes first."""
        higher = by_height(responses, self.run.monitor)[0]
        planned = planned if higher is responses[0] else planned.turned(BY_RESPONSE)
        return planned.solved(higher), higher

    def _case(self, planned: Planned) -> CaseResult:
        """A case in numbers, but for those of its analyses."""
        system = self.stages.get(planned.system)
        responses = [self.stages.get(each) for each in planned.responses]
        sweeps = tuple(sweep_of(each, self.run.monitor.amplitude(each)) for each in responses)
        if (key := planned.preload.key) not in self._loose:
            self._loose[key] = undetermined(system, self.stages.get(planned.preload))
        found = summarise(
            planned.case,
            system.contacts,
            responses[0],
            peak_of(responses[0], self.run.monitor.amplitude(responses[0])),
            self.stages.get(planned.linear.limits),
            self._peaks[planned.linear.key],
            sum(self.stages.done[step.key].seconds for step in planned.responses),
            self._loose[key],
        )
        return CaseResult(planned, self.stages, self.run.monitor, replace(found, sweeps=sweeps))

    def _show(self, planned: Planned, case: CaseResult) -> None:
        """A case that is solved: written, shown."""
        planned, response, static = case.planned, case.responses[0], case.static
        system = self.stages.get(planned.system)
        if planned.preload.key not in self._preloads:
            self._preloads.add(planned.preload.key)
            if system.contacts.springs.any() and self._few(len(self._preloads), "preloads"):
                joints = system.contacts.joints
                self.listener(listing.preload_table(planned.preload_name, joints, static))
        first = all(each.peak is None for each in self.run.cases.values())
        lines = (*notes(case.summary.sweeps), *doubts(case, static, first))
        case = replace(case, summary=replace(case.summary, warnings=lines))
        self.run.cases[case.name] = case
        self.record.case(case, ANALYSES)
        if case.campbell is not None:
            self._lines.add(lines_step(planned).key)
            self.record.campbell(case.name, case.campbell)
        if (peak := case.peak) is not None:
            given = case.given.response
            if given.points is not None or given.frequencies is not None:
                self._spacings.append(spacing(response.frequency, peak.point))
            self._top = max(self._top, peak.amplitude)

    def unshown(self) -> None:
        """Write cases whose responses the cache holds when a run ends early: results, too."""
        cache = self.stages.cache
        held, self.stages = cache.held(), Stages(cache, silent)
        for each in self.planned:
            steps = (*each.responses, each.preload)
            if each.case.name in self.run.cases or not all(held(s.stage, s.key) for s in steps):
                continue
            found = [self.stages.get(step) for step in each.responses]
            planned, _ = self._as_solved(replace(each, analyses={}), found)
            self.record.case(self._case(planned), ())

    def _campbell(self, planned: Planned) -> Campbell | None:
        """The Campbell diagram of a case, the first of those that share its lines."""
        given = planned.case.given
        if not isinstance(given, Study) or given.campbell is None:
            return None
        key = lines_step(planned).key
        if key in self._lines:
            return None
        return campbell(planned, self.stages, self.run.monitor)

    def _strain(self, planned: Planned, response: Response) -> Strain | None:
        if planned.gauges is None:
            return None
        return self.stages.get(planned.gauges).read(response, self.stages.get(planned.system))

    def _count(self, done: int, total: int | None, amplitude: float) -> None:
        """How far the analyses of a case are."""
        self.listener(self._clock.count(done, total, amplitude))
        self.record.flush_if_due()

    def _point(self, done: int, total: int, frequency: float, amplitude: float) -> None:
        self.listener(self._clock.point(done, total, frequency, amplitude))
        self.record.flush_if_due()
