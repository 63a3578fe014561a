"""Cases of a scene: the product of the swept keys' values, each checked as the key itself is."""

import re
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from typing import Any

from pydantic import ValidationError

from vanelock.common.checked import UNCHECKED, NotKnown
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import LARGEST, short_names, shown_value, value_mistakes
from vanelock.input.messages import explain
from vanelock.input.schema.scene import FILES, Scene

APART = ("sweep", "name", "outputs")
"""Tables that cannot be swept."""
NAMES = {name for names in FILES.values() for name in names}
"""Keys of files, which cannot be swept either: their places are checked once."""
_STEP = re.compile(r"([A-Za-z0-9_-]+)((?:\[\d+\])*)")


@dataclass(frozen=True)
class SceneCase:
    """One point of a sweep: its name, the swept keys' values, and the scene with them."""

    name: str
    values: dict[str, float | str]
    scene: Scene


def scene_cases(scene: Scene) -> tuple[SceneCase, ...]:
    """Every case, the last key running fastest; one called "nominal" where nothing is swept.

    Raises
    ------
    InputError
        One line for each swept key or value that the scene could not hold.
    """
    if not scene.sweep:
        return (SceneCase("nominal", {}, scene),)
    if wrong := sweep_mistakes(scene):
        raise InputError("\n".join(wrong))
    count = 1
    for values in scene.sweep.values():
        count *= len(values)
    if count > LARGEST:
        raise InputError(f"sweep: {count} cases: at most {LARGEST} are allowed")
    names, found = short_names(list(scene.sweep)), []
    for combination in product(*scene.sweep.values()):
        chosen = dict(zip(scene.sweep, combination, strict=True))
        changed = _with(scene, chosen)
        reached = {key: _at(changed, key) for key in chosen}
        name = ",".join(f"{names[key]}={shown_value(value)}" for key, value in reached.items())
        found.append(SceneCase(name, reached, changed))
    return tuple(found)


def sweep_mistakes(scene: Scene, context: str | None = None) -> list[str]:
    """What is wrong with the lists of a scene's sweep.

    Parameters
    ----------
    scene : Scene
        It may lack keys whose values are wrong.
    context : str, optional
        "unchecked" looks at each value by itself, without its combination with others.
    """
    found: list[str] = []
    with suppress(NotKnown):
        for key, values in scene.sweep.items():
            found += _mistakes(scene, key, values, context)
    return found


def _mistakes(scene: Scene, key: str, values: tuple[Any, ...], context: str | None) -> list[str]:
    where = f'sweep."{key}"'
    if key.partition(".")[0] in APART or key.rpartition(".")[2] in NAMES or _path(key) is None:
        return [f"{where}: this key cannot be swept"]
    return value_mistakes(where, values, lambda v: _at(_with(scene, {key: v}, context), key))


def _path(key: str) -> list[str | int] | None:
    """Names and places on the way to a key; None where it is not written as one."""
    path: list[str | int] = []
    for word in key.split("."):
        found = _STEP.fullmatch(word)
        if found is None:
            return None
        path += [found[1], *(int(i) for i in re.findall(r"\d+", found[2]))]
    return path


def _with(scene: Scene, changes: dict[str, Any], context: str | None = None) -> Scene:
    data = scene.model_dump(
        exclude_unset=True,
        exclude={"sweep"},
        warnings=context != UNCHECKED,  # where keys are missing
    )
    data["loads"] = [dict(load) for load in data.get("loads", ())]
    for key, value in changes.items():
        *path, last = _path(key) or [key]
        _refuse_unknown(data, path)
        table: Any = data
        for item in path:
            try:
                table = table.setdefault(item, {}) if isinstance(item, str) else table[item]
            except (AttributeError, IndexError, TypeError):
                raise InputError(f"{key}: there is nothing of that name to sweep") from None
        if not isinstance(table, dict) or isinstance(last, int):
            raise InputError(f"{key}: there is nothing of that name to sweep")
        table[last] = value
    try:
        return Scene.model_validate(data, strict=True, context=context)
    except ValidationError as error:
        raise InputError(explain(error, data, Scene)[0]) from None


def _refuse_unknown(data: dict[str, Any], path: list[str | int]) -> None:
    """A named table that is not there cannot be swept; others come with their defaults."""
    if len(path) > 1 and path[0] in ("components", "contacts", "ties"):
        have = data.get(path[0], {})
        if path[1] not in have:
            raise InputError(f"no {path[0]}.{path[1]}; there are {', '.join(have) or 'none'}")


def _at(scene: Scene, key: str) -> Any:
    value: Any = scene
    for item in _path(key) or []:
        if isinstance(item, int) or isinstance(value, dict):
            value = value[item]
        else:
            value = getattr(value, item, None)
    return value
