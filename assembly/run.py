"""Run a scene: components, system, limits, preload and response of every case, files and page."""

import os
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from vanelock.assembly import listing
from vanelock.assembly.cases import SceneCase, scene_cases
from vanelock.assembly.exhibits import Shown, draw
from vanelock.assembly.model import Scene
from vanelock.assembly.monitor import Found, found_in, scene_monitor
from vanelock.assembly.page import write_scene_page
from vanelock.assembly.record import SceneRecord
from vanelock.assembly.steps import (
    LIMITS,
    linear_step,
    modes_step,
    piece_step,
    preload_step,
    response_step,
    system_step,
)
from vanelock.nonlinear import Response
from vanelock.study import results
from vanelock.study.cache import Cache
from vanelock.study.easel import Easel
from vanelock.study.folder import claimed
from vanelock.study.listing import preload_table, stage_times
from vanelock.study.progress import Finished, Listener, Notice, Point, silent
from vanelock.study.steps import Stages
from vanelock.study.summary import Peak, peak_of


def run_scene(
    scene: Scene, folder: str | os.PathLike[str], listener: Listener = silent, text: str = ""
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

    Returns
    -------
    tuple of Found
        One for each case.

    Raises
    ------
    InputError
        If the scene cannot be computed, or the folder not be used.
    """
    path, began = Path(folder), time.perf_counter()
    cases = scene_cases(scene)
    with claimed(path):
        stages = Stages(Cache(path / "cache", lambda told: listener(Notice(told))), listener)
        record = SceneRecord(path, scene, text)
        shown = Shown(scene, cases, stages, Easel(path, listener))
        found = tuple(_Case(case, shown, record, listener).run() for case in cases)
        listener(listing.cases_table(found, shown.monitor.name))
        exhibits = draw(shown, found)
        if scene.outputs.report:
            write_scene_page(shown, found, exhibits, text)
        shown.easel.tidy()
        listener(stage_times([*stages.done.values(), *shown.easel.done]))
        record.complete(stages.done)
    pictures = [str(file) for each in exhibits for file in (each.path, *each.data)]
    told: dict[str, Any] = {
        "cases": [asdict(each) | {"case": each.case.name} for each in found],
        "results": str(path / results.NAME),
        "pictures": pictures,
    }
    listener(Finished(str(path), time.perf_counter() - began, told))
    return found


class _Case:
    """A case under way."""

    def __init__(
        self, case: SceneCase, shown: Shown, record: SceneRecord, listener: Listener
    ) -> None:
        self.case, self.shown, self.record, self.listener = case, shown, record, listener
        self.stages = shown.stages
        self._began, self._peak = time.perf_counter(), 0.0

    def run(self) -> Found:
        """Everything but the pictures."""
        scene, name = self.case.scene, self.case.name
        system_of = system_step(scene)
        first = not self.shown.top
        pieces = [self.stages.get(piece_step(scene, each)) for each in scene.components]
        system = self.stages.get(system_of)
        if first:
            self.listener(listing.components_table(pieces, system))
        self.record.model(pieces, system_of.key, system)
        bare_of = system_step(scene, bare=True)
        limits_of = modes_step(scene, bare_of)
        limits = self.stages.get(limits_of)
        linear = [self.stages.get(linear_step(scene, w, bare_of, limits_of)) for w in LIMITS]
        if first:
            self.shown.monitor = scene_monitor(scene.outputs.monitor, system, linear[0])
        monitor = self.shown.monitor
        peaks = [peak_of(each, monitor.amplitude(each)) for each in linear]
        label = self.shown.limits_of(limits_of.key, name, linear)
        if label is not None:
            named: dict[str, Peak | None] = dict(zip(LIMITS, peaks, strict=True))
            self.listener(listing.modes_table(label, limits, named))
            self.record.linear(label, limits, dict(zip(LIMITS, linear, strict=True)))
        preload_of = preload_step(scene, system_of)
        new = preload_of.key not in self.stages.done
        static = self.stages.get(preload_of)
        joints = system.contacts.joint
        if new and system.contacts.count:
            self.listener(preload_table("" if first else name, joints, static))
        self._began = time.perf_counter()
        response_of = response_step(name, scene, system_of, limits_of, self._point)
        response = self.stages.get(response_of)
        return self._found(response, response_of.key, static, joints, peaks)

    def _found(
        self,
        response: Response,
        key: str,
        static: Response,
        joints: tuple[str, ...],
        peaks: list[Peak | None],
    ) -> Found:
        amplitude = self.shown.monitor.amplitude(response)
        peak = peak_of(response, amplitude)
        found = found_in(self.case, response, joints, peak, peaks, self.stages.done[key].seconds)
        self.shown.add(self.case, key, response, amplitude, peak, static, joints)
        self.record.case(found, key, response, static, self.shown.monitor.name)
        if found.converged < found.points:
            lost = f"{found.points - found.converged} of {found.points} points did not converge"
            worst = f"largest residual {found.worst:.1e}"
            self.listener(Notice(f"{self.case.name}: {lost} ({worst})"))
        return found

    def _point(self, done: int, total: int, frequency: float, amplitude: float) -> None:
        self._peak = max(self._peak, amplitude) if amplitude == amplitude else self._peak
        spent = time.perf_counter() - self._began
        left = spent * (total - done) / max(done, 1)
        self.listener(Point(self.case.name, done, total, self._peak, left))
