"""Run a study: every stage that is not cached, the results file, the tables and the pictures."""

import os
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from vanelock.nonlinear import Response
from vanelock.rom import Component
from vanelock.study import listing, results
from vanelock.study.board import Around
from vanelock.study.cache import Cache
from vanelock.study.campbell import campbell
from vanelock.study.campbell_exhibits import crossings_table
from vanelock.study.clock import Clock
from vanelock.study.easel import Easel
from vanelock.study.errors import Errors, error_table
from vanelock.study.exhibit import Exhibit
from vanelock.study.folder import claimed
from vanelock.study.judge import judged
from vanelock.study.left_out import LeftOut, left_out_table
from vanelock.study.measured import load_measured
from vanelock.study.meshes import mesh_step
from vanelock.study.model import Study
from vanelock.study.monitor import monitor
from vanelock.study.own_mesh import OwnVane, refuse_without_areas
from vanelock.study.pictures import Gallery, Shown
from vanelock.study.plan import LIMITS, Linear, Planned, plan
from vanelock.study.progress import Finished, Listener, Notice, silent
from vanelock.study.record import Record
from vanelock.study.report_run import write_report
from vanelock.study.report_told import Told
from vanelock.study.settle import settle
from vanelock.study.solved import as_solved, drawn
from vanelock.study.speed_lines import lines_step
from vanelock.study.steps import Stages
from vanelock.study.strains import Strain
from vanelock.study.summary import Peak, Summary, peak_of, summarise
from vanelock.study.sweep import Case, cases
from vanelock.study.temperature import described
from vanelock.study.warm import warmed


def run_study(
    study: Study,
    folder: str | os.PathLike[str],
    listener: Listener = silent,
    text: str = "",
) -> tuple[Summary, ...]:
    """Run a study in a folder; what earlier runs there computed is used again.

    Parameters
    ----------
    study : Study
        What to compute.
    folder : path
        Where `results.h5`, `figures/`, `shapes/` and `cache/` go.
    listener : callable
        Told about stages, points, notices and tables.
    text : str
        The study file's text, kept in the results.

    Returns
    -------
    tuple of Summary
        One for each case.

    Raises
    ------
    InputError
        If the study cannot be computed, or the folder not be used.
    """
    path = Path(folder)
    began = time.perf_counter()
    with claimed(path):
        stages = Stages(Cache(path / "cache", lambda told: listener(Notice(told))), listener)
        running = Run(study, path, listener, stages)
        running.record.provenance(study, text)
        found = running.all_cases()
        easel = Easel(path, listener)
        gallery = Gallery(study, running.planned, stages, running.shown, easel)
        drawn = gallery.draw()
        if study.outputs.report:
            running.record.answers(gallery.answers)
            write_report(running.told(gallery, found, drawn, text))
        listener(listing.stage_times([*stages.done.values(), *easel.done]))
        running.record.complete(stages.done)
    told = {
        "cases": [asdict(case) for case in found],
        "results": str(path / results.NAME),
        "pictures": [str(file) for shown in drawn for file in (shown.path, *shown.data)],
    }
    listener(Finished(str(path), time.perf_counter() - began, told))
    return found


class Run:
    """A run under way.

    Parameters
    ----------
    study : Study
        What to compute.
    folder : Path
        The run's folder, claimed.
    listener : callable
        Told about tables, points and notices.
    stages : Stages
        What computes or finds each product.
    found : sequence of Case, optional
        The cases, where they are not those of the study's sweep.
    """

    def __init__(
        self,
        study: Study,
        folder: Path,
        listener: Listener,
        stages: Stages,
        found: Sequence[Case] = (),
    ) -> None:
        self.study, self.listener, self.stages = study, listener, stages
        self.measured = load_measured(study)  # refused before the long stages
        found = warmed(found or cases(study), stages)
        for text in dict.fromkeys(described(case.study) for case in found):
            if text:
                listener(Notice(text))
        settled = [
            None if case.study.accuracy is None else settle(case.study, stages) for case in found
        ]
        self.planned = plan(found, self._point, settled)
        self.record = Record(folder, stages)
        self._clock = Clock(self.planned)
        self._peaks: dict[str, dict[str, Peak | None]] = {}
        self._strains: dict[str, tuple[Strain, Peak]] = {}
        self._worth: dict[str, tuple[Errors, list[LeftOut]]] = {}
        self._lines: set[str] = set()

    def all_cases(self) -> tuple[Summary, ...]:
        """Everything but the pictures; a line for each case."""
        first = self.planned[0]
        for each in self.planned:  # refused before the long stages
            study = each.case.study
            if isinstance(study.vane, OwnVane):
                refuse_without_areas(study, self.stages.get(mesh_step(study, "vane")))
        self.record.parts(first)
        limits = {each.linear.key: each.linear for each in self.planned}
        for linear in limits.values():
            found = self.stages.get(linear.limits)
            self.listener(listing.limits_table(linear.name, found))
            self.record.linear(linear)
        wanted = self.study.outputs.monitor
        free = self.stages.get(first.linear.responses["free"])
        self.shown = Shown(monitor(wanted, self.stages.get(first.system), free))
        self.shown.measured = self.measured
        for linear in limits.values():
            self._linear(linear)
        for each in self.planned:  # one that has no place is refused before the long stages
            if each.gauges is not None:
                self.stages.get(each.gauges)
        summaries = []
        for i, each in enumerate(self.planned):
            summaries.append(self._case(each))
            if following := self.planned[i + 1 :]:  # pictures need the last one's products again
                self.stages.retain([later.response for later in following])
        self.listener(listing.response_table(summaries, self.shown.monitor.name))
        if self._strains:
            self.listener(listing.gauge_table(self._strains))
        for name, diagram in self.shown.campbell.items():
            self.listener(crossings_table("" if len(self.planned) == 1 else name, diagram))
        for name, (errors, without) in self._worth.items():
            self.listener(error_table(name, errors, self.shown.monitor.name))
            self.listener(left_out_table(name, without))
        return tuple(summaries)

    def told(
        self, gallery: Gallery, found: Sequence[Summary], drawn: Sequence[Exhibit], text: str = ""
    ) -> Told:
        """What the run's page is told from."""
        return Told(
            board=gallery.board,
            summaries=found,
            exhibits=drawn,
            answers=gallery.answers,
            wear=gallery.wear,
            strains=self._strains,
            worth=self._worth,
            linear=self._peaks,
            text=text,
            balances=gallery.balances,
        )

    def _linear(self, linear: Linear) -> None:
        """Linear peaks of a set of limits."""
        peaks: dict[str, Peak | None] = {}
        for which in LIMITS:
            response = self.stages.get(linear.responses[which])
            amplitude = self.shown.monitor.amplitude(response)
            peaks[which] = peak_of(response, amplitude)
            self.shown.linear[linear.name, which] = response.frequency, amplitude
        self._peaks[linear.key] = peaks
        self.listener(listing.linear_table(peaks, self.shown.monitor.name, linear.name))

    def _case(self, planned: Planned) -> Summary:
        """Preload and response of a case: computed, written, shown."""
        case, joints = planned.case, self.stages.get(planned.system).contacts.joint
        static = self._preload(planned, joints)
        self._clock.begin(planned)
        response = self.stages.get(planned.response)
        done = self.stages.done[planned.response.key]
        self._clock.end(not done.cached)
        planned = planned.solved(response)
        self.shown.harmonics[case.name] = response.harmonics
        amplitude = self.shown.monitor.amplitude(response)
        peak = peak_of(response, amplitude)
        limits, linear = self.stages.get(planned.linear.limits), self._peaks[planned.linear.key]
        found = summarise(case, joints, response, peak, limits, linear, done.seconds)
        strain = self._strain(planned, response)
        worth = None
        if planned.settled is not None:
            worth = judged(planned, response, self.stages, self.shown.monitor)
            self._worth[case.name] = worth
        self.record.case(planned, response, static, found, self.shown.monitor.name, strain, worth)
        if strain is not None and peak is not None:
            self._strains[case.name] = strain, peak
        if case.study.campbell is not None:
            self._campbell(planned)
        self.shown.static[case.name] = static
        curve = response.frequency, amplitude, response.converged
        listed = case.study.response.frequencies is not None
        self.shown.curve[case.name] = curve if listed else drawn(response, amplitude)
        if peak is not None:
            self.shown.peak[case.name] = peak
            self.shown.top[case.name] = as_solved(response, peak.point)
            self.shown.around[case.name] = Around.of(response, amplitude, peak.point)
        if found.converged < found.points:
            lost = f"{found.points - found.converged} of {found.points} points did not converge"
            self.listener(Notice(f"{case.name}: {lost} (largest residual {found.worst:.1e})"))
        return found

    def _campbell(self, planned: Planned) -> None:
        """The Campbell diagram of a case, the first of those that share its lines."""
        key = lines_step(planned, self.stages).key
        if key in self._lines:
            return
        self._lines.add(key)
        found = campbell(planned, self.stages, self.shown.monitor)
        self.shown.campbell[planned.case.name] = found
        self.record.campbell(planned.case.name, found)

    def _strain(self, planned: Planned, response: Response) -> Strain | None:
        if planned.gauges is None:
            return None

        def casing(nodal_diameter: int) -> Component:
            return self.stages.get(planned.part("casing", nodal_diameter))

        return self.stages.get(planned.gauges).read(
            response, self.stages.get(planned.rom["vane"]), casing
        )

    def _preload(self, planned: Planned, joints: tuple[str, ...]) -> Response:
        new = planned.preload.key not in self.stages.done
        static = self.stages.get(planned.preload)
        if new:
            self.listener(listing.preload_table(planned.preload_name, joints, static))
        return static

    def _point(self, done: int, total: int, frequency: float, amplitude: float) -> None:
        self.listener(self._clock.point(done, total, amplitude))
