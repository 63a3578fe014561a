"""`vanelock optimise`: values of joints with which the largest peak of a study is the smallest."""

import json
import os
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vanelock.analyses.bounds import BOUNDS, BoundsKeys
from vanelock.commands.fit.fit import write_fitted
from vanelock.commands.fit.parameters import by_key, varied_parameters
from vanelock.commands.fit.refit_model import rejoined
from vanelock.commands.optimise.bound import BOUND, least_bound
from vanelock.commands.optimise.front import (
    NAME,
    cases_table,
    front,
    front_table,
    json_of,
    notes,
    optimum_table,
)
from vanelock.commands.optimise.objective import Peaks
from vanelock.commands.optimise.search import ROUNDS, TOLERANCE, Optimum, optimum
from vanelock.common.errors import InputError
from vanelock.common.tables import counted
from vanelock.input.cases.sweep import Case, cases
from vanelock.input.cases.values import with_values
from vanelock.input.schema.study import Study
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Begun, Failed, Finished, Listener, Notice, silent
from vanelock.pipeline.step import Stages
from vanelock.results.files.run_folder import claimed, record
from vanelock.stages.response.limits import frequencies

FRONT_POINTS = 6
"""Of the front of peak against wear: enough to show its bend, each some tens of trials."""
VARIED = ("sweep", "rows", "scatter")
"""What makes several cases of a study, of which the optimised one is the best."""


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
        The study; each of its cases has an optimum of its own.
    folder : path
        A run's folder; meshes and reduced parts there are used again. `optimise.json` and
        `optimised.toml` go there.
    listener : callable
        Called with stages, trials, notices and tables.
    text : str
        The study file's text, which `optimised.toml` keeps but for the new values.
    beside : path
        The folder that files named in the text are relative to.

    Returns
    -------
    Optimum
        The smallest one, of several cases.

    Raises
    ------
    InputError
        If there is nothing to vary, no peak lies in the range, or the folder cannot be used.
    """
    if study.optimise is None:
        raise InputError("optimise: the study has no [optimise] table, which names what to vary")
    path, began = Path(folder), time.perf_counter()
    every = cases(study)
    for key in study.optimise.parameters:
        if key in every[0].values:
            raise InputError(
                f"optimise.parameters: {key} is swept, too: sweep it or vary it here, not both"
            )
    for case in every:
        varied_parameters(case.study, "optimise")
    found: list[tuple[Case, Optimum]] = []
    with claimed(path):
        stages = Stages(Cache(path / "cache", lambda message: listener(Notice(message))), listener)
        for case in every:
            try:
                found.append((case, _case_optimum(case, stages, listener)))
            except InputError as error:
                if len(every) == 1:
                    raise
                listener(Failed(case.name, str(error), 1))
        if not found:
            raise InputError("optimise: no case has a peak in its range of frequencies")
        if len(found) > 1:
            listener(cases_table(found, study.name))
        files = _files(path, found, text, Path(beside), listener)
    best = lowest(found)[1]
    summary = {"optimum": json_of(best), "files": [str(each) for each in files]}
    listener(Finished(str(path), time.perf_counter() - began, summary))
    return best


def _case_optimum(case: Case, stages: Stages, listener: Listener = silent) -> Optimum:
    """The optimum of a case; its tables go to the listener."""
    study = case.study
    keys, name = study.optimise, ", ".join([study.name, *[case.name] * bool(case.values)])
    assert keys is not None
    parameters = varied_parameters(study, "optimise")
    model = rejoined(study, stages, listener)
    asked = np.asarray(frequencies(study, stages.get(model.planned.linear.limits)))
    near = float(asked.min()), float(asked.max())
    listener(Begun(f"largest peak over {counted(len(parameters), 'parameter')}"))
    peaks = Peaks(model, parameters, near)
    found = optimum(peaks, keys.starts, listener)
    peaks, found = _corrected(peaks, found, study, stages, listener)
    if keys.of == BOUND:
        bounds = BOUNDS.keys_of(study) or BoundsKeys()
        listener(Notice(f"with assembled joints: {notes(found)[0]}"))
        listener(Begun("upper bound of the peak"))
        found = least_bound(
            peaks, found, lambda x: peaks.model.bounds(peaks.values(x), near, bounds), listener
        )
    listener(optimum_table(found, name))
    if keys.of == "peak and wear":
        listener(Begun(f"front of largest peak against wear, {FRONT_POINTS} points"))
        known = study.wear_coefficients, FRONT_POINTS, keys.starts
        found = replace(found, front=tuple(front(peaks, found, *known, listener)))
        listener(front_table(found, name))
    return found


def _corrected(
    peaks: Peaks, best: Optimum, study: Study, stages: Stages, listener: Listener = silent
) -> tuple[Peaks, Optimum]:
    """An optimum whose mesh correction is that of its own joints, and its peaks.

    What a mesh adds to the stiffness depends on the stiffness of contacts, by which the shapes
    change along which it is taken off. The search holds it; where it is another at the optimum, the
    search goes on with that, until it leads no further.
    """
    for _ in range(ROUNDS):
        values = by_key(best.parameters, best.value)
        model = rejoined(with_values(study, values), stages)
        if model.reduced == peaks.model.reduced:
            return peaks, best
        begun = [replace(each, start=values[each.key]) for each in best.parameters]
        peaks = Peaks(model, begun, peaks.near)
        listener(Begun("largest peak with the mesh correction of these joints"))
        try:
            again = optimum(peaks, 0, listener)
        except InputError:
            listener(Notice("with the mesh correction of these joints no peak lies in the range"))
            break
        best = replace(
            again,
            parameters=best.parameters,
            before=best.before,
            trials=best.trials + again.trials,
            solved=best.solved + again.solved,
            screened=best.screened,
        )
        if again.after > (1 - TOLERANCE) * again.before:
            return peaks, best
    return peaks, replace(best, settled=False)


def lowest(optima: Sequence[tuple[Case, Optimum]]) -> tuple[Case, Optimum]:
    """The case whose optimum is the smallest."""
    return min(optima, key=lambda pair: pair[1].after)


def _files(
    path: Path,
    by_case: Sequence[tuple[Case, Optimum]],
    text: str,
    beside: Path,
    listener: Listener,
) -> list[Path]:
    """What optima leave behind: all of them, and the text of the study with the smallest."""
    case, best = lowest(by_case)
    content = json_of(best)
    if len(by_case) > 1:
        every = [{"case": each.name, **json_of(optimum)} for each, optimum in by_case]
        content = {"case": case.name, **content, "cases": every}
    record(path / f"{NAME}.json", json.dumps(content, indent=1))
    values = {**case.values, **by_key(best.parameters, best.value)}
    made = write_fitted(path / "optimised.toml", text, values, beside, listener, VARIED)
    return [path / f"{NAME}.json", *made]
