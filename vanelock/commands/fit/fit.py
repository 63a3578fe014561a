"""`vanelock fit`: parameters of a study fitted to its measured curves, and what came of it."""

import json
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vanelock import render
from vanelock.commands.fit.least_squares import enough, fit
from vanelock.commands.fit.parameters import FitParameter, by_key, in_words, varied_parameters
from vanelock.commands.fit.refit_model import Rejoined, rejoined
from vanelock.commands.fit.solution import FitSolution
from vanelock.commands.fit.tables import fit_table, json_of
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import write_columns
from vanelock.common.tables import counted
from vanelock.common.toml import toml_tables
from vanelock.input.cases.values import with_values
from vanelock.input.measured.curve import Measured, load_measured
from vanelock.input.measured.units import DISPLACEMENT
from vanelock.input.rewrite import rewritten
from vanelock.input.schema.structure.loads import files_named
from vanelock.input.schema.study import Study
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Begun, Finished, Listener, Notice, silent
from vanelock.pipeline.step import Stages
from vanelock.results.files.run_folder import claimed, record

NAME = "fit"
FINE = 160
"""Frequencies of the curves drawn, beside the measured ones."""
MISSED = 0.5
"""Standard deviations of a point that neglected harmonics may change it by without a word."""
DIGITS = 6
"""Of the values written to the study's text."""


def fit_study(
    study: Study,
    folder: str | os.PathLike[str],
    listener: Listener = silent,
    text: str = "",
    beside: str | os.PathLike[str] = ".",
) -> FitSolution:
    """Fit what `[fit]` names to the curves of `[[measured]]`.

    Parameters
    ----------
    study : Study
        The study; of swept keys the unswept values count.
    folder : path
        A run's folder; meshes and reduced parts there are used again. `fit.json`, `fitted.toml`,
        `figures/fit.png` and `.csv` go there.
    listener : callable
        Called with stages, starts, notices and tables.
    text : str
        The study file's text, which `fitted.toml` keeps but for the fitted values.
    beside : path
        The folder that files named in the text are relative to.

    Raises
    ------
    InputError
        If there is nothing to fit, a measured curve cannot be read, or the folder not be used.
    """
    if study.fit is None:
        raise InputError("fit: the study has no [fit] table, which names what to fit")
    path, began, starts = Path(folder), time.perf_counter(), study.fit.starts
    curves = _usable(study, load_measured(study), listener)
    if study.sweep or study.rows or study.scatter:
        listener(Notice("keys that vary have their own value"))
        study = with_values(study, {})
    parameters = varied_parameters(study, "fit")
    enough(sum(len(each.amplitude) for each in curves), len(parameters))
    with claimed(path):
        stages = Stages(Cache(path / "cache", lambda message: listener(Notice(message))), listener)
        model = rejoined(study, stages, listener)
        found = _fitted(model, curves, parameters, starts, listener)
        said = [*remarks(model, curves, found), *_other_correction(model, curves, found, stages)]
        found = replace(found, remarks=tuple(said))
        listener(fit_table(found, study.name))
        files = _files(path, model, curves, found, text, Path(beside), listener)
    summary = {"fitted": json_of(found), "files": [str(each) for each in files]}
    listener(Finished(str(path), time.perf_counter() - began, summary))
    return found


def _usable(study: Study, curves: Sequence[Measured], listener: Listener) -> list[Measured]:
    """Curves of the study's own engine order."""
    order = abs(study.excitation.engine_order)
    own = [each for each in curves if each.engine_order == order]
    for each in curves:
        if each not in own:
            listener(Notice(f"{each.name}: engine order {each.engine_order} is not the study's"))
    if not own:
        raise InputError(f"fit: no measured curve is of engine order {order}")
    known = [each.sigma is not None for each in own]
    if any(known) and not all(known):
        name = own[known.index(False)].name
        raise InputError(f"fit: {name} has no sigma while others have: give it for all or for none")
    return own


def _fitted(
    model: Rejoined,
    curves: Sequence[Measured],
    parameters: Sequence[FitParameter],
    starts: int,
    listener: Listener,
) -> FitSolution:
    keys = [each.key for each in parameters]
    listener(Begun(f"fit of {counted(len(keys), 'parameter')} to {counted(len(curves), 'curve')}"))

    def predict(values: Floats) -> Floats:
        chosen = by_key(parameters, values)
        return np.concatenate([model.amplitudes(chosen, curve) for curve in curves])

    def slopes(values: Floats) -> Floats:
        chosen = by_key(parameters, values)
        return np.concatenate([model.slopes(chosen, keys, curve) for curve in curves])

    def named(curve: Measured, hertz: float) -> str:
        return f"{hertz:.6g} Hz" + (f" of {curve.label}" if len(curves) > 1 else "")

    data = np.concatenate([curve.amplitude for curve in curves])
    spread = np.concatenate([_spread(curve) for curve in curves])
    known = curves[0].sigma is not None
    names = [[named(each, f) for f in each.frequency] for each in curves]
    return fit(predict, data, spread, parameters, starts, known, listener, names, slopes)


def _spread(curve: Measured) -> Floats:
    """Standard deviations of a curve's points, or, not known, its largest amplitude for each."""
    size = curve.amplitude.max() if curve.sigma is None else curve.sigma
    return np.full(len(curve.amplitude), size)


def remarks(model: Rejoined, curves: Sequence[Measured], solution: FitSolution) -> Iterator[str]:
    """Jumps among the points, and harmonics that are missed by more than the points scatter."""
    after = by_key(solution.parameters, solution.value)
    for curve in curves:
        for low, high in map(sorted, model.jumps(after, curve)):
            yield (
                f"A JUMP LIES AMONG THE POINTS: the fitted {curve.label} jumps between {low:.6g} "
                f"and {high:.6g} Hz: points there decide by the side that they are on"
            )
        if curve.quantity != DISPLACEMENT:
            continue
        size = model.amplitudes(after, curve)
        missed = model.neglected(after, curve) * size / (solution.scale * _spread(curve))
        missed = np.where(np.isnan(missed) & np.isfinite(size), np.inf, np.nan_to_num(missed))
        if text := _beyond_scatter(curve, missed):
            yield (
                f"HARMONICS ARE TOO FEW: those above {model.study.response.harmonics} change {text}"
                ": raise response.harmonics"
            )


def _beyond_scatter(curve: Measured, share: Floats) -> str:
    """Where a change is largest over the scatter of a curve's points; empty if it is within."""
    worst = int(share.argmax())
    by = f"{share[worst]:.2g} standard deviations of the points"
    by = by if np.isfinite(share[worst]) else "an unknown amount"
    text = f"the fitted {curve.label} at {curve.frequency[worst]:.6g} Hz by {by}"
    return text if share[worst] > MISSED else ""


def _other_correction(
    model: Rejoined, curves: Sequence[Measured], solution: FitSolution, stages: Stages
) -> Iterator[str]:
    """Whether the mesh correction of the fitted joints changes points by more than they scatter."""
    after = by_key(solution.parameters, solution.value)
    joints = {key: value for key, value in after.items() if key.startswith("joints.")}
    there = rejoined(with_values(model.study, joints), stages)
    if there.reduced == model.reduced:
        return
    for curve in curves:
        change = there.amplitudes(after, curve) - model.amplitudes(after, curve)
        moved = np.nan_to_num(np.abs(change) / (solution.scale * _spread(curve)))
        if text := _beyond_scatter(curve, moved):
            yield (
                "THE MESH CORRECTION IS THAT OF THE STUDY'S JOINTS: that of the fitted ones "
                f"changes {text}: fit fitted.toml, too"
            )


def _files(
    path: Path,
    model: Rejoined,
    curves: Sequence[Measured],
    solution: FitSolution,
    text: str,
    beside: Path,
    listener: Listener,
) -> list[Path]:
    """Everything that a fit leaves behind."""
    after = by_key(solution.parameters, solution.value)
    panels = [_panel(model, curve, after) for curve in curves]
    title = f"{model.study.name}: fit to measured curves"
    values = in_words(solution.parameters, solution.value, " = ")
    picture = render.fit_picture(path / "figures" / f"{NAME}.png", panels, title, values)
    columns: dict[str, Any] = {}
    for curve, panel in zip(curves, panels, strict=True):
        columns |= {
            f"frequency (Hz): {curve.name}": panel.frequency,
            f"measured ({panel.unit}): {curve.name}": 1e6 * panel.amplitude,
            f"fitted minus measured ({panel.unit}): {curve.name}": 1e6 * panel.remainder,
            f"curve frequency (Hz): {curve.name}": panel.hertz,
            f"study ({panel.unit}): {curve.name}": 1e6 * panel.before,
            f"fitted ({panel.unit}): {curve.name}": 1e6 * panel.after,
        }
    table = write_columns(path / "figures" / f"{NAME}.csv", columns, [title, values])
    record(path / f"{NAME}.json", json.dumps(json_of(solution), indent=1))
    files = [picture, table, path / f"{NAME}.json"]
    return files + write_fitted(path / "fitted.toml", text, after, beside, listener)


def write_fitted(
    path: Path,
    text: str,
    values: Mapping[str, float | str],
    beside: Path,
    listener: Listener,
    without: Iterable[str] = (),
) -> list[Path]:
    """Write the study's text with fitted values, if that can be; what was written."""
    changes: dict[Any, float | str] = {
        key: value if isinstance(value, str) else float(f"{value:.{DIGITS}g}")
        for key, value in values.items()
    }
    try:
        for location, file in files_named(toml_tables(text, "study")):
            if not os.path.isabs(file):  # so that it is reachable from another folder
                place = os.path.relpath(beside / file, path.parent)
                changes[location] = place.replace(os.sep, "/")
        made = rewritten(text, changes, without)
        record(path, made)
    except InputError as error:
        listener(Notice(f"{path.name} is not written: {error}"))
        return []
    if any(file.startswith("..") for _, file in files_named(toml_tables(made, "study"))):
        listener(Notice(f"{path.name} names files outside its folder: run it with --allow-outside"))
    return [path]


def _panel(model: Rejoined, curve: Measured, after: dict[str, float]) -> render.FitPanel:
    low, high = float(curve.frequency[0]), float(curve.frequency[-1])
    hertz = np.unique(np.concatenate([curve.frequency, np.linspace(low, high, FINE)]))
    fitted = model.amplitudes(after, curve, hertz)
    at = np.searchsorted(hertz, curve.frequency)
    return render.FitPanel(
        name=curve.label,
        unit="µm" if curve.quantity == DISPLACEMENT else "µm/m",
        frequency=curve.frequency,
        amplitude=curve.amplitude,
        sigma=curve.sigma,
        remainder=fitted[at] - curve.amplitude,
        hertz=hertz,
        before=model.amplitudes({}, curve, hertz),
        after=fitted,
    )
