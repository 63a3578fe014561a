"""Steps of a ring as a whole: its system and its modes at all nodal diameters."""

from typing import Any

import numpy as np

from vanelock import nonlinear, rom
from vanelock.input.schema.scene import Scene
from vanelock.nonlinear import HarmonicModes, SectorModes
from vanelock.pipeline.step import Step, step
from vanelock.rom import Component, System
from vanelock.rom.joining.vane_and_casing import joined_dofs
from vanelock.stages.matrices import steps as of_matrices
from vanelock.stages.parts.components import casing_step
from vanelock.stages.parts.systems import joined_step, system_step
from vanelock.stages.plan import Planned


def whole_step(planned: Planned) -> Step[System]:
    """A case's system with all nodal diameters, 0 to N/2."""
    given = planned.case.given
    every = range(given.ring.sectors // 2 + 1)
    lacking = tuple(k for k in every if k not in planned.held)
    if isinstance(given, Scene):
        if given.system is not None or not lacking:
            return planned.system
        more = [of_matrices.system_step(given, at=lacking)]
    elif planned.chosen_mesh is not None:
        return joined_step(planned.case.study, every)
    else:
        study, vane, base = planned.case.study, planned.rom["vane"], planned.base
        more = [system_step(study, vane, casing_step(study, k), base) for k in lacking]

    def compute(*systems: System) -> System:
        return rom.united(systems)

    return step("system", "rom", {}, System, (planned.system, *more), compute, False, True)


def vane_modes_step(planned: Planned, whole: Step[System], count: int) -> Step[SectorModes]:
    """Modes of a vane alone, free, as they are seen in the ring's coordinates."""
    study = planned.case.study
    vane, every = planned.rom["vane"], range(study.ring.sectors // 2 + 1)
    shared = () if planned.chosen_mesh is not None else planned.held
    casings = tuple(planned.rom["casing"] if k in shared else casing_step(study, k) for k in every)

    def compute(system: System, vane: Component, *casings: Component) -> SectorModes:
        part = {}
        for k, casing in zip(every, casings, strict=True):
            part[k] = np.zeros((vane.size, len(system.at(k).K)))
            part[k][np.arange(vane.size), joined_dofs(vane, casing)] = 1.0
        block = vane.at(0)
        return SectorModes.of_part(system, block.K.real, block.M.real, part, count)

    needs: tuple[Step[Any], ...] = (whole, vane, *casings)
    kind = SectorModes
    return step("vane modes", "rom", {"count": count}, kind, needs, compute, False, True)


def ring_modes_step(
    planned: Planned, whole: Step[System], own: Step[SectorModes] | None
) -> Step[HarmonicModes]:
    """Stuck modes of all nodal diameters, which all rings share."""

    def compute(system: System, stuck: Any, *others: Any) -> HarmonicModes:
        return nonlinear.ring_modes(system, *(others or (None,)), known=stuck.diameters)

    needs: tuple[Step[Any], ...] = (whole, planned.modes, *(() if own is None else (own,)))
    kind = HarmonicModes
    return step("ring modes", "nonlinear", {}, kind, needs, compute, False, True)
