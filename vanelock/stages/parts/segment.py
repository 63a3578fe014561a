"""What joins a vane and a casing, and loads them: hooks, key, interlock, travelling load, damping.

The joined coordinates are the casing's, then the vane's without the key nodes, whose displacements
are the casing's.

What the meshes of a study's parts add to their stiffness, to be taken off: steps.

The vane's is found at the nodal diameters of rest and of the load, and extrapolated from there to
all others (`rom.spanned`); the casing's at each by itself.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from vanelock import fem, rom
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom.component import carrying
from vanelock.rom.joining.connections import HasMasters, Joinable, Touching
from vanelock.rom.joining.mesh_excess import MODES
from vanelock.rom.system.system import Matrix

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
        return carrying(vane, self.at_rest) if self.at_rest else replace(vane, loads=None)


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
def excess_step(
    k: int,
    parts: tuple[Step[rom.Component], Step[rom.Component]],
    alone: Step[rom.SpaceExcess],
    recovery: Step[rom.Recovery],
    segment: Segment,
    areas: tuple[str, ...],
) -> Step[rom.MeshExcess]:
    """What the meshes add to vane and casing, in this order, along modes at a nodal diameter.

    The vane's by the space of `alone`, the casing's by its recovery; `areas` are the joints whose
    contacts act on patches.
    """

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
    needs = (joined_step(segment, *parts, "structure"), *parts, alone, recovery)
    return step("mesh correction", "fem", inputs, rom.MeshExcess, needs, compute)


@lru_cache(maxsize=SHARED)
def vane_excess_step(
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
    systems = (joined_step(segment, vane, each, "structure") for each in casings)
    needs = (vane, recovery, *systems)
    return step("mesh excess, vane", "fem", inputs, rom.SpaceExcess, needs, compute)


@lru_cache(maxsize=SHARED)
def joined_step(
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
