"""Components of a scene and the system that they make at each nodal diameter, each a step."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vanelock import rom
from vanelock.common.errors import InputError
from vanelock.common.files.digests import content_digest
from vanelock.input.band import asked_for, least_band
from vanelock.input.cases.values import Problem, diameters_of
from vanelock.input.schema.scene import DAMPING, FILES, ND, OPEN, Scene
from vanelock.pipeline.cache import code_of
from vanelock.pipeline.step import Step, step
from vanelock.rom import Assembly, System
from vanelock.rom.system.coordinates import check_ring
from vanelock.stages.matrices.gather import Gathered, gathered
from vanelock.stages.matrices.hanging import RigidMotions, refuse_unbalanced, rigid_motions
from vanelock.stages.matrices.piece import Piece
from vanelock.stages.matrices.pieces import matrices, reduced, superelement
from vanelock.stages.structure import CaseStructure


@dataclass(frozen=True)
class SceneStructure(CaseStructure):
    """The components of a scene, or the system that it names."""

    problem: Scene
    without: bool = False
    """Whether its systems leave out friction, interference and loads at rest."""
    _made: dict[Any, Step[Any]] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def gathered(self) -> Gathered:
        """What its lists and tables say."""
        return gathered(self.problem)

    @cached_property
    def names(self) -> tuple[str, ...]:  # type: ignore[override]
        """Of its components."""
        return tuple(self.problem.components)

    @cached_property
    def apart(self) -> tuple[str, ...]:  # type: ignore[override]
        """A line for each component that nothing joins to another."""
        return tuple(self.gathered.apart())

    @cached_property
    def bare(self) -> "SceneStructure":
        """The same without friction, interference and loads at rest."""
        found = replace(self, without=True)
        found.__dict__["gathered"] = self.gathered
        return found

    @property
    def loaded(self) -> tuple[int, ...]:
        """Nodal diameters, 0 to N/2, of rest, of all loads and of the harmonics between."""
        if self.problem.system is not None:
            return diameters_of(self.problem)
        own = self.gathered
        loads = {each.harmonic for each in own.loads} | {each.harmonic for each in own.forces}
        return diameters_of(self.problem, max({1, *loads}))

    @property
    def modes_up_to(self) -> int:
        """Of a system from a file, which may hold many nodal diameters, those of its response."""
        given = self.problem
        return super().modes_up_to if given.system is None else given.response.harmonics

    def component(self, name: str, nodal_diameter: int) -> Step[Piece]:
        """A component as it is or reduced, by nodal diameter where that matters."""
        keys = self.problem.components[name]
        by_diameter = keys.low is not None or ND in keys.stiffness
        at = (self.folded(nodal_diameter),) if by_diameter else ()
        if (name, at) not in self._made:
            self._made[name, at] = _piece_step(self.problem, name, self.gathered, at)
        return self._made[name, at]

    def at(self, nodal_diameter: int) -> Step[System]:
        """The system at a nodal diameter."""
        return self.system((nodal_diameter,))

    def system(self, diameters: Collection[int]) -> Step[System]:
        """The system at some nodal diameters; that of a file has its own."""
        if self.problem.system is not None:
            return _ready_step(self.problem, Path(self.problem.system.file), self.without)
        chosen = tuple(sorted({*map(self.folded, diameters)}))
        if (key := (chosen, self.without)) not in self._made:
            parts = [self.component(name, k) for k in chosen for name in self.names]
            self._made[key] = _joined_step(self.problem, self._acting, chosen, tuple(parts))
        return self._made[key]

    @property
    def _acting(self) -> Gathered:
        """What acts on the components."""
        own = self.gathered
        if not self.without:
            return own
        return replace(
            own,
            contacts=tuple(
                replace(each, mu=np.zeros_like(each.mu), interference=np.zeros_like(each.mu))
                for each in own.contacts
            ),
            loads=tuple(load for load in own.loads if load.harmonic > 0),
            forces=tuple(each for each in own.forces if each.harmonic > 0),
        )


def _piece_step(
    scene: Scene, name: str, gathered: Gathered, by_diameter: tuple[int, ...]
) -> Step[Piece]:
    least = least_band(asked_for(scene.response))
    inputs = {
        **_component(scene, name, gathered, by_diameter),
        "least": least,
        "ring": scene.ring.model_dump(),
        "followed": gathered.followed(name),
        "diameters": by_diameter,
        "code": code_of("fem"),
    }

    def compute() -> Piece:
        if scene.components[name].kind == "superelement":
            return superelement(scene, name, gathered.forces_on(name), *by_diameter)
        return reduced(scene, name, gathered, by_diameter, least)

    of = f", ND {by_diameter[0]}" if by_diameter and len(diameters_of(scene)) > 1 else ""
    return step(f"component {name}{of}", "rom", inputs, Piece, (), compute)


def motions_step(scene: Scene, name: str, gathered: Gathered) -> Step[RigidMotions]:
    """Rigid motions of a component that nothing but contacts may hold."""
    inputs = _component(scene, name, gathered)

    def compute() -> RigidMotions:
        return rigid_motions(scene, name, gathered, matrices(name, scene.components[name]))

    return step("rigid motions", "fem", inputs, RigidMotions, (), compute, of=name, quick=True)


def _component(
    scene: Scene, name: str, gathered: Gathered, by_diameter: tuple[int, ...] = ()
) -> dict[str, Any]:
    """What a component and its forces are, its files by what they hold, for a hash."""
    keys = scene.components[name]
    files = {key: getattr(keys, key) for key in FILES["components"]}
    return {
        "keys": keys.model_dump(exclude=set(files)),
        "files": {
            key: _digests(f"components.{name}.{key}", value, by_diameter)
            for key, value in files.items()
            if value is not None
        },
        "kept": [each.tolist() for each in gathered.kept[name]],
        "forces": [each.digest for each in gathered.forces_on(name)],
    }


def at_rest(
    givens: Sequence[Problem], bodies: Callable[[Scene, str, Gathered], RigidMotions]
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


def _joined_step(
    scene: Scene, acting: Gathered, diameters: tuple[int, ...], parts: tuple[Step[Piece], ...]
) -> Step[System]:
    """The system of a scene's components at some nodal diameters, one after the other in `parts`.

    Joining takes no time, so it is not kept.
    """
    contacts, ties, outputs, loads = acting.contacts, acting.ties, acting.outputs, acting.loads
    inputs = {
        "ring": scene.ring.model_dump(),
        "engine_order": scene.excitation.engine_order,
        "joined": [_plain(each) for each in (*contacts, *ties, *loads)],
        "forces": [[f.part, f.digest, *_plain(f.factor), f.harmonic] for f in acting.forces],
        "outputs": [[each.part, each.nodes.tolist()] for each in outputs],
        "damping": scene.damping.model_dump(),
        "diameters": diameters,
    }
    count = len(parts) // len(diameters)

    def compute(*pieces: Piece) -> System:
        rows = [pieces[i : i + count] for i in range(0, len(pieces), count)]
        systems = [
            _assembly(scene, acting, row).system((k,))
            for k, row in zip(diameters, rows, strict=True)
        ]
        return rom.united(systems)

    return step("system", "rom", inputs, System, parts, compute, False, True)


def _assembly(scene: Scene, acting: Gathered, pieces: Sequence[Piece]) -> Assembly:
    """A scene's components at a nodal diameter and all that acts on them."""
    damped = any(block.C is not None for piece in pieces for block in piece.blocks.values())
    ratio = scene.damping.ratio
    if ratio is None and not damped:
        ratio = DAMPING
    parts = {piece.name: piece for piece in pieces}
    return Assembly(
        sectors=scene.ring.sectors,
        engine_order=scene.excitation.engine_order,
        cylindrical=scene.ring.coordinates == "cylindrical",
        parts=parts,
        contacts=acting.contacts,
        ties=acting.ties,
        loads=(
            *(parts[load.part].reduced_load(load) for load in acting.loads),
            *(parts[each.part].load_of(each) for each in acting.forces),
        ),
        outputs=tuple(o for each in acting.outputs for o in parts[each.part].reduced_outputs(each)),
        damping_ratio=ratio,
        damping_joints=scene.damping.joints or OPEN,
    )


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


def _plain(value: Any) -> Any:
    """Dataclasses, arrays and complex numbers as what JSON can hold."""
    if is_dataclass(value):
        held = {one.name: _plain(getattr(value, one.name)) for one in fields(value)}
        return {"kind": type(value).__name__, **held}
    if np.iscomplexobj(value):
        return [np.asarray(value).real.tolist(), np.asarray(value).imag.tolist()]
    return value.tolist() if isinstance(value, np.ndarray) else value


def _ready_step(scene: Scene, path: Path, bare: bool) -> Step[System]:
    """A system from a file, with the contact properties that the scene gives."""
    of = {"kn", "kt"} if bare else None
    given = {
        name: keys.model_dump(exclude_unset=True, include=of)
        for name, keys in scene.contacts.items()
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
