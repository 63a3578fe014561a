"""The steps of a scene to its components and its system."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.fem.matrix_files import Matrices, load_matrices
from vanelock.input.band import asked_for, least_band
from vanelock.input.cases.values import Given
from vanelock.input.schema.scene import DAMPING, FILES, ND, OPEN, ComponentKeys, Scene
from vanelock.pipeline.cache import code_of, content_digest
from vanelock.pipeline.step import Step, step
from vanelock.rom import Element, System
from vanelock.rom.joining.joined import Joined
from vanelock.rom.system.consistency import check_ring
from vanelock.stages.matrices import pieces
from vanelock.stages.matrices.gather import Gathered, gathered, nodes
from vanelock.stages.matrices.hanging import RigidMotions, refuse_unbalanced, rigid_motions
from vanelock.stages.matrices.piece import Piece
from vanelock.stages.parts.components import diameters
from vanelock.stages.response.limits import Placed


def piece_step(scene: Scene, name: str, given: Gathered, at: tuple[int, ...] = ()) -> Step[Piece]:
    """A component, reduced or as it is; `at` other nodal diameters than those of the response."""
    keys = scene.components[name]
    wanted, turned = given.kept[name]
    followed, forces = given.followed(name), given.forces_on(name)
    by_diameter: tuple[int, ...] = ()
    if keys.low is not None or ND in keys.stiffness:
        by_diameter = at or diameters([scene])
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
        "followed": followed,
        "forces": [each.digest for each in forces],
        "turned": turned.tolist(),
        "diameters": by_diameter,
        "code": code_of("fem", "rom"),
    }

    def compute() -> Piece:
        if keys.kind == "superelement":
            return pieces.superelement(
                name, scene.ring, lambda k: matrices(name, keys, k), by_diameter, forces
            )
        fixed, faces = clamped(keys, name), None
        if keys.low is not None:
            low, high = (
                nodes(getattr(keys, side), f"components.{name}.{side}") for side in ("low", "high")
            )
            faces = low, high
        read = matrices(name, keys)
        return pieces.reduced(
            name,
            keys,
            scene.ring,
            read,
            wanted,
            turned,
            fixed,
            faces,
            by_diameter,
            least,
            followed,
            forces,
        )

    return step(f"component {name}", "stages", inputs, Piece, (), compute)


def motions_step(scene: Scene, name: str, given: Gathered) -> Step[RigidMotions]:
    """Rigid motions of a component that nothing but contacts may hold."""
    keys, kept, forces = scene.components[name], given.kept[name], given.forces_on(name)
    inputs = {
        "keys": keys.model_dump(exclude=set(FILES["components"])),
        "files": {key: _digests(f"components.{name}.{key}", v, ()) for key, v in _named(keys)},
        "kept": [each.tolist() for each in kept],
        "forces": [each.digest for each in forces],
        "code": code_of("fem"),
    }

    def compute() -> RigidMotions:
        return rigid_motions(name, matrices(name, keys), clamped(keys, name), kept, forces)

    return step("rigid motions", "stages", inputs, RigidMotions, (), compute, of=name, quick=True)


def at_rest(
    givens: Sequence[Given], bodies: Callable[[Scene, str, Gathered], RigidMotions]
) -> list[str]:
    """Lines on parts of scenes that nothing presses, of the first case that can be at rest."""
    lost = None
    for scene in givens:
        if not isinstance(scene, Scene) or scene.system is not None or scene.ring.sectors > 1:
            return []
        given = gathered(scene)
        found = {name: bodies(scene, name, given) for name in scene.components}
        try:
            return refuse_unbalanced(given, found)
        except InputError as error:
            lost = lost or error
    assert lost is not None
    raise lost


def clamped(keys: ComponentKeys, name: str) -> NDArray[np.int64]:
    """Nodes that a component says are held."""
    if keys.fixed is None:
        return np.empty(0, np.int64)
    return nodes(keys.fixed, f"components.{name}.fixed")


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


def system_step(
    scene: Scene,
    given: Gathered | None = None,
    bare: bool = False,
    at: tuple[int, ...] = (),
) -> Step[System]:
    """The system of a case; joining takes no time, so it is not kept."""
    if scene.system is not None:
        return _ready_step(scene, Path(scene.system.file), bare)
    given = given or gathered(scene)
    contacts, ties, outputs = given.contacts, given.ties, given.outputs
    loads, forces = given.loads, given.forces
    if bare:
        zero = [np.zeros_like(each.mu) for each in contacts]
        contacts = tuple(
            replace(c, mu=z, interference=z) for c, z in zip(contacts, zero, strict=True)
        )
        loads = tuple(load for load in loads if load.harmonic > 0)
        forces = tuple(each for each in forces if each.harmonic > 0)
    needs = tuple(piece_step(scene, name, given, at) for name in scene.components)
    wanted = at or diameters([scene])
    inputs = {
        "ring": scene.ring.model_dump(),
        "engine_order": scene.excitation.engine_order,
        "joined": [_plain(each) for each in (*contacts, *ties, *loads)],
        "forces": [
            [each.part, each.digest, each.factor.real, each.factor.imag, each.harmonic]
            for each in forces
        ],
        "outputs": [[each.part, each.nodes.tolist()] for each in outputs],
        "damping": scene.damping.model_dump(),
        "diameters": wanted,
        "code": code_of("rom"),
    }

    def compute(*found: Piece) -> System:
        damped = any(block.C is not None for piece in found for block in piece.blocks.values())
        ratio = scene.damping.ratio
        if ratio is None and not damped:
            ratio = DAMPING
        parts = {piece.name: piece for piece in found}
        joined = Joined(
            sectors=scene.ring.sectors,
            engine_order=scene.excitation.engine_order,
            cylindrical=scene.ring.coordinates == "cylindrical",
            parts=parts,
            contacts=contacts,
            ties=ties,
            loads=(
                *(parts[load.part].reduced_load(load) for load in loads),
                *(parts[each.part].load_of(each) for each in forces),
            ),
            outputs=tuple(o for each in outputs for o in parts[each.part].reduced_outputs(each)),
            damping_ratio=ratio,
            damping_joints=scene.damping.joints or OPEN,
        )
        return joined.system(wanted)

    return step("system", "stages", inputs, System, needs, compute, False, True)


def joined_coordinates(scene: Scene, given: Gathered) -> Callable[..., Sequence[Placed]]:
    """What gives each of a scene's pieces its coordinates among the joined ones."""

    def placed(*found: Piece) -> Sequence[Placed]:
        parts = {piece.name: piece for piece in found}
        whole = Joined(scene.ring.sectors, scene.excitation.engine_order, parts, ties=given.ties)
        return [(piece, whole.coordinates(name)) for name, piece in parts.items()]

    return placed


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
        found[field.name] = _plain(value) if isinstance(value, Element) else value
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
        "damping": scene.damping.model_dump(),
        "bare": bare,
    }

    def compute() -> System:
        system: System = System.load(path)
        if table := scene.whole_ring:
            check_ring(system, system.sectors // 2, f"[{table}]")
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
        ratio = system.damping_ratio if scene.damping.ratio is None else scene.damping.ratio
        held: str = OPEN if system.damping_ratio is None else system.damping_joints
        return replace(system, damping_ratio=ratio, damping_joints=scene.damping.joints or held)

    return step("system", "stages", inputs, System, (), compute, False, True)
