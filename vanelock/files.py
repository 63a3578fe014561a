"""Read a study or a scene: TOML, then the schema, then the sweep; every mistake is one clear line.

The schema is that of `vanelock.input` with a table for each analysis.
"""

import os
from collections.abc import Callable, Iterable, Iterator
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, cast

from pydantic import Field, ValidationError, create_model

from vanelock.analyses import ANALYSES
from vanelock.analyses.analysis import ALLOWED, Analysis, asked_for
from vanelock.common.checked import Check, Checked, dotted, explain
from vanelock.common.errors import InputError, raised
from vanelock.common.files.files import beside, contents
from vanelock.common.toml import LARGEST, toml_tables
from vanelock.fem.matrix_files.array_files import split_path
from vanelock.input.cases.sweep import cases
from vanelock.input.cases.values import Problem
from vanelock.input.schema import scene, study
from vanelock.input.schema.scene import FILES, ND
from vanelock.input.schema.structure.loads import files_named

S = TypeVar("S", bound=Checked)

MOST_ND = 1000
"""Nodal diameters below this are looked for."""


def _mistakes(analysis: Analysis[Any, Any], problem: Problem) -> Iterator[str]:
    """What keeps an analysis that is asked for from being made."""
    keys = None if analysis.table else analysis.keys_of(problem)
    if keys is None:
        return
    if getattr(problem, "elements", None) and not analysis.elements:
        yield f"elements: [{analysis.key}] is of contacts alone: leave one of them out"
    for key, allowed in ALLOWED.items():
        value = getattr(problem.response, key)
        if value != allowed and not analysis.any_law:
            must = "leave it out" if allowed is None else f'must be "{allowed}"'
            text = value if isinstance(value, int) else f'"{value}"'
            yield f"response.{key} = {text}: {must} for [{analysis.key}]"
    yield from analysis.check(problem, keys)


_CHECKS: tuple[Check, ...] = tuple(partial(_mistakes, each) for each in ANALYSES)


class _Study(study.Study):
    checks: ClassVar[tuple[Check, ...]] = (*study.Study.checks, *_CHECKS)


class _Scene(scene.Scene):
    checks: ClassVar[tuple[Check, ...]] = (*scene.Scene.checks, *_CHECKS)

    @property
    def whole_ring(self) -> str:
        asked = (a.table or a.key for a, k in asked_for(ANALYSES, self) if a.whole_ring(self, k))
        return next(asked, "")


def _tables(keys: Callable[[Analysis[Any, Any]], Any]) -> dict[str, Any]:
    """A field for each analysis that has a table of its own."""
    return {
        each.key: (keys(each) | None, Field(default=None, description=each.title))
        for each in ANALYSES
        if not each.table and keys(each) is not None
    }


if TYPE_CHECKING:
    from vanelock.input.schema.scene import Scene as Scene
    from vanelock.input.schema.study import Study as Study
else:
    Study = create_model(
        "Study",
        __base__=_Study,
        __doc__=study.Study.__doc__,
        __module__=__name__,
        **_tables(lambda analysis: analysis.keys),
    )
    Scene = create_model(
        "Scene",
        __base__=_Scene,
        __doc__=scene.Scene.__doc__,
        __module__=__name__,
        **_tables(lambda analysis: analysis.scene_keys),
    )
Further = Callable[[S], list[str]]
"""Lines about a table that agrees with its schema."""


def load_study(
    path: str | os.PathLike[str], outside: bool = False, also: Further[Study] = lambda study: []
) -> Study:
    """Read and check a study file.

    Parameters
    ----------
    path : path
        The study file.
    outside : bool
        Whether the files that it names may lie outside its folder.
    also : callable, optional
        What else is wrong with the study, as for `checked`.

    Raises
    ------
    InputError
        One line for each mistake: the file, the full key, the value given and what is allowed.
    """
    data = toml_tables(read_text(Path(path)), str(path))
    if is_scene(data):
        raise InputError(
            f"{path}: a scene of matrices, which run, check and compare take; this needs a study, "
            "whose parts have meshes"
        )
    return _loaded(Study, data, path, outside, _files_of_study, also)


def load_given(path: str | os.PathLike[str], outside: bool = False) -> Problem:
    """Read and check a study or a scene file, whichever it is."""
    scene = is_scene(toml_tables(read_text(Path(path)), str(path)))
    return load_scene(path, outside) if scene else load_study(path, outside)


def problem_of(stored: dict[str, Any]) -> Problem:
    """A study or a scene from what a results file holds of it: the keys that are set, in SI."""
    kind = Scene if is_scene(stored) else Study
    return kind.model_validate(stored)


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
    data = toml_tables(read_text(Path(path)), str(path))
    return _loaded(Scene, data, path, outside, _files_of_scene)


def is_scene(data: dict[str, Any]) -> bool:
    """Whether the tables of a file are a scene's, not a study's."""
    return "components" in data or "system" in data


def read_text(path: Path) -> str:
    """Text of a file."""
    try:
        return contents(path, "a study file", LARGEST).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None


def parse_study(text: str, where: str = "study") -> Study:
    """Check the text of a study file, sweep values apart; `where` is what errors call it."""
    return checked(Study, toml_tables(text, where), where)


def check_scene(data: dict[str, Any], where: str = "scene") -> Scene:
    """Check the nested tables of a scene."""
    return checked(Scene, data, where)


def checked(
    schema: type[S],
    data: dict[str, Any],
    where: str,
    refused: Iterable[str] = (),
    further: Further[S] = lambda table: [],
) -> S:
    """Nested tables as what a schema makes of them; lines of what is `refused` come first."""
    lines = [*refused]
    try:
        table = schema.model_validate(data, strict=True)
    except ValidationError as error:
        lines += explain(error, data, schema)
    else:
        lines = lines or list(dict.fromkeys(further(table)))
        if not lines:
            return table
    raise InputError("\n".join(f"{where}: {line}" for line in lines))


_NamedFile = tuple[dict[Any, Any], Any, str]
"""The table of a key that names a file, the key, and what errors call it."""


def _loaded(
    schema: type[S],
    data: dict[str, Any],
    path: str | os.PathLike[str],
    outside: bool,
    named: Callable[[dict[str, Any]], Iterable[_NamedFile]],
    also: Further[S] = lambda table: [],
) -> S:
    """A file's tables, checked; paths of files that they name start at its folder."""
    data, refused = deepcopy(data), []
    for table, key, where in named(data):
        try:
            table[key] = _place(Path(path).parent, table[key], where, outside)
        except InputError as error:
            refused.append(str(error))
    return checked(
        schema,
        data,
        str(path),
        refused,
        lambda problem: [*raised(lambda: cases(cast(Problem, problem))), *also(problem)],
    )


def _files_of_study(data: dict[str, Any]) -> Iterator[_NamedFile]:
    """Files that a study's tables name."""
    for (*path, key), _ in files_named(data):
        table: Any = data
        for name in path:
            table = table[name]
        yield table, key, dotted((*path, key))


def _files_of_scene(data: dict[str, Any]) -> Iterator[_NamedFile]:
    """Files that a scene's tables name."""
    tables: list[tuple[Any, Iterable[str], str]] = []
    for kind, of_kind in FILES.items():
        if isinstance(named := data.get(kind), dict):
            tables += [(table, of_kind, f"{kind}.{name}") for name, table in named.items()]
    loads, measured, outputs = (data.get(kind) for kind in ("loads", "measured", "outputs"))
    for i, load in enumerate(loads if isinstance(loads, list) else ()):
        tables.append((load, ("nodes", "file"), f"loads[{i}]"))
    for i, curve in enumerate(measured if isinstance(measured, list) else [measured]):
        tables.append((curve, ("file",), f"measured[{i}]"))
    if isinstance(outputs, dict) and isinstance(nodes := outputs.get("nodes"), dict):
        tables.append((nodes, nodes, "outputs.nodes"))
    tables.append((data.get("system"), ("file",), "system"))
    for table, keys, where in tables:
        for key in keys if isinstance(table, dict) else ():
            if isinstance(table.get(key), str) and table[key]:
                yield table, key, f"{where}.{key}"


def _place(folder: Path, name: str, where: str, outside: bool) -> str:
    """Where a file is; of one for each nodal diameter, every one that is there must be inside."""
    _, inside = split_path(folder / name)  # "file.h5:/group/K"
    if inside is not None:
        name = name[: -len(inside) - 1]
    if ND in name:
        before, _, after = name.partition(ND)
        for each in range(MOST_ND):
            if os.path.lexists(folder / f"{before}{each}{after.replace(ND, str(each))}"):
                beside(folder, f"{before}{each}{after.replace(ND, str(each))}", where, outside)
    place = beside(folder, name, where, outside)
    return str(place) if inside is None else f"{place}:{inside}"
