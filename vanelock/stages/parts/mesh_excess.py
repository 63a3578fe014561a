"""What the meshes of a study's parts add to their stiffness, to be taken off: steps.

The vane's is found at the nodal diameters of rest and of the load, and extrapolated from there to
all others (`rom.spanned`); the casing's at each by itself.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vanelock import fem, rom
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import Component, MeshExcess, SpaceExcess, System
from vanelock.rom.joining.mesh_excess import MODES
from vanelock.rom.system.system import Matrix
from vanelock.stages.parts.segment import Segment

ESTIMATED = "tetra10"
"""Elements of which `fem.excess_stiffness` is no more than what they add; others stay."""


@lru_cache(maxsize=SHARED)
def excess_step(
    k: int,
    parts: tuple[Step[Component], Step[Component]],
    alone: Step[SpaceExcess],
    recovery: Step[rom.Recovery],
    segment: Segment,
    areas: tuple[str, ...],
) -> Step[MeshExcess]:
    """What the meshes add to vane and casing, in this order, along modes at a nodal diameter.

    The vane's by the space of `alone`, the casing's by its recovery; `areas` are the joints whose
    contacts act on patches.
    """

    def compute(
        system: System,
        vane: Component,
        casing: Component,
        alone: SpaceExcess,
        recovery: rom.Recovery,
    ) -> MeshExcess:
        frequency, shapes = _shapes(system, k, areas)
        one = system.at(k)
        each = one.split(shapes)
        excess = alone.at(each["vane"]), _excess_of(recovery, each["casing"], k)
        forces = [
            one.joined(name, part.at(k).K) @ shapes
            for name, part in (("vane", vane), ("casing", casing))
        ]
        return MeshExcess({k: rom.modal_excess(shapes, frequency, excess, forces)})

    inputs = {"modes": MODES, "areas": areas}
    needs = (joined_step(segment, *parts, "structure"), *parts, alone, recovery)
    return step("mesh correction", "fem", inputs, MeshExcess, needs, compute)


@lru_cache(maxsize=SHARED)
def vane_excess_step(
    vane: Step[Component],
    casings: tuple[Step[Component], ...],
    recovery: Step[rom.Recovery],
    diameters: tuple[int, ...],
    segment: Segment,
    areas: tuple[str, ...],
) -> Step[SpaceExcess]:
    """What the vane's mesh adds to the shapes at some nodal diameters, which casings are of."""

    def compute(vane: Component, recovery: rom.Recovery, *systems: System) -> SpaceExcess:
        found = [
            system.at(k).split(_shapes(system, k, areas)[1])["vane"]
            for k, system in zip(diameters, systems, strict=True)
        ]
        K = vane.at(0).K
        basis = rom.spanned(found, K)
        return SpaceExcess(K @ basis, _excess_of(recovery, basis, 0))

    inputs = {"modes": MODES, "areas": areas, "diameters": diameters}
    systems = (joined_step(segment, vane, each, "structure") for each in casings)
    needs = (vane, recovery, *systems)
    return step("mesh excess, vane", "fem", inputs, SpaceExcess, needs, compute)


@lru_cache(maxsize=SHARED)
def joined_step(
    segment: Segment, vane: Step[Component], casing: Step[Component], name: str = "system"
) -> Step[System]:
    """The system of a vane and a casing; joining takes no time, so it is not kept."""

    def compute(vane: Component, casing: Component) -> System:
        return joined(segment, vane, casing)

    return step(name, "rom", segment.keys, System, (vane, casing), compute, False, True)


def joined(
    segment: Segment,
    vane: Component,
    casing: Component,
    excess: MeshExcess | None = None,
    moduli: tuple[float, float] = (1.0, 1.0),
) -> System:
    """The system of a vane and a casing, without what their meshes add.

    `moduli` of both over those with which the excess was found.
    """
    found = segment.join(segment.loaded(vane), casing)
    return found if excess is None else excess.taken_off(found, moduli)


def _shapes(system: System, k: int, areas: tuple[str, ...]) -> tuple[NDArray[np.float64], Matrix]:
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
