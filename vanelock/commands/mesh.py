"""The meshes of a study by themselves: files, figures, counts and a picture, nothing computed."""

import os
import time
from pathlib import Path
from typing import Any

from vanelock import mesh, render
from vanelock.common.files.csv_table import write_columns
from vanelock.input.cases.sweep import cases
from vanelock.input.schema.structure.own_mesh import refuse_without_areas
from vanelock.input.schema.study import Study
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Finished, Listener, Notice, silent
from vanelock.pipeline.step import Stages
from vanelock.quantities import meshes
from vanelock.quantities.meshes import Figures, figures
from vanelock.results.files.run_folder import claimed
from vanelock.stages.parts.components import PARTS, mesh_step

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
        Called with stages, notices and tables.

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
        stages = Stages(Cache(path / "cache", lambda text: listener(Notice(text))), listener)
        steps = {name: mesh_step(study, name) for name in PARTS}
        if any(
            mesh_step(c.study, name).key != steps[name].key for c in cases(study) for name in PARTS
        ):
            listener(Notice("the sweep changes the geometry; these meshes have the unswept values"))
        parts = {name: stages.get(step) for name, step in steps.items()}
        refuse_without_areas(study, parts["vane"])
        found = {name: figures(part) for name, part in parts.items()}
        tables = (
            meshes.quality_table(
                parts,
                found,
                {name: getattr(study.material, name).rho for name in parts},
                {name: stages.done[step.key].seconds for name, step in steps.items()},
            ),
            meshes.sets_table(parts, study.mesh.face_nodes),
        )
        files = []
        for name, part in parts.items():
            files.append(render.write_vtu(path / FOLDER / f"{name}.vtu", part))
            files.append(mesh.write_msh(path / FOLDER / f"{name}.msh", part))
        for table in tables:
            columns: dict[str, Any] = {
                column.name: [row[i] for row in table.shown]
                for i, column in enumerate(table.columns)
            }
            files.append(write_columns(path / FOLDER / f"{table.key}.csv", columns))
            listener(table)
        title = f"{study.name}: mesh"  # last: a machine without OpenGL has the rest by then
        files.append(render.mesh_picture(path / FOLDER / "mesh.png", *parts.values(), title))
    summary = {"files": [str(file) for file in files]}
    listener(Finished(str(path / FOLDER), time.perf_counter() - began, summary))
    return found
