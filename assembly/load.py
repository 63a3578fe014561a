"""Read a scene file: TOML, then the schema; every mistake is one clear line."""

import os
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from vanelock.assembly.model import Scene
from vanelock.errors import InputError
from vanelock.study.messages import explain
from vanelock.study.read import read_text, toml_tables

FILES = {
    "components": ("stiffness", "mass", "damping", "dofs", "nodes", "fixed", "low", "high"),
    "contacts": ("pairs",),
    "ties": ("pairs",),
}
"""Keys of named tables that may hold a file's name."""


def is_scene(data: dict[str, Any]) -> bool:
    """Whether the tables of a file are a scene's, not a study's."""
    return "components" in data or "system" in data


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read and check a scene file; its files' paths start at its folder.

    Raises
    ------
    InputError
        One line for each mistake: the file, the full key, the value given and what is allowed.
    """
    where = str(path)
    data = toml_tables(read_text(Path(path)), where)
    return check_scene(_beside(data, Path(path).parent), where)


def check_scene(data: dict[str, Any], where: str = "scene") -> Scene:
    """Check the nested tables of a scene."""
    try:
        return Scene.model_validate(data, strict=True)
    except ValidationError as error:
        lines = explain(error, data, Scene)
        raise InputError("\n".join(f"{where}: {line}" for line in lines)) from None


def _beside(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tables with files where they are."""

    def placed(table: Any, keys: tuple[str, ...]) -> Any:
        if not isinstance(table, dict):
            return table
        files = {k: str(folder / table[k]) for k in keys if _is_name(table.get(k))}
        return {**table, **files}

    found = dict(data)
    for name, keys in FILES.items():
        if isinstance(data.get(name), dict):
            found[name] = {key: placed(table, keys) for key, table in data[name].items()}
    if isinstance(data.get("loads"), list):
        found["loads"] = [placed(load, ("nodes",)) for load in data["loads"]]
    if isinstance(outputs := data.get("outputs"), dict) and isinstance(outputs.get("nodes"), dict):
        nodes = outputs["nodes"]
        found["outputs"] = {**outputs, "nodes": placed(nodes, tuple(nodes))}
    if isinstance(data.get("system"), dict):
        found["system"] = placed(data["system"], ("file",))
    return found


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and bool(value)
