"""The stages of a scene: components, system, linear limits, preload, responses."""

from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vanelock import nonlinear
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files import Matrices, load_matrices
from vanelock.input.band import asked_for, least_band
from vanelock.input.read_scene import ND
from vanelock.input.schema.scene import DAMPING, FILES, ComponentKeys, Scene
from vanelock.nonlinear import HarmonicModes, Journal, Response
from vanelock.pipeline.cache import code_of, content_digest
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.response.responses import FIRST, Progress
from vanelock.stages.scene import pieces
from vanelock.stages.scene.connect import Joined
from vanelock.stages.scene.gather import Gathered, gathered, nodes
from vanelock.stages.scene.modes import SceneModes, dense, frequencies, modes
from vanelock.stages.scene.piece import Piece

LIMITS: tuple[Literal["free", "stuck"], ...] = ("free", "stuck")


def diameters(scene: Scene) -> tuple[int, ...]:
    """Nodal diameters (h·EO) mod N of all harmonics, k and N-k once."""
    waves = scene.response.harmonics if scene.response.harmonic_diameters == "wave" else 1
    order, sectors = scene.excitation.engine_order, scene.ring.sectors
    return tuple(sorted({folded(h * order, sectors) for h in range(waves + 1)}))


def piece_step(scene: Scene, name: str, given: Gathered) -> Step[Piece]:
    """A component, reduced or as it is."""
    keys = scene.components[name]
    wanted, turned = given.kept[name]
    by_diameter = diameters(scene) if keys.low is not None or ND in keys.stiffness else ()
    least = least_band(asked_for(scene.response))
    inputs = {
        "least": least,
        "keys": keys.model_dump(exclude=set(FILES["components"])),
        "files": {
            key: _digests(f"components.{name}.{key}", value, by_diameter)
            for key, value in _named(keys)
        },
        "ring": scene.ring.model_dump(),
        "wanted": wanted.tolist(),
        "turned": turned.tolist(),
        "diameters": by_diameter,
        "code": code_of("fem", "rom"),
    }

    def compute() -> Piece:
        if keys.kind == "superelement":
            return pieces.superelement(
                name, scene.ring, lambda k: matrices(name, keys, k), by_diameter
            )
        fixed = np.empty(0, np.int64)
        if keys.fixed is not None:
            fixed = nodes(keys.fixed, f"components.{name}.fixed")
        faces = None
        if keys.low is not None:
            low, high = (
                nodes(getattr(keys, side), f"components.{name}.{side}") for side in ("low", "high")
            )
            faces = low, high
        read = matrices(name, keys)
        return pieces.reduced(
            name, keys, scene.ring, read, wanted, turned, fixed, faces, by_diameter, least
        )

    return step(f"component {name}", "stages", inputs, Piece, (), compute)


def matrices(name: str, keys: ComponentKeys, nodal_diameter: int = 0) -> Matrices:
    """A component's matrices, read from its files; at a nodal diameter where names say so."""

    def at(given: str | None) -> Path | None:
        return None if given is None else Path(given.replace(ND, str(nodal_diameter)))

    names = {
        "stiffness": keys.stiffness_name,
        "mass": keys.mass_name,
        "damping": keys.damping_name,
    }
    stiffness = at(keys.stiffness)
    assert stiffness is not None
    try:
        return load_matrices(
            stiffness,
            at(keys.mass),
            at(keys.damping),
            at(keys.dofs),
            at(keys.nodes),
            {key: value for key, value in names.items() if value is not None},
            length=keys.units.length,
            mass_unit=keys.units.mass,
            force=keys.units.force,
        )
    except InputError as error:
        raise InputError(f"components.{name}: {error}") from None


def system_step(scene: Scene, bare: bool = False, given: Gathered | None = None) -> Step[System]:
    """The system of a case; joining takes no time, so it is not kept.

    Parameters
    ----------
    scene : Scene
        A case's.
    bare : bool
        Without friction, preload and static load, which linear limits do not depend on.
    given : Gathered, optional
        What the scene's lists say, where they were read already.
    """
    if scene.system is not None:
        return _ready_step(scene, Path(scene.system.file), bare)
    given = given or gathered(scene)
    contacts, ties, loads, outputs = given.contacts, given.ties, given.loads, given.outputs
    if bare:
        zero = [np.zeros_like(each.mu) for each in contacts]
        contacts = tuple(
            replace(c, mu=z, interference=z) for c, z in zip(contacts, zero, strict=True)
        )
        loads = tuple(load for load in loads if load.harmonic > 0)
    needs = tuple(piece_step(scene, name, given) for name in scene.components)
    inputs = {
        "ring": scene.ring.model_dump(),
        "engine_order": scene.excitation.engine_order,
        "joined": [_plain(each) for each in (*contacts, *ties, *loads)],
        "outputs": [[name, own.tolist()] for name, own in outputs],
        "damping": scene.damping.ratio,
        "diameters": diameters(scene),
        "code": code_of("rom"),
    }

    def compute(*found: Piece) -> System:
        damped = any(block.C is not None for piece in found for block in piece.blocks.values())
        ratio = scene.damping.ratio
        if ratio is None and not damped:
            ratio = DAMPING
        joined = Joined(
            sectors=scene.ring.sectors,
            engine_order=scene.excitation.engine_order,
            cylindrical=scene.ring.coordinates == "cylindrical",
            pieces=found,
            contacts=contacts,
            ties=ties,
            loads=loads,
            outputs=outputs,
            damping_ratio=ratio,
        )
        return joined.system(diameters(scene))

    return step("system", "stages", inputs, System, needs, compute, False, True)


def modes_step(scene: Scene, system: Step[System]) -> Step[SceneModes]:
    """Linear limits, which friction and preload do not matter for."""
    mode = scene.response.mode

    def compute(system: System) -> SceneModes:
        return modes(system, mode)

    return step("linear limits", "stages", {"mode": mode}, SceneModes, (system,), compute)


def linear_step(
    scene: Scene, which: Literal["free", "stuck"], system: Step[System], limits: Step[SceneModes]
) -> Step[Response]:
    """Linear response with all contacts open or closed, dense enough to be drawn as a curve."""

    def compute(system: System, found: SceneModes) -> Response:
        own = found.free if which == "free" else found.stuck
        ratio = system.damping_ratio or DAMPING
        grid = dense(frequencies(scene, found), own, ratio)
        most = max((h for h in system.force), default=1)
        closed = "none" if which == "free" else "all"
        return nonlinear.linear_response(system, grid, closed, max(most, 1))

    inputs = {**_range(scene), "closed": which, "code": code_of("nonlinear")}
    name = f"linear response, {which}"
    return step(name, "stages", inputs, Response, (system, limits), compute)


def response_step(
    name: str,
    scene: Scene,
    system: Step[System],
    limits: Step[SceneModes],
    modes: Step[HarmonicModes],
    progress: Progress,
    direction: str | None = None,
) -> Step[Response]:
    """Nonlinear response of a case; over a range, where its curve needs points.

    In the scene's direction, or the given one; upwards where the scene wants both.
    """
    keys = ("harmonics", "coupling", "samples", "friction", "harmonic_diameters")
    options: dict[str, Any] = {key: getattr(scene.response, key) for key in keys}
    options["direction"] = direction or FIRST[scene.response.direction]

    def compute(
        system: System, found: SceneModes, stuck: HarmonicModes, journal: Journal
    ) -> Response:
        wanted = frequencies(scene, found)
        return nonlinear.frequency_response(
            system, wanted, nonlinear.Options(**options), progress, stuck.diameters, journal
        )

    inputs, needs = {**_range(scene), **options}, (system, limits, modes)
    of = name + (", down" if options["direction"] == "down" else "")
    return step("response", "nonlinear", inputs, Response, needs, compute, resumes=True, of=of)


def _range(scene: Scene) -> dict[str, Any]:
    return scene.response.model_dump(include={"mode", "frequencies", "range", "points"})


def _named(keys: ComponentKeys) -> Iterator[tuple[str, Any]]:
    for key in FILES["components"]:
        if (value := getattr(keys, key)) is not None:
            yield key, value


def _digests(where: str, value: Any, by_diameter: tuple[int, ...]) -> Any:
    """What stands for a file's contents in a hash; a list of nodes stands for itself."""
    if not isinstance(value, str):
        return list(value)
    try:
        if ND in value:
            return [content_digest(value.replace(ND, str(k))) for k in by_diameter]
        return content_digest(value)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _plain(each: Any) -> dict[str, Any]:
    """A dataclass of arrays as what JSON can hold."""
    found = {}
    for field in fields(each):
        value = getattr(each, field.name)
        if isinstance(value, np.ndarray):
            value = (
                [value.real.tolist(), value.imag.tolist()]
                if value.dtype.kind == "c"
                else (value.tolist())
            )
        found[field.name] = value
    return {"kind": type(each).__name__, **found}


def _ready_step(scene: Scene, path: Path, bare: bool) -> Step[System]:
    """A system from a file, with the contact properties that the scene gives."""
    given = {name: keys.model_dump(exclude_unset=True) for name, keys in scene.contacts.items()}
    if bare:
        given = {
            name: {key: v for key, v in each.items() if key in ("kn", "kt")}
            for name, each in given.items()
        }
    inputs = {
        "file": content_digest(path),
        "contacts": given,
        "damping": scene.damping.ratio,
        "bare": bare,
    }

    def compute() -> System:
        system: System = System.load(path)
        for name, values in given.items():
            own = np.array([joint == name for joint in system.contacts.joint], bool)
            if not own.any():
                have = ", ".join(dict.fromkeys(system.contacts.joint)) or "none with a name"
                raise InputError(f"contacts.{name}: {path} has no such contacts; it has {have}")
            changes = {}
            for key, value in values.items():
                field = "v0" if key == "interference" else key
                changed = getattr(system.contacts, field).copy()
                changed[own] = value
                changes[field] = changed
            system = replace(system, contacts=replace(system.contacts, **changes))
        if bare:
            zero = np.zeros_like(system.contacts.mu)
            force = {h: each for h, each in system.force.items() if h > 0}
            contacts = replace(system.contacts, mu=zero, v0=zero)
            system = replace(system, contacts=contacts, force=force)
        ratio = scene.damping.ratio
        return system if ratio is None else replace(system, damping_ratio=ratio)

    return step("system", "stages", inputs, System, (), compute, False, True)
