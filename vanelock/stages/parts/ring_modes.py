"""Steps to the modes of a ring as a whole, at all nodal diameters."""

from typing import Any

import numpy as np

from vanelock import nonlinear
from vanelock.nonlinear import HarmonicModes, SectorModes
from vanelock.pipeline.step import Step, step
from vanelock.rom import Component, System
from vanelock.stages.plan import Planned


def vane_modes_step(planned: Planned, joined: Step[System], count: int) -> Step[SectorModes]:
    """Modes of a vane alone, free, as they are seen in the ring's coordinates."""

    def compute(system: System, vane: Component) -> SectorModes:
        part = {}
        for k, one in system.diameters.items():
            part[k] = np.zeros((vane.size, len(one.K)))
            part[k][np.arange(vane.size), one.parts["vane"]] = 1.0
        block = vane.at(0)
        return SectorModes.of_part(system, block.K.real, block.M.real, part, count)

    needs: tuple[Step[Any], ...] = (joined, planned.part("vane", 0))
    kind = SectorModes
    return step("vane modes", "rom", {"count": count}, kind, needs, compute, False, True)


def ring_modes_step(
    planned: Planned, joined: Step[System], modes_of_vane: Step[SectorModes] | None
) -> Step[HarmonicModes]:
    """Stuck modes of all nodal diameters, which all rings share."""

    def compute(system: System, stuck: Any, *others: Any) -> HarmonicModes:
        return nonlinear.ring_modes(system, *(others or (None,)), stuck=stuck.diameters)

    needs: tuple[Step[Any], ...] = (
        joined,
        planned.modes,
        *(() if modes_of_vane is None else (modes_of_vane,)),
    )
    kind = HarmonicModes
    return step("ring modes", "nonlinear", {}, kind, needs, compute, False, True)
