"""What joins a vane and a casing, and loads them: hooks, key, interlock, travelling load, damping.

The joined coordinates are the casing's, then the vane's without the key nodes, whose displacements
are the casing's.

What the meshes of a study's parts add to their stiffness, to be taken off: steps.

The vane's is found at the nodal diameters of rest and of the load, and extrapolated from there to
all others (`rom.spanned`); the casing's at each by itself.

Vane and casing of a study and the system that they make at each nodal diameter, each a step. What
linear limits and modes with all contacts stuck do not depend on is left out of their systems, so
that cases share them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, Literal, Self

import numpy as np

from vanelock import fem, rom
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.input.cases.values import diameter_of
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom.joining.connections import HasMasters, Joinable, Touching
from vanelock.rom.joining.mesh_excess import MODES
from vanelock.rom.system.system import Matrix
from vanelock.stages.parts.components import PARTS, mesh_step, part_step, recovery_step
from vanelock.stages.parts.loads import loads_of, strained
from vanelock.stages.structure import CaseStructure

HOOK_SETS = ("hook_front", "hook_rear")
KEY = "key"


class _Jointed(HasMasters, Joinable):
    """A part that can be joined, and whose node sets say where."""


@dataclass(frozen=True)
class Joint:
    """Contact properties of a joint, the same at each of its node pairs; see `rom.contact_pairs`.

    `name` is "hook", vane to casing, or "interlock", vane to the next vane.
    """

    name: str
    kn: float
    kt: float
    mu: float
    interference: float
    kn_area: float | None = None
    kt_area: float | None = None

    def pairs(self, vane: HasMasters, casing: HasMasters) -> Iterator[Touching]:
        """Its contacts."""
        values = asdict(self)
        if self.name == "hook":
            for each in HOOK_SETS:
                yield rom.contact_pairs(
                    part=vane, node_set=each, mate=casing, mate_set=each, tied=KEY, **values
                )
        elif self.name == "interlock":
            sides = {"node_set": "interlock_right", "mate_set": "interlock_left"}
            yield rom.contact_pairs(part=vane, mate=vane, next_sector=True, **sides, **values)
        else:
            raise InputError(f'joint "{self.name}": allowed are "hook" and "interlock"')


@dataclass(frozen=True)
class Segment:
    """A vane segment in its casing, but for the two parts.

    Attributes
    ----------
    joints : tuple of Joint
        Those with contact elements; others stay open.
    engine_order, force, unbalance
        The load on the casing's force nodes, see `rom.travelling_load`.
    damping_ratio, damping_joints
        As of `System`.
    at_rest : tuple of (str, str, float)
        Loads at rest: cause, name of the vane's load in unit size, and size.
    """

    joints: tuple[Joint, ...]
    engine_order: int = 1
    force: float = 0.0
    unbalance: float = 0.0
    damping_ratio: float | None = None
    damping_joints: str = "stuck"
    at_rest: tuple[tuple[str, str, float], ...] = ()

    @cached_property
    def vibrating(self) -> "Segment":
        """The same without loads at rest: what acts at other nodal diameters than 0."""
        return replace(self, at_rest=()) if self.at_rest else self

    @property
    def bare(self) -> "Segment":
        """The same without friction and interference."""
        joints = tuple(replace(each, mu=0.0, interference=0.0) for each in self.joints)
        return replace(self, joints=joints)

    def assembly(self, vane: _Jointed, casing: _Jointed) -> rom.Assembly:
        """Both parts, joined and loaded; joints in alphabetical order."""
        one, other = vane.masters, casing.masters
        if other.sectors > 1 and not getattr(casing, "cyclic", True):
            raise InputError(
                f"{other.part}: reduced in one piece, its sides free, while the ring has "
                f"{other.sectors} sectors: give nodal_diameters to reduce"
            )
        ordered = sorted(self.joints, key=lambda joint: joint.name)
        wave = self.engine_order, self.force, self.unbalance
        return rom.Assembly(
            sectors=one.sectors,
            engine_order=self.engine_order,
            parts={other.part: casing, one.part: vane},
            contacts=[pair for joint in ordered for pair in joint.pairs(vane, casing)],
            ties=(rom.tied_nodes(vane, KEY, casing, KEY),),
            loads=(rom.travelling_load(casing, "force", *wave),),
            outputs=[
                rom.output_nodes(p) for p in (vane, casing) if "output" in p.masters.node_sets
            ],
            always_closed=("hook",),
            damping_ratio=self.damping_ratio,
            damping_joints=self.damping_joints,
        )

    def join(self, vane: rom.Component, casing: rom.Component) -> rom.System:
        """The system of both parts at the casing's nodal diameters."""
        return self.assembly(vane, casing).system(sorted(casing.diameters))

    def loaded(self, vane: rom.Component) -> rom.Component:
        """The vane with the loads at rest."""
        return vane.carrying(self.at_rest) if self.at_rest else replace(vane, loads=None)


def segment_of(study: Study) -> Segment:
    """Joints, load and damping of a study, without its loads at rest."""
    return Segment(
        joints=tuple(Joint(n, **getattr(study.joints, n).contact) for n in study.joint_names),
        engine_order=study.excitation.engine_order,
        force=study.excitation.force_per_node,
        unbalance=study.excitation.unbalance or 0.0,
        damping_ratio=study.damping.ratio,
        damping_joints=study.damping.joints,
    )


ESTIMATED = "tetra10"
"""Elements of which `fem.excess_stiffness` is no more than what they add; others stay."""


@lru_cache(maxsize=SHARED)
def _excess_step(
    k: int,
    parts: tuple[Step[rom.Component], Step[rom.Component]],
    alone: Step[rom.SpaceExcess],
    recovery: Step[rom.Recovery],
    segment: Segment,
    areas: tuple[str, ...],
) -> Step[rom.MeshExcess]:
    """What the meshes add to vane, by the space of `alone`, and casing along modes at k."""

    def compute(
        system: rom.System,
        vane: rom.Component,
        casing: rom.Component,
        alone: rom.SpaceExcess,
        recovery: rom.Recovery,
    ) -> rom.MeshExcess:
        frequency, shapes = _shapes(system, k, areas)
        one = system.at(k)
        each = one.split(shapes)
        excess = alone.at(each["vane"]), _excess_of(recovery, each["casing"], k)
        forces = [
            one.joined(name, part.at(k).K) @ shapes
            for name, part in (("vane", vane), ("casing", casing))
        ]
        return rom.MeshExcess({k: rom.modal_excess(shapes, frequency, excess, forces)})

    inputs = {"areas": areas}
    needs = (_joined_step(segment, *parts, "structure"), *parts, alone, recovery)
    return step("mesh correction", "fem", inputs, rom.MeshExcess, needs, compute)


@lru_cache(maxsize=SHARED)
def _vane_excess_step(
    vane: Step[rom.Component],
    casings: tuple[Step[rom.Component], ...],
    recovery: Step[rom.Recovery],
    diameters: tuple[int, ...],
    segment: Segment,
    areas: tuple[str, ...],
) -> Step[rom.SpaceExcess]:
    """What the vane's mesh adds to the shapes at some nodal diameters, which casings are of."""

    def compute(
        vane: rom.Component, recovery: rom.Recovery, *systems: rom.System
    ) -> rom.SpaceExcess:
        found = [
            system.at(k).split(_shapes(system, k, areas)[1])["vane"]
            for k, system in zip(diameters, systems, strict=True)
        ]
        K = vane.at(0).K
        basis = rom.spanned(found, K)
        return rom.SpaceExcess(K @ basis, _excess_of(recovery, basis, 0))

    inputs = {"areas": areas, "diameters": diameters}
    systems = (_joined_step(segment, vane, each, "structure") for each in casings)
    needs = (vane, recovery, *systems)
    return step("mesh excess, vane", "fem", inputs, rom.SpaceExcess, needs, compute)


@lru_cache(maxsize=SHARED)
def _joined_step(
    segment: Segment, vane: Step[rom.Component], casing: Step[rom.Component], name: str = "system"
) -> Step[rom.System]:
    """The system of a vane and a casing; joining takes no time, so it is not kept."""

    def compute(vane: rom.Component, casing: rom.Component) -> rom.System:
        return segment.join(segment.loaded(vane), casing)

    return step(name, "rom", asdict(segment), rom.System, (vane, casing), compute, False, True)


def _shapes(system: rom.System, k: int, areas: tuple[str, ...]) -> tuple[Floats, Matrix]:
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


@dataclass(frozen=True)
class StudyStructure(CaseStructure):
    """The vane and the casing of a study."""

    problem: Study
    without: Literal["nothing", "friction", "load"] = "nothing"
    """What its systems leave out: friction, interference and loads at rest; or these, and the
    study's own load for the default one."""
    at_reference: bool = False
    """Whether parts have the moduli at which they are reduced, not those of their temperatures."""
    last: int | None = None
    """The nodal diameter at which the last casing is reduced, if that is known: what all casings
    share is then let go of."""
    _made: dict[Any, Step[Any]] = field(default_factory=dict, repr=False, compare=False)
    names = PARTS

    def component(self, name: str, nodal_diameter: int) -> Step[Any]:
        """A part reduced at a nodal diameter; N - k is k, conjugated."""
        key = name, 0 if name == "vane" else self.folded(nodal_diameter)
        if key not in self._made:
            self._made[key] = part_step(self.problem, *key, self.at_reference, self.last)
        return self._made[key]

    def at(self, nodal_diameter: int) -> Step[rom.System]:
        """The system at a nodal diameter, 0 to N/2."""
        found = self.meshed_at(nodal_diameter)
        if (excess := self.excess(nodal_diameter)) is None:
            return found
        return _corrected(found, excess)

    def meshed_at(self, k: int) -> Step[rom.System]:
        """The same as the meshes are, nothing taken off."""
        segment = self.segment if k == 0 else self.segment.vibrating
        return _joined_step(segment, *(self.component(name, k) for name in PARTS))

    def excess(self, nodal_diameter: int) -> Step[rom.MeshExcess] | None:
        """What the meshes add at a nodal diameter; None where it stays."""
        return None if self.problem.mesh.correction == "none" else self.mesh_excess(nodal_diameter)

    def mesh_excess(self, nodal_diameter: int) -> Step[rom.MeshExcess]:
        """What the meshes add at a nodal diameter."""
        k = nodal_diameter
        if ("excess", k) in self._made:
            return self._made["excess", k]
        study, loaded = self.problem, self.loaded
        patches = study.patches
        areas = tuple(name for name in study.joint_names if patches[name] == "area")
        on = Segment(self.segment.bare.joints), areas
        parts = self.component("vane", 0), self.component("casing", k)
        if "excess" not in self._made:
            recovered = recovery_step(study, "vane", 0, self.at_reference)
            casings = tuple(self.component("casing", each) for each in loaded)
            self._made["excess"] = _vane_excess_step(parts[0], casings, recovered, loaded, *on)
        recovered = recovery_step(study, "casing", k, self.at_reference, self.last)
        found = _excess_step(k, parts, self._made["excess"], recovered, *on)
        self._made["excess", k] = found
        return found

    def reduced(self, diameters: Iterable[int]) -> tuple[Step[Any], ...]:
        """All that a system at some nodal diameters is made from: its parts, what meshes add."""
        chosen = sorted({*map(self.folded, diameters)})
        return (*super().reduced(chosen), *filter(None, map(self.excess, chosen)))

    def rejoined(
        self,
        get: Callable[[Step[Any]], Any],
        diameters: Iterable[int],
        segment: Segment,
        moduli: tuple[float, float] = (1.0, 1.0),
    ) -> rom.System:
        """The system of the reduced parts with other joints, load and damping, and moduli.

        `get` gives the products of `reduced`; `moduli` are those of vane and casing over their own.
        """
        strained_loads, found = strained(loads_of(self.problem)), []
        for k in sorted({*diameters}):
            vane, casing = (
                part if factor == 1 else rom.stiffened(part, factor, strained_loads)
                for part, factor in zip(
                    (get(self.component(name, k)) for name in PARTS), moduli, strict=True
                )
            )
            acting = segment if k == 0 else segment.vibrating
            system = acting.join(acting.loaded(vane), casing)
            excess = self.excess(k)
            found.append(system if excess is None else get(excess).taken_off(system, moduli))
        return rom.united(found)

    @cached_property
    def segment(self) -> Segment:
        """What joins and loads both parts."""
        if self.without == "nothing":
            loads = tuple((each.cause, each.name, each.size) for each in loads_of(self.problem))
            return replace(segment_of(self.problem), at_rest=loads)
        study = self.problem
        if self.without == "load":
            load = study.excitation.model_copy(update={"force": None, "unbalance": None})
            study = study.model_copy(update={"excitation": load})
        return segment_of(study).bare

    @property
    def bare(self) -> Self:
        """The same without friction, interference and loads at rest: that of the linear limits."""
        return replace(self, without="friction")

    @property
    def unloaded(self) -> Self:
        """The bare one with the default load."""
        return replace(self, without="load")

    @property
    def meshes(self) -> Mapping[str, Step[Part]]:
        """Meshes of both parts."""
        return {part: mesh_step(self.problem, part) for part in PARTS}

    @property
    def uncorrected(self) -> Step[rom.System] | None:
        """The bare system at the load's diameter as its meshes are; None where that is `bare`."""
        if self.problem.mesh.correction == "none":
            return None
        return self.bare.meshed_at(diameter_of(self.problem, 1))


@lru_cache(maxsize=SHARED)
def _corrected(joined: Step[rom.System], excess: Step[rom.MeshExcess]) -> Step[rom.System]:
    def compute(system: rom.System, excess: rom.MeshExcess) -> rom.System:
        return excess.taken_off(system)

    inputs, needs = {"corrected": "modal"}, (joined, excess)
    return step("system", "rom", inputs, rom.System, needs, compute, False, True)
