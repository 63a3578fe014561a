"""Error against cost, measured: a study again and again, each setting raised alone.

The error of a value is its distance from the finest one of the same setting, in the amplitude and
the frequency of the largest response. Its cost is the processor time of the stages that the setting
affects, over that of all stages of the study as it stands, both as measured when they were
computed.
"""

import json
import os
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vanelock import nonlinear
from vanelock.commands.converge.settings import (
    DOFS,
    NAME,
    NumericalSetting,
    Outcome,
    draw,
    markdown,
    settings_of,
    table,
)
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import Case, cases
from vanelock.input.cases.values import with_values
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Finished, Listener, Notice, silent
from vanelock.pipeline.step import Stages, Step
from vanelock.results.files.run_folder import claimed, record
from vanelock.stages.accuracy.choose_mesh import choose_mesh
from vanelock.stages.campbell.frequencies import with_temperature_speeds
from vanelock.stages.plan import Planned, plan
from vanelock.stages.response.responses import monitor

NEAR = 9
"""Frequencies between the neighbours of the largest point, where the peak is located."""
LEAD = 4
"""Points before these, so that the same branch is followed."""


def converge_study(
    study: Study,
    folder: str | os.PathLike[str],
    listener: Listener = silent,
    only: Sequence[str] = (),
    dofs: float = DOFS,
) -> tuple[Outcome, ...]:
    """Measure how error and cost of a study depend on each of its settings.

    Parameters
    ----------
    study : Study
        The study; swept keys have their unswept values. With an accuracy, what that chooses is what
        the other settings are held at.
    folder : path
        A run's folder; what was computed there is used again. `converge.json`, `converge.md` and
        `figures/converge.png` go there.
    listener : callable
        Called with stages, notices and tables.
    only : sequence of str
        Keys of the settings to raise; all by default.
    dofs : float
        Largest meshes tried, degrees of freedom of both parts.

    Raises
    ------
    InputError
        If the study cannot be computed, has no such setting, or the folder cannot be used.
    """
    path = Path(folder)
    began = time.perf_counter()
    if study.sweep:
        listener(Notice("what is swept has its unswept value"))
        study = with_values(study, {})
    (case,) = cases(study)
    settings_of(case.study, dofs, only)  # refuses an unknown one before anything is computed
    with claimed(path):
        stages = Stages(Cache(path / "cache", lambda message: listener(Notice(message))), listener)
        (case,) = with_temperature_speeds([case], stages)
        if case.study.response.direction == "both":
            raise InputError('response.direction = "both": converge takes one of them, up or down')
        base = pinned(case, stages)
        found = _Measuring(base, stages, listener).all(settings_of(base, dofs, only))
        text = table(found, study.name)
        record(path / f"{NAME}.json", json.dumps([asdict(each) for each in found], indent=1))
        record(path / f"{NAME}.md", markdown(found))
        listener(text)
        picture = draw(path / "figures" / f"{NAME}.png", found, study.name)
    summary = {"files": [str(path / f"{NAME}.json"), str(path / f"{NAME}.md"), str(picture)]}
    listener(Finished(str(path), time.perf_counter() - began, summary))
    return found


def pinned(case: Case, stages: Stages) -> Study:
    """The study of a case with all that its accuracy chooses set, if it has one."""
    if case.study.accuracy is None:
        return case.study
    choice = choose_mesh(case.study, stages)
    (planned,) = plan([case], choices=[choice])
    response = stages.get(planned.response)
    chosen = {"accuracy": None, "response.harmonics": response.harmonics}
    return with_values(choice.study, chosen)


class _Peak(NamedTuple):
    amplitude: float
    frequency: float
    lost: int


class _Measuring:
    """The runs."""

    def __init__(self, study: Study, stages: Stages, listener: Listener) -> None:
        self.study, self.stages, self.listener = study, stages, listener
        base = _planned(study, "as it stands")
        free = self.stages.get(base.linear.responses["free"])
        self.monitor = monitor(study.outputs.monitor, stages.get(base.system), free)
        self._warm_up(base)
        self.stages.get(base.response)
        self.costs = self._known()
        self.unit = sum(self._cpu(base).values())

    def all(self, settings: Sequence[NumericalSetting]) -> tuple[Outcome, ...]:
        """Every value of every setting."""
        found: list[Outcome] = []
        for setting in settings:
            found += self._setting(setting)
            record(self._costs_file, json.dumps(self.costs))
        return tuple(found)

    @property
    def _costs_file(self) -> Path:
        assert isinstance(self.stages.cache, Cache)
        return self.stages.cache.folder / "costs.json"

    def _known(self) -> dict[str, float]:
        """Processor times of stages whose products no cache holds, from an earlier run here."""
        try:
            known = json.loads(self._costs_file.read_text("utf-8"))
            return {str(key): float(value) for key, value in known.items()}
        except (OSError, ValueError, AttributeError, TypeError):
            return {}

    def _warm_up(self, planned: Planned) -> None:
        """Load what the first response loads, which is no cost of its own."""
        limits, system = self.stages.get(planned.linear.limits), self.stages.get(planned.system)
        options = self.study.response
        nonlinear.frequency_response(
            system,
            [0.99 * limits.free_frequency, limits.free_frequency],
            nonlinear.Options(1, coupling=options.coupling, friction=self.study.response.friction),
        )

    def _setting(self, setting: NumericalSetting) -> list[Outcome]:
        """All values of one; what cannot be computed is reported and left out."""
        runs: list[tuple[str, bool, _Peak, dict[str, float]]] = []
        chains = [_planned(each.study, f"{setting.key} = {each.shown}") for each in setting.levels]
        for i, (level, made) in enumerate(zip(setting.levels, chains, strict=True)):
            try:
                response = self.stages.get(made.response)
                peak = self._peak(made, response, not setting.points)
            except InputError as error:
                self.listener(Notice(f"{setting.key} = {level.shown}: {error}"))
                continue
            runs.append((level.shown, level.own, peak, self._cpu(made)))
            last = made, response
            self.stages.retain([later.response for later in chains[i + 1 :]])
        shared = set.intersection(*(set(cpu) for *_, cpu in runs)) if runs else set[str]()
        if not runs:
            return []
        truth = self._peak(*last, True) if setting.points else runs[-1][2]
        outcomes = []
        for i, (value, own, peak, cpu) in enumerate(runs):
            seconds = sum(s for key, s in cpu.items() if key not in shared)
            finest = i == len(runs) - 1
            errors = (
                abs(peak.amplitude / truth.amplitude - 1),
                abs(peak.frequency / truth.frequency - 1),
            )
            if finest and not setting.points:
                errors = (float("nan"), float("nan"))
            outcomes.append(
                Outcome(
                    setting.key,
                    value,
                    seconds / self.unit,
                    seconds,
                    peak.amplitude,
                    peak.frequency,
                    *errors,
                    own,
                    peak.lost,
                )
            )
        return outcomes

    def _cpu(self, made: Planned) -> dict[str, float]:
        """Processor time of the stages behind a response, by key, s."""
        found: dict[str, float] = {}
        waiting: list[Step[Any]] = [made.response]
        while waiting:
            step = waiting.pop()
            if step.key not in found:
                found[step.key] = self.costs.setdefault(step.key, self.stages.cpu.get(step.key, 0))
                waiting += step.needs
        return found

    def _peak(self, made: Planned, response: Response, located: bool) -> _Peak:
        """The largest response, between the frequencies computed if asked."""
        lost = int((~response.converged).sum())
        order = np.argsort(response.frequency, kind="stable")
        f, a = response.frequency[order], self.monitor.amplitude(response)[order]
        if np.all(np.isnan(a)):
            return _Peak(float("nan"), float("nan"), lost)
        top = int(np.nanargmax(a))
        inside = 0 < top < len(f) - 1
        if not located or not inside or made.case.study.response.frequencies is not None:
            return _Peak(float(a[top]), float(f[top]), lost)
        lead = f[max(top - 1 - LEAD, 0) : top - 1]
        listed = np.unique([*lead, *np.linspace(f[top - 1], f[top + 1], NEAR)])
        near = with_values(
            made.case.study,
            {
                "response.frequencies": listed.tolist(),
                "response.range": None,
                "response.points": None,
            },
        )
        fine = self.stages.get(_planned(near, "near the peak").response)
        amplitude, frequency = vertex(fine.frequency, self.monitor.amplitude(fine))
        return _Peak(amplitude, frequency, lost)


def vertex(frequency: Floats, amplitude: Floats) -> tuple[float, float]:
    """Height [m] and place [Hz] of a parabola through the largest point and its neighbours.

    The largest point itself where it is at an end, beside one that is lost, or at a jump.
    """
    known = np.where(np.isnan(amplitude), -np.inf, amplitude)
    top = int(known.argmax())
    place, height = float(frequency[top]), float(amplitude[top])
    if not 0 < top < len(frequency) - 1 or np.isnan(amplitude[top - 1 : top + 2]).any():
        return height, place
    x = frequency[top - 1 : top + 2] - place
    bend, rise, _ = np.polyfit(x, amplitude[top - 1 : top + 2], 2)
    moved = -rise / (2 * bend) if bend < 0 else 0.0
    raised = height + rise * moved + bend * moved**2
    if not x[0] < moved < x[2] or raised > 1.01 * height:
        return height, place
    return float(raised), place + float(moved)


def _planned(study: Study, name: str) -> Planned:
    """The steps of a study's only case."""
    return plan([Case(name, {}, study)])[0]
