"""The meshes of a study by themselves: files, figures, counts and a picture, nothing computed."""

import os
import time
from pathlib import Path

from vanelock import mesh, render
from vanelock.mesh import CasingDimensions, Part, VaneDimensions
from vanelock.study import inventory
from vanelock.study.cache import Cache
from vanelock.study.figures import Figures, figures
from vanelock.study.folder import claimed, record
from vanelock.study.meshes import mesh_step
from vanelock.study.model import Study
from vanelock.study.own_mesh import refuse_without_areas
from vanelock.study.progress import Finished, Listener, Notice, silent
from vanelock.study.stages import PARTS
from vanelock.study.steps import Stages
from vanelock.study.sweep import cases

FOLDER = "mesh"
"""Where the files go, in the run's folder."""


def mesh_study(
    study: Study, folder: str | os.PathLike[str], listener: Listener = silent
) -> dict[str, Figures]:
    """Mesh both parts of a study, or take them from what a run left in the folder.

    Parameters
    ----------
    study : Study
        Whose meshes; swept dimensions have their unswept values.
    folder : path
        A run's folder. `mesh/` in it receives for each part a `.vtu` and a `.msh` file with the
        node sets, and `quality.csv`, `sets.csv` and `mesh.png` for both.
    listener : callable
        Told about stages, notices and tables.

    Returns
    -------
    dict of str to Figures
        The figures of "vane" and "casing".

    Raises
    ------
    InputError
        If a part cannot be meshed, or the folder not be used.
    """
    path = Path(folder)
    began = time.perf_counter()
    with claimed(path):
        stages = Stages(Cache(path / "cache", lambda told: listener(Notice(told))), listener)
        steps = {name: mesh_step(study, name) for name in PARTS}
        if any(
            mesh_step(c.study, name).key != steps[name].key for c in cases(study) for name in PARTS
        ):
            listener(Notice("the sweep changes the geometry; these meshes have the unswept values"))
        parts = {name: stages.get(step) for name, step in steps.items()}
        refuse_without_areas(study, parts["vane"])
        found = {name: figures(part) for name, part in parts.items()}
        tables = (
            inventory.quality_table(
                parts,
                found,
                {name: getattr(study.material, name).rho for name in parts},
                {name: stages.done[step.key].seconds for name, step in steps.items()},
            ),
            inventory.sets_table(parts, study.mesh.face_nodes),
        )
        files = _meshes(path / FOLDER, parts)
        for table in tables:
            files.append(path / FOLDER / f"{table.key}.csv")
            record(files[-1], inventory.csv_text(table))
            listener(table)
        files += _pictures(path / FOLDER, study, parts)
    told = {"files": [str(file) for file in files]}
    listener(Finished(str(path / FOLDER), time.perf_counter() - began, told))
    return found


def _meshes(folder: Path, parts: dict[str, Part]) -> list[Path]:
    made = []
    for name, part in parts.items():
        made.append(render.write_vtu(folder / f"{name}.vtu", part))
        made.append(mesh.write_msh(folder / f"{name}.msh", part))
    return made


def _pictures(folder: Path, study: Study, parts: dict[str, Part]) -> list[Path]:
    """Of the meshes, and drawings of parts with dimensions.

    Last of all: a machine without OpenGL has the rest by then.
    """
    made = []
    vane, casing = study.vane, study.casing
    if isinstance(vane, VaneDimensions) and isinstance(casing, CasingDimensions):
        sheet = (vane, casing, study.ring.sectors, study.name)
        made.append(render.vane_drawing(folder / "drawing_vane.png", *sheet))
        made.append(render.casing_drawing(folder / "drawing_casing.png", *sheet))
    title = f"{study.name}: mesh"
    return [*made, render.mesh_picture(folder / "mesh.png", *parts.values(), title)]
