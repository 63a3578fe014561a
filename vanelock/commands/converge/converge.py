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
from typing import NamedTuple

import numpy as np

from vanelock import nonlinear
from vanelock.commands.converge.settings import (
    DOFS,
    NAME,
    POINTS,
    Level,
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
from vanelock.pipeline.step import Stages, reachable
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
        measuring, found = _Measuring(base, stages, listener), tuple[Outcome, ...]()
        for key, levels in settings_of(base, dofs, only).items():
            found += measuring.setting(key, levels)
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
        self.stages, self.listener = stages, listener
        base = _planned(study, "as it stands")
        system, options = stages.get(base.system), study.response
        free = stages.get(base.linear.responses["free"])
        self.monitor = monitor(study.outputs.monitor, system, free)
        tuned = stages.get(base.linear.limits).free_frequency
        nonlinear.frequency_response(  # loads what the first one loads, which is no cost of its own
            system,
            [0.99 * tuned, tuned],
            nonlinear.Options(1, coupling=options.coupling, friction=options.friction),
        )
        stages.get(base.response)
        self.costs_file = stages.cache.folder / "costs.json"
        self.costs = _costs(self.costs_file)
        self.unit = sum(self._cpu(base).values())

    def setting(self, key: str, levels: Sequence[Level]) -> tuple[Outcome, ...]:
        """All values of one; what cannot be computed is reported and left out."""
        runs: list[tuple[Level, _Peak, dict[str, float]]] = []
        chains = [_planned(level.study, f"{key} = {level.shown}") for level in levels]
        for i, (level, made) in enumerate(zip(levels, chains, strict=True)):
            try:
                response = self.stages.get(made.response)
                peak = self._peak(made, response, key != POINTS)
            except InputError as error:
                self.listener(Notice(f"{key} = {level.shown}: {error}"))
                continue
            runs.append((level, peak, self._cpu(made)))
            last = made, response
            self.stages.retain([later.response for later in chains[i + 1 :]])
        record(self.costs_file, json.dumps(self.costs))
        if not runs:
            return ()
        shared = set.intersection(*(set(cpu) for *_, cpu in runs))
        truth = self._peak(*last, True) if key == POINTS else runs[-1][1]
        outcomes = []
        for level, peak, cpu in runs:
            seconds = sum(s for step, s in cpu.items() if step not in shared)
            cost, size, place = (seconds / self.unit, seconds), peak.amplitude, peak.frequency
            errors = abs(size / truth.amplitude - 1), abs(place / truth.frequency - 1)
            if peak is truth:
                errors = float("nan"), float("nan")
            outcome = Outcome(
                key, level.shown, *cost, size, place, *errors, level.chosen, peak.lost
            )
            outcomes.append(outcome)
        return tuple(outcomes)

    def _cpu(self, made: Planned) -> dict[str, float]:
        """Processor time of the stages behind a response, by key, s."""
        keys = [step.key for step in reachable([made.response])]
        return {key: self.costs.setdefault(key, self.stages.cpu.get(key, 0)) for key in keys}

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
        every = {"response.frequencies": listed.tolist(), "response.range": None, POINTS: None}
        near = with_values(made.case.study, every)
        fine = self.stages.get(_planned(near, "near the peak").response)
        amplitude, frequency = vertex(fine.frequency, self.monitor.amplitude(fine))
        return _Peak(amplitude, frequency, lost)


def _costs(file: Path) -> dict[str, float]:
    """Processor times of stages whose products no cache holds, from an earlier run here."""
    try:
        costs = json.loads(file.read_text("utf-8"))
        return {str(key): float(value) for key, value in costs.items()}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


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
