"""The systems that the reduced parts of a study are joined to, each a step.

That of the response, and those without friction and preload or with the default load: the linear
limits and the modes with all contacts stuck do not depend on what they leave out.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vanelock import fem, rom
from vanelock.fem import Model
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import Component, Joint, MeshExcess, SpaceExcess, System
from vanelock.rom.joining.mesh_excess import MODES
from vanelock.rom.system.system import Matrix
from vanelock.stages.parts.components import casing_step, diameter_of, model_step, rom_step
from vanelock.stages.parts.recoveries import recovery_step

Floats: TypeAlias = NDArray[np.float64]
ESTIMATED = "tetra10"
"""Elements of which `fem.excess_stiffness` is no more than what they add; others stay."""
Bases: TypeAlias = Sequence[Step[Component]]
MakeModel: TypeAlias = Callable[[Study, str], Step[Model]]


def joints(study: Study) -> tuple[Joint, ...]:
    """The joints with contact elements."""
    hook, interlock = study.joints.hook, study.joints.interlock
    found = [Joint("hook", **hook.model_dump(exclude={"patch", "wear_coefficient"}))]
    if interlock.enabled:
        properties = interlock.model_dump(exclude={"enabled", "patch", "wear_coefficient"})
        found.append(Joint("interlock", **properties))
    return tuple(found)


class Joining(NamedTuple):
    """What makes a system of the reduced parts of a study."""

    joints: tuple[Joint, ...]
    excitation: rom.Excitation
    damping: tuple[float | None, str]

    def join(self, vane: Component, casing: Component) -> System:
        """The system of a vane and a casing, without loads at rest."""
        ratio, joints = self.damping
        vane, casing = replace(vane, loads=None), replace(casing, loads=None)
        return rom.join(vane, casing, self.joints, self.excitation, ratio, damping_joints=joints)


def joining(study: Study) -> Joining:
    """Joints, load and damping of a study."""
    excitation = rom.Excitation(
        engine_order=study.excitation.engine_order,
        force=study.excitation.force_per_node,
        unbalance=study.excitation.unbalance or 0.0,
    )
    return Joining(joints(study), excitation, (study.damping.ratio, study.damping.joints))


def system_step(
    study: Study, vane: Step[Component], casing: Step[Component], base: Bases = ()
) -> Step[System]:
    """The system of a case; joining takes no time, so it is not kept.

    By casings of `base` what the meshes add is found, see `excess_steps`.
    """
    joined = _joined(joining(study), vane, casing)
    excess = excess_steps(study, vane, [casing], base)
    return _corrected(joined, *excess) if excess else joined


def meshed_step(
    study: Study, vane: Step[Component], casing: Step[Component]
) -> Step[System] | None:
    """The system as its meshes are; None where that is the system of the case."""
    return None if study.mesh.correction == "none" else _joined(joining(study), vane, casing)


@lru_cache(maxsize=SHARED)
def _joined(
    given: Joining, vane: Step[Component], casing: Step[Component], name: str = "system"
) -> Step[System]:
    inputs = {
        "joints": [vars(joint) for joint in given.joints],
        "excitation": vars(given.excitation),
        "damping": given.damping,
    }
    return step(name, "rom", inputs, System, (vane, casing), given.join, False, True)


@lru_cache(maxsize=SHARED)
def _corrected(joined: Step[System], excess: Step[MeshExcess]) -> Step[System]:
    def compute(system: System, excess: MeshExcess) -> System:
        return excess.taken_off(system)

    return step(
        "system", "rom", {"corrected": "modal"}, System, (joined, excess), compute, False, True
    )


def excess_steps(
    study: Study,
    vane: Step[Component],
    casings: Iterable[Step[Component]],
    base: Bases = (),
    model: MakeModel = model_step,
) -> tuple[Step[MeshExcess], ...]:
    """What the meshes add to the stiffness of a vane and each casing; none where it stays.

    The vane's is found at the nodal diameters of rest and of the load, which the casings of `base`
    hold, and extrapolated from there.
    """
    if study.mesh.correction == "none":
        return ()
    bare = tuple(replace(joint, mu=0.0, interference=0.0) for joint in joints(study))
    stiffness = Joining(bare, rom.Excitation(1), (None, "stuck"))
    patches = study.patches
    areas = tuple(name for name in study.joint_names if patches[name] == "area")
    found = tuple(sorted({0, diameter_of(study, 1)}))
    base = tuple(base) or tuple(casing_step(study, k) for k in found)

    def structure(casing: Step[Component]) -> Step[System]:
        return _joined(stiffness, vane, casing, "structure")

    whole = recovery_step(study, "vane", vane, model(study, "vane"))
    needs = (vane, whole, *base, *map(structure, base))
    alone = _vane_excess(needs, found, areas)
    return tuple(
        _excess(
            structure(casing),
            (vane, casing),
            alone,
            recovery_step(study, "casing", casing, model(study, "casing")),
            areas,
        )
        for casing in casings
    )


@lru_cache(maxsize=SHARED)
def _vane_excess(
    needs: tuple[Step[Any], ...], diameters: tuple[int, ...], areas: tuple[str, ...]
) -> Step[SpaceExcess]:
    def compute(vane: Component, recovery: rom.Recovery, *others: Any) -> SpaceExcess:
        half, found = len(others) // 2, []
        for casing, system in zip(others[:half], others[half:], strict=True):
            for k in sorted(set(diameters) & set(casing.diameters)):
                found.append(rom.split(vane, casing, _shapes(system, k, areas)[1])[0])
        K = vane.at(0).K
        basis = rom.spanned(found, K)
        return SpaceExcess(K @ basis, _excess_of(recovery, basis, 0))

    inputs = {"modes": MODES, "areas": areas, "diameters": diameters}
    return step("mesh excess, vane", "fem", inputs, SpaceExcess, needs, compute)


@lru_cache(maxsize=SHARED)
def _excess(
    joined: Step[System],
    parts: tuple[Step[Component], Step[Component]],
    alone: Step[SpaceExcess],
    recovered: Step[rom.Recovery],
    areas: tuple[str, ...],
) -> Step[MeshExcess]:
    def compute(
        system: System,
        vane: Component,
        casing: Component,
        alone: SpaceExcess,
        recovery: rom.Recovery,
    ) -> MeshExcess:
        found = {}
        for k in sorted(casing.diameters):
            frequency, shapes = _shapes(system, k, areas)
            blade, shell = rom.split(vane, casing, shapes)
            forces = [K @ shapes for K in rom.joined_stiffness(vane, casing, k)]
            excess = alone.at(blade), _excess_of(recovery, shell, k)
            found[k] = rom.modal_excess(shapes, frequency, excess, forces)
        return MeshExcess(found)

    needs = (joined, *parts, alone, recovered)
    inputs = {"modes": MODES, "areas": areas}
    return step("mesh correction", "fem", inputs, MeshExcess, needs, compute)


def _shapes(system: System, k: int, areas: tuple[str, ...]) -> tuple[Floats, Matrix]:
    """Shapes along which what meshes add is taken off, and their frequencies, Hz."""
    frequency, shapes = rom.linear_modes(system, k, min(MODES, len(system.at(k).K)))
    if k or not areas:
        return frequency, shapes
    more = rom.rest_shapes(system, areas)
    energy = np.einsum("ij,ij->j", more.conj(), system.at(0).K @ more).real
    return np.append(frequency, np.sqrt(energy) / (2 * np.pi)), np.hstack([shapes, more])


def _excess_of(recovery: rom.Recovery, q: Matrix, k: int) -> Matrix:
    """What a part's mesh adds to shapes; none where its elements have no estimate."""
    if recovery.model.part.cell_type != ESTIMATED:
        return np.zeros((q.shape[1], q.shape[1]), q.dtype)
    u = recovery.displacement(q, k)
    return np.asarray(fem.excess_stiffness(recovery.model, u if u.imag.any() else u.real))


def united_step(study: Study, harmonics: int) -> Step[System]:
    """The system of a case that has the nodal diameters of harmonics 0 to `harmonics`."""
    found = dict.fromkeys(diameter_of(study, h) for h in range(harmonics + 1))
    return joined_step(study, found)


def joined_step(study: Study, diameters: Iterable[int]) -> Step[System]:
    """The system of a case at some nodal diameters, that of its load among them."""
    vane = rom_step(study, "vane", ())
    needs = tuple(system_step(study, vane, casing_step(study, k)) for k in sorted(diameters))

    def compute(*systems: System) -> System:
        return rom.united(systems)

    return step("system", "rom", {}, System, needs, compute, False, True)


def without_friction(study: Study) -> Study:
    """The study of the linear limits: no friction, no interference."""
    joints = study.joints.model_copy(
        update={
            name: getattr(study.joints, name).model_copy(update={"mu": 0.0, "interference": 0.0})
            for name in ("hook", "interlock")
        }
    )
    return study.model_copy(update={"joints": joints})


def without_load(study: Study) -> Study:
    """The study of the modes with all contacts stuck: no friction, and the default load."""
    load = study.excitation.model_copy(update={"force": None, "unbalance": None})
    return without_friction(study).model_copy(update={"excitation": load})


def is_loaded(study: Study) -> bool:
    """Whether a study has another load than the default one."""
    return (study.excitation.force, study.excitation.unbalance) != (None, None)
