"""Run a scene: components, system, limits, preload and response of every case, files and page."""

import os
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from vanelock.common.errors import InputError
from vanelock.input.cases.scene_cases import scene_cases
from vanelock.input.plausible import unusual
from vanelock.input.schema.scene import Scene
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor.background import in_background
from vanelock.pipeline.executor.choose import chosen_executor
from vanelock.pipeline.executor.task_queue import Executor
from vanelock.pipeline.executor.tasks import Failure, TaskFailed
from vanelock.pipeline.progress import Failed, Finished, Listener, Notice, PointDone, silent
from vanelock.pipeline.step import Stages
from vanelock.quantities import warnings
from vanelock.quantities.jumps import by_height, notes
from vanelock.results.files import results_file
from vanelock.results.files.redrawn import OutputFiles
from vanelock.results.files.run_folder import claimed
from vanelock.results.listing import failed_table, preload_table, stage_times
from vanelock.results.scene import listing
from vanelock.results.scene.figures import SceneShown, draw
from vanelock.results.scene.page import write_scene_page
from vanelock.results.scene.record import SceneRecord
from vanelock.stages.response.summary import Peak, peak_of, sweep_of
from vanelock.stages.scene.monitor import Found, found_in, scene_monitor
from vanelock.stages.scene.plan import PlannedScene, planned
from vanelock.stages.scene.rest import constant_loads, undetermined
from vanelock.stages.scene.steps import LIMITS
from vanelock.stages.sweep.graph import divided
from vanelock.stages.sweep.retries import attempt


def run_scene(
    scene: Scene,
    folder: str | os.PathLike[str],
    listener: Listener = silent,
    text: str = "",
    workers: int = 1,
    scheduler: str | None = None,
    insecure: bool = False,
) -> tuple[Found, ...]:
    """Run a scene in a folder; what earlier runs there computed is used again.

    Parameters
    ----------
    scene : Scene
        What to compute.
    folder : path
        Where `results.h5`, `figures/`, `report.html` and `cache/` go.
    listener : callable
        Told about stages, points, notices and tables.
    text : str
        The scene file's text, kept in the results.
    workers : int
        Processes that compute the cases of a sweep; 1: this one does.
    scheduler : str, optional
        Address of a Dask scheduler whose workers do; they read the scene's files at the same
        places.
    insecure : bool
        Whether the scheduler may be on another machine without encryption.

    Returns
    -------
    tuple of Found
        One for each case that could be computed; of the others of a sweep the listener is told.

    Raises
    ------
    InputError
        If the scene cannot be computed, or the folder not be used.
    """
    path, began = Path(folder), time.perf_counter()
    with claimed(path):
        executor = chosen_executor(workers, scheduler, listener, None, insecure)
        running = SceneRun(scene, path, listener, text, executor)
        with running.record.finished():
            found = running.all_cases()
            shown = running.shown
            exhibits = draw(shown, found)
            if scene.outputs.report:
                write_scene_page(shown, found, exhibits, text)
            shown.output_files.tidy()
            listener(stage_times([*running.stages.done.values(), *shown.output_files.done]))
            running.record.complete(running.stages.done)
    pictures = [str(file) for each in exhibits for file in (each.path, *each.data)]
    told: dict[str, Any] = {
        "cases": [asdict(each) | {"case": each.case.name} for each in found],
        "failed": {name: failure.reason for name, failure in running.failed.items()},
        "results": str(path / results_file.NAME),
        "pictures": pictures,
    }
    listener(Finished(str(path), time.perf_counter() - began, told))
    return found


class SceneRun:
    """A run under way.

    Parameters
    ----------
    scene : Scene
        What to compute.
    folder : Path
        The run's folder, claimed.
    listener : callable
        Told about tables, points and notices.
    text : str
        The scene's file.
    executor : callable, optional
        Gets the processes that compute the cases; without, this one does.
    """

    def __init__(
        self,
        scene: Scene,
        folder: Path,
        listener: Listener,
        text: str,
        executor: Callable[[], Executor] | None,
    ) -> None:
        self.listener, self._executor = listener, executor
        self._cache = Cache(folder / "cache", lambda told: listener(Notice(told)))
        self.stages = Stages(self._cache, listener)
        for told in unusual(scene):
            listener(Notice(told))
        self.planned = [planned(case, self._point) for case in scene_cases(scene)]
        for told in self.planned[0].apart:  # what joins what is not swept
            listener(Notice(told))
        self.record = SceneRecord(folder, scene, text)
        cases = [each.case for each in self.planned]
        self.shown = SceneShown(scene, cases, self.stages, OutputFiles(folder, listener))
        self.failed: dict[str, Failure] = {}
        self._loose: dict[str, bool] = {}
        self._case, self._began, self._peak = "", 0.0, 0.0

    def all_cases(self) -> tuple[Found, ...]:
        """Everything but the pictures; a line for each case."""
        found = []
        with in_background(
            self._executor,
            lambda: divided([each.wanted() for each in self.planned], self._cache),
            self.stages,
            self._cache,
            self.listener,
            self._largest,
            self.record.flush_if_due,
        ):
            for each in self.planned:
                name = each.case.name
                try:
                    if len(self.planned) == 1:
                        self._compute(each)
                    else:
                        attempt(self._compute, each, name, self.stages)
                except TaskFailed as error:
                    self.failed[name] = error.failure
                    self.listener(Failed(name, error.failure.reason, error.failure.attempts))
                    self.record.failed(name, each.case.values, error.failure)
                else:
                    found.append(self._show(each))
        if not found:
            name, failure = next(iter(self.failed.items()))
            raise InputError(f"no case can be computed: {name}: {failure.reason}")
        self.listener(listing.cases_table(found, self.shown.monitor.name))
        if self.failed:
            self.listener(failed_table(self.failed))
        return tuple(found)

    def _compute(self, each: PlannedScene) -> None:
        """The products of a case."""
        self._case, self._began, self._peak = each.case.name, time.perf_counter(), 0.0
        for step in each.steps:
            self.stages.get(step)

    def _show(self, each: PlannedScene) -> Found:
        """A case that is computed: written, told."""
        pieces = [self.stages.get(step) for step in each.pieces]
        system, limits = self.stages.get(each.system), self.stages.get(each.modes)
        linear = [self.stages.get(step) for step in each.linear]
        first = not self.shown.top
        if first:
            self.listener(listing.components_table(pieces, system))
            for name, count in constant_loads(system).items():
                told = f"nothing moves along the normal of {count} of its contacts"
                self.listener(Notice(f"{name}: {told}: their load stays kn times interference"))
            wanted = each.case.scene.outputs.monitor
            self.shown.monitor = scene_monitor(wanted, system, linear[0])
        self.record.model(pieces, system)
        amplitude = self.shown.monitor.amplitude
        tops = [peak_of(response, amplitude(response)) for response in linear]
        peaks = [
            top
            if top is not None and not top.at_edge and limits.held(which, response.frequency)
            else None
            for which, response, top in zip(LIMITS, linear, tops, strict=True)
        ]
        label = self.shown.limits_of(each.modes.key, each.case.name, linear)
        if label is not None:
            named: dict[str, Peak | None] = dict(zip(LIMITS, peaks, strict=True))
            self.listener(listing.modes_table(label, limits, named))
            self.record.linear(label, limits, dict(zip(LIMITS, linear, strict=True)))
        static, joints = self.stages.get(each.preload), system.contacts.joint
        if joints and self.shown.is_new(each.preload.key):
            self.listener(preload_table("" if first else each.case.name, joints, static))
        responses = [self.stages.get(step) for step in each.responses]
        return self._found(each, responses, static, joints, peaks)

    def _found(
        self,
        each: PlannedScene,
        responses: list[Response],
        static: Response,
        joints: tuple[str, ...],
        peaks: list[Peak | None],
    ) -> Found:
        case, key = each.case, " ".join(step.key for step in each.responses)
        response, *others = by_height(responses, self.shown.monitor)
        amplitude = self.shown.monitor.amplitude(response)
        sweeps = [sweep_of(r, self.shown.monitor.amplitude(r)) for r in (response, *others)]
        peak = sweeps[0].peak
        if (rest := each.preload.key) not in self._loose:
            self._loose[rest] = undetermined(self.stages.get(each.system), static)
        loose = self._loose[rest]
        seconds = sum(self.stages.done[step.key].seconds for step in each.responses)
        found = found_in(case, response, joints, peak, peaks, loose, seconds)
        lines = (*notes(sweeps), *self._warnings(each, found, response, static))
        found = replace(found, sweeps=tuple(sweeps), warnings=lines)
        self.shown.add(case, key, response, amplitude, peak, static, joints, others)
        self.record.case(found, key, [response, *others], static, self.shown.monitor.name)
        for line in warnings.lost(found):
            self.listener(Notice(f"{case.name}: {line}"))
        return found

    def _warnings(
        self, each: PlannedScene, found: Found, response: Response, static: Response
    ) -> Iterator[str]:
        """What to know of a case, from its products."""
        limits, joints = self.stages.get(each.modes), self.stages.get(each.system).contacts.joint
        pieces = [self.stages.get(step) for step in each.pieces]
        nodes = np.concatenate([np.empty((0, 3)), *(piece.positions for piece in pieces)])
        if found.loose:
            yield listing.LOOSE
        yield from warnings.alike(limits.mac)
        yield from warnings.implausible(float(limits.stuck[limits.stuck_mode]), nodes)
        yield from warnings.open_at_rest(static, joints, dict.fromkeys(joints))
        if found.peak is not None:
            extent = np.ptp(nodes, axis=0) if len(nodes) else np.zeros(1)
            extent = extent[extent > 1e-3 * extent.max()]
            length = warnings.TENTH * float(extent.min(initial=np.inf))
            what = "a tenth of the least extent of all nodes"
            yield from warnings.large(response, found.peak, length, what, None)
            yield from warnings.beyond_band(response, found.peak, limits.band)

    def _largest(self) -> float:
        peaks = [each.peak.amplitude for each in self.shown.top.values() if each.peak is not None]
        return max(peaks, default=0.0)

    def _point(self, done: int, total: int, frequency: float, amplitude: float) -> None:
        self._peak = max(self._peak, amplitude) if amplitude == amplitude else self._peak
        spent = time.perf_counter() - self._began
        left = spent * (total - done) / max(done, 1)
        self.listener(PointDone(self._case, done, total, self._peak, left))
