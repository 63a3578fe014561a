"""A run under way: case after case computed, written and shown."""

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from vanelock.analyses import ANALYSES
from vanelock.analyses.scatter import FEWEST, scattered, spacing
from vanelock.analyses.solved_case import with_analyses
from vanelock.commands.run.doubts import doubts, load_lines_of, opening
from vanelock.commands.run.graph import bundle, parts_of, steps_of
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import Problem
from vanelock.input.measured.curve import load_measured
from vanelock.input.schema.structure.own_mesh import OwnVane, refuse_without_areas
from vanelock.input.schema.study import Study
from vanelock.input.settings import unusual
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Failed, Notice, silent
from vanelock.pipeline.step import Stages
from vanelock.pipeline.tasks import Failure, TaskFailed, TaskQueue, Workers
from vanelock.quantities import warnings
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.products import StepProducts, with_curves
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.warnings import notes
from vanelock.results import listing
from vanelock.results.files import results_file
from vanelock.results.files.run_folder import OutputFiles
from vanelock.results.record import Record, versions
from vanelock.stages.accuracy.choose_mesh import choose_mesh
from vanelock.stages.accuracy.evidence import judged
from vanelock.stages.accuracy.mesh_sizes import most_dofs
from vanelock.stages.campbell.frequencies import with_temperature_speeds
from vanelock.stages.cost_estimate import Clock, attempt
from vanelock.stages.matrices.scene_structure import at_rest, motions_step
from vanelock.stages.parts.loads import described
from vanelock.stages.plan import Planned, plan
from vanelock.stages.response.limits import LIMITS
from vanelock.stages.response.responses import constant_loads, monitor, not_held, undetermined
from vanelock.stages.response.summary import Peak, Summary, by_height, peak_of, summarise, sweep_of
from vanelock.stages.structure import Linear

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
        problem: Problem,
        folder: Path,
        stages: Stages,
        cases: Sequence[Case],
        workers: Workers | None,
        memory: float | None,
        text: str,
    ) -> None:
        self.problem, self.listener, self.stages = problem, stages.listener, stages
        self.output_files, self._text = OutputFiles(folder, stages.listener), text
        self.failed: dict[str, Failure] = {}
        self._workers = workers
        self.measured = load_measured(problem)  # refused before the long stages
        cases = with_temperature_speeds(cases, stages)
        self._every = cases
        studies = [case.problem for case in cases if isinstance(case.problem, Study)]
        self._say(*unusual(problem), *filter(None, dict.fromkeys(map(described, studies))))
        most = most_dofs(memory)
        choices = [None if s.accuracy is None else choose_mesh(s, stages, most) for s in studies]
        planned = plan(cases, self._point, choices)
        self.planned = tuple(with_analyses(each, planned[0], self._count) for each in planned)
        givens = [case.problem for case in cases]
        hanging = at_rest(givens, lambda *of: stages.get(motions_step(*of)))
        self._say(*self.planned[0].structure.apart, *hanging)  # what joins what is not swept
        self.record = Record(folder, stages)
        self._clock = Clock(self.planned)
        self._peaks: dict[str, dict[str, Peak | None]] = {}
        self._spacings: list[float] = []
        self._top = 0.0
        self._loose: dict[str, bool] = {}
        self._preloads: set[str] = set()

    @contextmanager
    def background(self) -> Generator[None, None, None]:
        """Have other processes compute cases, if there are any and there is something to divide."""
        stages, workers = self.stages, self._workers
        for each in self.planned:
            study = each.case.problem
            if isinstance(study, Study) and isinstance(study.vane, OwnVane):
                refuse_without_areas(study, stages.get(each.meshes["vane"]))
        shared, tasks = bundle(self.planned, stages.cache) if workers else ([], [])
        try:
            if workers and len(tasks) > 1:
                for step in shared:
                    stages.get(step)
                seen = self.listener, lambda: self._top, self.record.flush_if_due
                stages.elsewhere = TaskQueue(tasks, workers, stages.cache.folder, *seen).bring
            yield
        finally:
            stages.elsewhere = None
            if workers:
                workers.shutdown()

    def all_cases(self) -> tuple[Summary, ...]:
        """Everything but the pictures and the `answer`."""
        self._each(self._parts, self._show_parts)
        self._each(self._solve, self._show)
        return tuple(self.run.summaries)

    def _each(self, compute: Callable[[Planned], C], show: Callable[[Planned, C], object]) -> None:
        """Compute something of each case and show it; what cannot be computed is left out."""
        kept = []
        alone = len(self.planned) + len(self.failed) == 1
        for i, each in enumerate(self.planned):
            try:
                computed = compute(each) if alone else attempt(compute, each, self.stages)
            except TaskFailed as error:
                name, failure = each.case.name, error.failure
                self.failed[name] = failure
                self.listener(Failed(name, failure.reason, failure.attempts))
                self.record.failed(name, each.case.values, failure)
            else:
                show(each, computed)
                kept.append(each)
            if i + 1 < len(self.planned):  # pictures need the last one's products again
                self.stages.retain(steps_of(self.planned[i + 1]))
        if not kept:
            name, failure = next(iter(self.failed.items()))
            raise InputError(f"no case can be computed: {name}: {failure.reason}")
        self.planned = tuple(kept)

    def _parts(self, planned: Planned) -> None:
        """Meshes, reduced parts and linear limits of a case."""
        for step in parts_of(planned):
            self.stages.get(step)

    def _show_parts(self, planned: Planned, computed: None) -> None:
        linear = planned.linear
        if not self._peaks:
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
            watched = monitor(self.problem.outputs.monitor, system, free)
            self.run = RunResult(
                self.problem,
                watched,
                self.output_files,
                ANALYSES,
                opening(system.contacts),
                self.measured,
                self._text,
                self.record.date,
                versions(),
                failed=self.failed,
                times=self.stages.done,
            )
            self.record.begun(self.run, planned)
        if linear.key not in self._peaks:
            self._linear(linear)

    def scatter(self) -> None:
        """Percentiles of the peaks, where keys scatter: written, shown."""
        if self.problem.scatter is None:
            return
        found = scattered(self._every, self.run.summaries, self._spacings)
        if found is None:
            self._say(f"percentiles need at least {FEWEST} samples with a peak")
            return
        self.run.scattered = found
        self.record.product("scatter", found)

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
        own = self.run.limits.items()
        curves = {which: curve for (name, which), curve in own if name == linear.name}
        self.record.linear(linear, curves, len(self._peaks) < MOST_TABLES)
        self._peaks[linear.key] = peaks
        if self._few(len(self._peaks), "linear limits"):
            self.listener(listing.limits_table({linear.name: limits}))
            self.listener(listing.linear_table(peaks, self.run.monitor.name, linear.name))
            self._say(*warnings.beside_range(self.problem.response, limits))

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
        found = []
        for step in planned.responses:
            self._clock.begin(planned, step)
            found.append(self.stages.get(step))
            self._clock.end(not self.stages.done[step.key].cached)
        planned, response = self._as_solved(planned, found)
        for analysed in planned.analysed:
            self.stages.get(analysed)
        case = self._case(planned)
        if planned.choice is not None:
            return replace(case, errors=judged(planned, response, self.stages, self.run.monitor))
        return case

    def _as_solved(self, planned: Planned, responses: list[Response]) -> tuple[Planned, Response]:
        """A case whose responses are known, and the one with the higher peak, which comes first."""
        higher = by_height(responses, self.run.monitor)[0]
        planned = planned if higher is responses[0] else planned.turned(BY_RESPONSE)
        return planned.solved(higher), higher

    def _case(self, planned: Planned) -> CaseResult:
        """A case in numbers, with its curves."""
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
        run, case, found = self.run, planned.case, replace(found, sweeps=sweeps)
        products = StepProducts(planned, self.stages, run.monitor, found.peak, run.shared)
        return with_curves(
            CaseResult(
                name=case.name,
                values=case.values,
                problem=case.problem,
                monitor=run.monitor,
                products=products,
                summary=found,
                analyses=ANALYSES,
                components=tuple(planned.structure.names),
                ring=(system.sectors, system.engine_order),
                linear_name=planned.linear.name,
                preload_name=planned.preload_name,
            ),
            products,
        )

    def _show(self, planned: Planned, case: CaseResult) -> None:
        """A case that is solved: written, shown."""
        response, static = case.response, case.static
        system = self.stages.get(planned.system)
        if planned.preload.key not in self._preloads:
            self._preloads.add(planned.preload.key)
            if system.contacts.springs.any() and self._few(len(self._preloads), "preloads"):
                joints = system.contacts.joints
                self.listener(listing.preload_table(planned.preload_name, joints, static))
        first = all(each.peak is None for each in self.run.cases.values())
        lines = (*notes(case.summary.sweeps), *doubts(planned, case, self.stages, first))
        case = replace(case, summary=replace(case.summary, warnings=lines))
        self.run.cases[case.name] = case
        self.record.case(case)
        if (peak := case.peak) is not None:
            given = case.problem.response
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
            self.record.case(self._case(planned))

    def _count(self, done: int, total: int | None, amplitude: float) -> None:
        """How far the analyses of a case are."""
        self.listener(self._clock.count(done, total, amplitude))
        self.record.flush_if_due()

    def _point(self, done: int, total: int, frequency: float, amplitude: float) -> None:
        self.listener(self._clock.point(done, total, frequency, amplitude))
        self.record.flush_if_due()
