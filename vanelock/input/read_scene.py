"""Read a scene file, or a file of either kind: every mistake is one clear line."""

import os
from pathlib import Path
from typing import Any

from vanelock.common.errors import InputError
from vanelock.common.files.files import beside
from vanelock.common.toml import toml_tables
from vanelock.fem.matrix_files.readers.hdf5 import split_path
from vanelock.input.cases.values import Given
from vanelock.input.read_study import case_mistakes, checked, is_scene, load_study, read_text
from vanelock.input.schema.scene import FILES, Scene

ND = "{nd}"
"""Stands for the nodal diameter in the name of a file."""
MOST_ND = 1000
"""Nodal diameters below this are looked for."""


def load_given(path: str | os.PathLike[str], outside: bool = False) -> Given:
    """Read and check a study or a scene file, whichever it is."""
    scene = is_scene(toml_tables(read_text(Path(path)), str(path)))
    return load_scene(path, outside) if scene else load_study(path, outside)


def load_scene(path: str | os.PathLike[str], outside: bool = False) -> Scene:
    """Read and check a scene file; its files' paths start at its folder.

    Parameters
    ----------
    path : path
        The scene file.
    outside : bool
        Whether the files that it names may lie outside its folder.

    Raises
    ------
    InputError
        One line for each mistake: the file, the full key, the value given and what is allowed.
    """
    where = str(path)
    data = toml_tables(read_text(Path(path)), where)
    data, refused = _beside(data, Path(path).parent, outside)
    return checked(Scene, data, where, refused, case_mistakes)


def check_scene(data: dict[str, Any], where: str = "scene") -> Scene:
    """Check the nested tables of a scene."""
    return checked(Scene, data, where)


def _beside(data: dict[str, Any], folder: Path, outside: bool) -> tuple[dict[str, Any], list[str]]:
    """The tables with files where they are, and a line for each that may not be read."""
    refused: list[str] = []

    def placed(table: Any, keys: tuple[str, ...], where: str) -> Any:
        if not isinstance(table, dict):
            return table
        files = {}
        for k in (k for k in keys if _is_name(table.get(k))):
            try:
                files[k] = _place(folder, table[k], f"{where}.{k}", outside)
            except InputError as error:
                refused.append(str(error))
        return {**table, **files}

    found = dict(data)
    for name, keys in FILES.items():
        if isinstance(data.get(name), dict):
            found[name] = {k: placed(table, keys, f"{name}.{k}") for k, table in data[name].items()}
    if isinstance(data.get("loads"), list):
        found["loads"] = [
            placed(load, ("nodes", "file"), f"loads[{i}]") for i, load in enumerate(data["loads"])
        ]
    measured = data.get("measured")
    if isinstance(measured, dict | list):
        listed = measured if isinstance(measured, list) else [measured]
        found["measured"] = [
            placed(each, ("file",), f"measured[{i}]") for i, each in enumerate(listed)
        ]
    if isinstance(outputs := data.get("outputs"), dict) and isinstance(outputs.get("nodes"), dict):
        nodes = outputs["nodes"]
        found["outputs"] = {**outputs, "nodes": placed(nodes, tuple(nodes), "outputs.nodes")}
    if isinstance(data.get("system"), dict):
        found["system"] = placed(data["system"], ("file",), "system")
    return found, refused


def _place(folder: Path, given: str, where: str, outside: bool) -> str:
    """Where a file is; of one for each nodal diameter, every one that is there must be inside."""
    _, inside = split_path(folder / given)  # "file.h5:/group/K"
    if inside is not None:
        given = given[: -len(inside) - 1]
    if ND in given:
        before, _, after = given.partition(ND)
        for each in range(MOST_ND):
            if os.path.lexists(folder / f"{before}{each}{after.replace(ND, str(each))}"):
                beside(folder, f"{before}{each}{after.replace(ND, str(each))}", where, outside)
    place = beside(folder, given, where, outside)
    return str(place) if inside is None else f"{place}:{inside}"


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and bool(value)
