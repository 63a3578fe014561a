"""Check a file without computing: a scene's files and names, or what a study or a run holds."""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vanelock.assembly.cases import scene_cases
from vanelock.assembly.gather import gathered, nodes
from vanelock.assembly.load import ND, is_scene, load_scene
from vanelock.assembly.model import Scene
from vanelock.assembly.steps import diameters, matrices
from vanelock.errors import InputError
from vanelock.study import checking
from vanelock.study.plausible import unusual
from vanelock.study.read import read_text
from vanelock.study.tables import Column, Table
from vanelock.toml import toml_tables

Row = tuple[str, str]


def check_file(path: str | os.PathLike[str], outside: bool = False) -> Table:
    """Check a scene or study file, a results file or a run's folder, or a joined system.

    Parameters
    ----------
    path : path
        The file; a folder stands for the results in it.
    outside : bool
        Whether the files that it names may lie outside its folder.

    Returns
    -------
    Table
        What would be computed, or what is there.

    Raises
    ------
    InputError
        As running it, or comparing the results, would.
    """
    place = Path(path)
    if checking.is_hdf5(place) or place.is_dir():
        return checking.check_file(place, outside)
    if not is_scene(toml_tables(read_text(place), str(path))):
        return checking.check_file(place, outside)
    rows = list(_planned(load_scene(place, outside)))
    title = f"{place}: a scene that can be run"
    return Table("check", title, (Column("what", "what"), Column("found", "found")), tuple(rows))


def _planned(scene: Scene) -> Iterator[Row]:
    cases = scene_cases(scene)
    yield "name", scene.name
    swept = ", ".join(cases[0].values)
    yield "cases", f"{len(cases):,} over {swept}" if swept else "1"
    yield from (("careful", text) for text in unusual(scene))
    if scene.system is not None:
        found = checking.check_file(scene.system.file)
        yield from ((f"system, {what}", str(told)) for what, told in found.rows)
        return
    given = gathered(scene)
    for name, keys in scene.components.items():
        all_of = diameters(scene) if ND in keys.stiffness else (0,)
        read = [matrices(name, keys, k) for k in all_of]
        kept = given.kept[name][0]
        if len(missing := np.setdiff1d(kept, read[0].node)):
            raise InputError(f"components.{name}: node {missing[0]} is not among its nodes")
        for side in ("fixed", "low", "high"):
            if (value := getattr(keys, side)) is not None:
                nodes(value, f"components.{name}.{side}")
        entries = ", ".join(f"{each.K.nnz:,}" for each in read)
        told = f"{read[0].size:,} rows, {entries} entries, {len(kept)} nodes kept"
        yield f"component {name}", told
    yield "contacts", f"{sum(len(each.mu) for each in given.contacts):,}"
    yield "ties, loads", f"{len(given.ties)}, {len(given.loads)}"
    yield from (("careful", text) for text in given.apart())
    yield "output nodes", f"{sum(len(own) for _, own in given.outputs)}"
