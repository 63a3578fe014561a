"""Check a file without computing: a scene's files and names, or what a study or a run holds."""

import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np

from vanelock.commands.check import study
from vanelock.common.errors import InputError
from vanelock.common.tables import Table, heads
from vanelock.common.toml import toml_tables
from vanelock.input.cases.sweep import cases
from vanelock.input.plausible import unusual
from vanelock.input.read_scene import ND, load_scene
from vanelock.input.read_study import is_scene, read_text
from vanelock.input.schema.scene import Scene
from vanelock.stages.matrices.gather import gathered, nodes
from vanelock.stages.matrices.hanging import RigidMotions, rigid_motions
from vanelock.stages.matrices.steps import at_rest, clamped, matrices, system_step
from vanelock.stages.parts.components import diameters

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
    if study.is_hdf5(place) or place.is_dir():
        return study.check_file(place, outside)
    if not is_scene(toml_tables(read_text(place), str(path))):
        return study.check_file(place, outside)
    rows = list(_planned(load_scene(place, outside)))
    title = f"{place}: a scene that can be run"
    return Table(title, heads("what", "found"), rows, key="check")


def _planned(scene: Scene) -> Iterator[Row]:
    found = cases(scene)
    yield "name", scene.name
    varied = ", ".join(scene.scatter.keys if scene.scatter else found[0].values)
    yield "cases", f"{len(found):,} over {varied}" if varied else "1"
    yield from (("warning", text) for text in unusual(scene))
    if scene.system is not None:
        system_step(scene).compute()
        held = study.check_file(scene.system.file)
        yield from ((f"system, {what}", str(value)) for what, value in held.rows)
        return
    given, first = gathered(scene), {}
    for name, keys in scene.components.items():
        all_of = diameters([scene]) if ND in keys.stiffness else (0,)
        read = [matrices(name, keys, k) for k in all_of]
        first[name] = read[0]
        kept = given.kept[name][0]
        if len(missing := np.setdiff1d(kept, read[0].node)):
            raise InputError(f"components.{name}: node {missing[0]} is not among its nodes")
        for side in ("fixed", "low", "high"):
            if (value := getattr(keys, side)) is not None:
                nodes(value, f"components.{name}.{side}")
        entries = ", ".join(f"{each.K.nnz:,}" for each in read)
        size = f"{read[0].size:,} rows, {entries} entries, {len(kept)} nodes kept"
        yield f"component {name}", size
    yield "contacts", f"{sum(len(each.mu) for each in given.contacts):,}"
    yield "ties, loads", f"{len(given.ties)}, {len(given.loads)}"
    yield from (("warning", text) for text in given.apart())

    @cache
    def body(name: str) -> RigidMotions:
        fixed = clamped(scene.components[name], name)
        return rigid_motions(name, first[name], fixed, given.kept[name])

    hanging = at_rest([case.given for case in found], lambda _, name, __: body(name))
    yield from (("warning", text) for text in hanging)
    yield "output nodes", f"{sum(len(each.nodes) for each in given.outputs)}"
