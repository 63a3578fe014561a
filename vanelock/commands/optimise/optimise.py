"""`vanelock optimise`: values of joints with which the largest peak of a study is the smallest."""

import json
import os
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vanelock.commands.fit.fit import fitted_text, model_of, planned_alone, unswept
from vanelock.commands.fit.parameters import varied_parameters
from vanelock.commands.optimise.bound import BOUND, least_bound
from vanelock.commands.optimise.front import front
from vanelock.commands.optimise.peaks import Peaks
from vanelock.commands.optimise.search import Optimum, optimum
from vanelock.commands.optimise.tables import (
    NAME,
    front_table,
    json_of,
    notes,
    optimum_table,
)
from vanelock.common.errors import InputError
from vanelock.common.tables import counted
from vanelock.input.schema.assessment.bounds_and_stability import BoundsKeys
from vanelock.input.schema.study import Study
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Begun, Finished, Listener, Notice, silent
from vanelock.pipeline.step import Stages
from vanelock.results.files.run_folder import claimed, record
from vanelock.stages.response.limits import frequencies


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
    path, began = Path(folder), time.perf_counter()
    keys = study.optimise
    study = unswept(study, listener)
    parameters = varied_parameters(study, "optimise")
    with claimed(path):
        stages = Stages(Cache(path / "cache", lambda message: listener(Notice(message))), listener)
        planned = planned_alone(study, stages, listener)
        wanted = np.asarray(frequencies(study, stages.get(planned.linear.limits)))
        near = float(wanted.min()), float(wanted.max())
        model = model_of(planned, stages)
        listener(Begun(f"largest peak over {counted(len(parameters), 'parameter')}"))
        peaks = Peaks(model, parameters, near)
        found = optimum(peaks, keys.starts, listener)
        if keys.of == BOUND:
            asked = study.bounds or BoundsKeys()
            listener(Notice(f"with assembled joints: {notes(found)[0]}"))
            listener(Begun("upper bound of the peak"))
            found = least_bound(
                peaks,
                found,
                lambda x: model.bounds(peaks.values(x), near, asked),
                listener,
            )
        listener(optimum_table(found, study.name))
        if keys.front:
            listener(Begun(f"front of largest peak against wear, {counted(keys.front, 'point')}"))
            known = study.wear_coefficients, keys.front, keys.starts
            found = replace(found, front=tuple(front(peaks, found, *known, listener)))
            listener(front_table(found, study.name))
        files = _files(path, found, text, Path(beside), listener)
    summary = {"optimum": json_of(found), "files": [str(each) for each in files]}
    listener(Finished(str(path), time.perf_counter() - began, summary))
    return found


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
