"""`vanelock optimise`: values of joints with which the largest peak of a study is the smallest."""

import json
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from vanelock.commands.fit.fit import fitted_text, model_of, planned_alone, unswept
from vanelock.commands.fit.parameters import FitParameter, varied_parameters
from vanelock.commands.fit.tables import UNITS, shown
from vanelock.commands.optimise.minimax import Minimax, best, minimax
from vanelock.commands.optimise.peaks import Peaks
from vanelock.common.errors import InputError
from vanelock.common.tables import Cell, Column, Table, counted
from vanelock.input.schema.study import Study
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Begun, Finished, Listener, Notice, Trial, silent
from vanelock.pipeline.step import Stages
from vanelock.results.files.run_folder import claimed, record
from vanelock.stages.response.limits import frequencies

Floats = NDArray[np.float64]

NAME = "optimise"
ROUNDS = 4
"""Searches, each after a peak that none had followed was met."""
HIGHER = 1e-3
"""How much higher, relatively, a peak must be to be another one."""
BOUND = 1e-3
"""Of the range: closer to a bound a value lies on it."""
EQUAL = 1e-3
"""Relative difference of two peaks that are equally high."""
TRIALS = 10
"""Of a search, before any is known."""


@dataclass(frozen=True)
class Optimum:
    """Where the largest peak is smallest.

    Attributes
    ----------
    parameters : tuple of FitParameter
    value : (p,) float
    before, after : float
        Largest peak with the study's values and with these, m.
    frequencies : (j,) float
        Of the peaks that count there, Hz.
    amplitudes : (j,) float
        Theirs, m.
    trials : int
        Places that were tried.
    solved : int
        Frequencies solved, all together.
    settled : bool
        Whether no step promised a lower peak.
    held : tuple of bool
        Whether each parameter lies on a bound.
    """

    parameters: tuple[FitParameter, ...]
    value: Floats
    before: float
    after: float
    frequencies: Floats
    amplitudes: Floats
    trials: int
    solved: int
    settled: bool
    held: tuple[bool, ...]


def optimise_study(
    study: Study,
    folder: str | os.PathLike[str],
    listener: Listener = silent,
    text: str = "",
    beside: str | os.PathLike[str] = ".",
) -> Optimum:
    """Find the values of `[optimise]` with which the largest peak of the range is the smallest.

    Parameters
    ----------
    study : Study
        The study; of swept keys the unswept values count.
    folder : path
        A run's folder; meshes and reduced parts there are used again. `optimise.json` and
        `optimised.toml` go there.
    listener : callable
        Called with stages, trials, notices and tables.
    text : str
        The study file's text, which `optimised.toml` keeps but for the new values.
    beside : path
        The folder that files named in the text are relative to.

    Raises
    ------
    InputError
        If there is nothing to vary, no peak lies in the range, or the folder cannot be used.
    """
    if study.optimise is None:
        raise InputError("optimise: the study has no [optimise] table, which names what to vary")
    path, began, starts = Path(folder), time.perf_counter(), study.optimise.starts
    study = unswept(study, listener)
    parameters = varied_parameters(study, "optimise")
    with claimed(path):
        stages = Stages(Cache(path / "cache", lambda message: listener(Notice(message))), listener)
        planned = planned_alone(study, stages, listener)
        wanted = np.asarray(frequencies(study, stages.get(planned.linear.limits)))
        near = float(wanted.min()), float(wanted.max())
        model = model_of(planned, stages)
        listener(Begun(f"largest peak over {counted(len(parameters), 'parameter')}"))
        found = optimum(Peaks(model, parameters, near), starts, listener)
        listener(optimum_table(found, study.name))
        files = _files(path, found, text, Path(beside), listener)
    summary = {"optimum": json_of(found), "files": [str(each) for each in files]}
    listener(Finished(str(path), time.perf_counter() - began, summary))
    return found


def optimum(peaks: Peaks, starts: int = 1, listener: Listener = silent) -> Optimum:
    """The smallest largest peak, from the parameters' own starts and from others in the bounds.

    Raises
    ------
    InputError
        If no peak lies in the range at any start.
    """
    parameters = peaks.parameters
    low, high = (
        np.array([each.inner(getattr(each, end)) for each in parameters]) for end in ("low", "high")
    )
    own = np.array([each.inner(each.start) for each in parameters])
    begins = [own]
    if starts > 1:
        spread = qmc.Sobol(len(own), seed=1).random_base2(int(np.ceil(np.log2(starts))))
        begins += list(low + (high - low) * spread[: starts - 1])
    began, trials = time.perf_counter(), 0
    before = least = float("inf")

    def evaluate(x: Floats) -> Any:
        nonlocal trials, before, least
        found, trials = peaks(x), trials + 1
        size = float("inf") if found is None else found.largest
        before, least = size if trials == 1 else before, min(least, size)
        total = max(trials, TRIALS * len(begins))
        left = (time.perf_counter() - began) / trials * (total - trials)
        listener(Trial(trials, 1e6 * size, 1e6 * least, "um", total, left))
        return found

    found: list[Minimax | None] = []
    for begin in begins:
        x = begin
        peaks.known = []
        for _ in range(ROUNDS):
            each = minimax(evaluate, x, (low, high))
            if each is None:
                break
            afresh = peaks.afresh(each.x)
            if afresh is None or afresh.largest < (1 + HIGHER) * each.functions.largest:
                found.append(each)
                break
            x = each.x
        else:  # a higher peak was met each time: of the start and the last place, the lower one
            for place in (begin, x):
                there = peaks.afresh(place)
                if there is not None:
                    found.append(Minimax(place, there, (), False))
    chosen = best(found)
    if chosen is None:
        raise InputError("optimise: no peak lies in the range of frequencies at any start")
    if not chosen.settled:
        peaks.known = []
    peaks(chosen.x)
    top = chosen.functions.largest
    order = [each for each in peaks.known if each.amplitude > (1 - EQUAL) * top]
    margin = BOUND * (high - low)
    return Optimum(
        parameters=tuple(parameters),
        value=np.array(list(peaks.values(chosen.x).values())),
        before=before,
        after=top,
        frequencies=np.array([each.solution.omega for each in order]) / (2 * np.pi),
        amplitudes=np.array([each.amplitude for each in order]),
        trials=trials,
        solved=peaks.solved,
        settled=chosen.settled,
        held=tuple(bool(each) for each in (chosen.x < low + margin) | (chosen.x > high - margin)),
    )


def optimum_table(found: Optimum, name: str) -> Table:
    """One line for each parameter, what became of the peak below."""
    columns = (
        Column("parameter"),
        Column("study", form=".5g", key="start"),
        Column("optimum", form=".5g", key="value"),
        Column("unit"),
        Column("bounds"),
    )
    rows: list[tuple[Cell, ...]] = []
    for parameter, value in zip(found.parameters, found.value, strict=True):
        unit = UNITS.get(parameter.key.rpartition(".")[2], "-")
        bounds = f"{parameter.low:.3g} to {parameter.high:.3g}"
        rows.append((shown(parameter.key), parameter.start, float(value), unit, bounds))
    return Table(f"Smallest largest peak: {name}", columns, rows, notes(found), NAME)


def notes(found: Optimum) -> list[str]:
    """What became of the peak, and what should keep one from believing it."""
    places = " and ".join(f"{each:.6g} Hz" for each in found.frequencies)
    said = [
        f"largest peak: {1e6 * found.before:.4g} um with the study's values, "
        f"{1e6 * found.after:.4g} um at {places}; {counted(found.trials, 'place')}, "
        f"{found.solved:,} frequencies solved"
    ]
    if len(found.frequencies) > 1:
        said.append("several peaks are equally high there: to lower one raises another")
    for parameter, on in zip(found.parameters, found.held, strict=True):
        if on:
            said.append(f"{shown(parameter.key)} LIES ON A BOUND: beyond it the peak may be lower")
    if not found.settled:
        said.append("NOT SETTLED: the search ended before steps promised nothing more")
    return said


def json_of(found: Optimum) -> dict[str, Any]:
    """An optimum for machines."""
    return {
        "parameters": [
            {
                "key": each.key,
                "start": each.start,
                "bounds": [each.low, each.high],
                "value": float(value),
                "on_bound": on,
            }
            for each, value, on in zip(found.parameters, found.value, found.held, strict=True)
        ],
        "largest_peak_before": found.before,
        "largest_peak": found.after,
        "frequencies": found.frequencies.tolist(),
        "amplitudes": found.amplitudes.tolist(),
        "places": found.trials,
        "frequencies_solved": found.solved,
        "settled": found.settled,
    }


def _files(
    path: Path, found: Optimum, text: str, beside: Path, listener: Listener
) -> Sequence[Path]:
    """What an optimum leaves behind."""
    keys = [each.key for each in found.parameters]
    record(path / f"{NAME}.json", json.dumps(json_of(found), indent=1))
    files = [path / f"{NAME}.json"]
    try:
        made = fitted_text(text, dict(zip(keys, found.value.tolist(), strict=True)), beside, path)
        record(path / "optimised.toml", made)
    except InputError as error:
        listener(Notice(f"optimised.toml is not written: {error}"))
        return files
    return [*files, path / "optimised.toml"]
