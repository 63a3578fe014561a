"""Check a scene's files and names without computing."""

from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

from vanelock.commands.check.stored import Row, stored
from vanelock.commands.check.study import of_curves
from vanelock.common.errors import InputError, raised
from vanelock.common.tables import counted
from vanelock.fem.matrix_files import Matrices
from vanelock.input.cases.sweep import cases
from vanelock.input.cases.values import diameters_of
from vanelock.input.measured.curve import curve_mistakes, load_measured
from vanelock.input.schema.scene import ND, ComponentKeys, Scene
from vanelock.input.settings import unusual
from vanelock.stages.matrices.gather import gathered, nodes
from vanelock.stages.matrices.hanging import RigidMotions, rigid_motions
from vanelock.stages.matrices.piece import on_rows
from vanelock.stages.matrices.pieces import clamped, matrices, refuse_unknown
from vanelock.stages.matrices.scene_structure import SceneStructure, at_rest
from vanelock.stages.parts.load_lines import load_lines
from vanelock.stages.response.responses import output_of


def planned_scene(scene: Scene) -> Iterator[Row]:
    """What a scene would compute, by rows."""
    found = cases(scene)
    yield "name", scene.name
    varied = ", ".join(scene.scatter.keys if scene.scatter else found[0].values)
    yield "cases", f"{len(found):,} over {varied}" if varied else "1"
    yield from (("warning", text) for text in unusual(scene))
    mistakes = curve_mistakes(scene)
    curves = () if mistakes else load_measured(scene)
    if scene.system is not None:
        system = SceneStructure(scene).system(()).compute()
        rows, _ = stored(Path(scene.system.file))
        names = system.output_names
        mistakes += raised(lambda: output_of(scene.outputs.monitor, names, system.sectors))
        _refuse(mistakes)
        yield from ((f"system, {what}", value) for what, value in rows)
        yield from of_curves(curves)
        return
    given, first = gathered(scene), {}
    for name, keys in scene.components.items():
        all_of = diameters_of(scene) if ND in keys.stiffness else (0,)
        try:
            read = [matrices(name, keys, k) for k in all_of]
        except InputError as error:
            mistakes += str(error).splitlines()
            continue
        first[name] = read[0]
        kept = given.kept[name][0]
        mistakes += raised(partial(refuse_unknown, f"components.{name}", read[0], kept))
        for side in ("fixed", "low", "high"):
            mistakes += raised(partial(_listed, name, keys, side, read[0]))
        if not mistakes:
            on_rows(given.forces_on(name), read[0].node, read[0].direction, clamped(keys, name))
        entries = ", ".join(f"{each.K.nnz:,}" for each in read)
        size = f"{read[0].size:,} rows, {entries} entries, {counted(len(kept), 'node')} kept"
        yield f"component {name}", size
    names = tuple(name for each in given.outputs for name in each.names)
    mistakes += raised(lambda: output_of(scene.outputs.monitor, names, scene.ring.sectors))
    _refuse(mistakes)
    for what, law in ("contacts", False), ("elements", True):
        count = sum(len(each.mu) for each in given.contacts if bool(each.element) == law)
        if count or not law:
            yield what, f"{count:,}"
    yield "ties, loads", f"{len(given.ties)}, {len(given.loads) + len(given.forces)}"
    yield from (("load", text) for text in load_lines(found[0].problem, None, given))
    yield from (("warning", text) for text in given.apart())

    @cache
    def body(name: str) -> RigidMotions:
        return rigid_motions(scene, name, given, first[name])

    hanging = at_rest([case.problem for case in found], lambda _, name, __: body(name))
    yield from (("warning", text) for text in hanging)
    yield "output nodes", f"{sum(len(each.nodes) for each in given.outputs)}"
    yield from of_curves(curves)


def _listed(name: str, keys: ComponentKeys, side: str, read: Matrices) -> None:
    """Refuse a list of nodes that a component's matrices do not have."""
    where = f"components.{name}.{side}"
    if (value := getattr(keys, side)) is not None:
        refuse_unknown(where, read, nodes(value, where))


def _refuse(mistakes: list[str]) -> None:
    """Raise InputError with all of them, a line each, if there are any."""
    if mistakes:
        raise InputError("\n".join(dict.fromkeys(mistakes)))
