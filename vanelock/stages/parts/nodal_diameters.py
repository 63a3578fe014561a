"""The steps to a response whose casing is reduced at one nodal diameter after the other."""

from dataclasses import dataclass

from vanelock.input.schema.study import Study
from vanelock.nonlinear import HarmonicModes, Response
from vanelock.pipeline.step import Step
from vanelock.rom import Component, System
from vanelock.stages.parts.components import casing_step, diameter_of, rom_step
from vanelock.stages.parts.systems import joined_step, meshed_step, without_friction
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.responses import (
    Limit,
    limits_step,
    linear_step,
    stuck_modes_step,
)


@dataclass(frozen=True)
class LinearSteps:
    """The steps of a case up to its linear limits.

    Attributes
    ----------
    vane, casing : Step
        The reduced parts, the casing at the nodal diameter of the load.
    system : Step
        Joined without friction and preload, at nodal diameter 0 and that of the load.
    limits : Step
        Its modes.
    modes : Step
        Those with all contacts stuck, by which responses are computed.
    """

    vane: Step[Component]
    casing: Step[Component]
    system: Step[System]
    limits: Step[Limits]
    modes: Step[HarmonicModes]

    def response(self, study: Study, which: Limit) -> Step[Response]:
        """The linear response of the case with contacts free or stuck."""
        return linear_step(study, which, self.system, self.limits, self.modes)

    @property
    def rom(self) -> dict[str, Step[Component]]:
        """The parts by name."""
        return {"vane": self.vane, "casing": self.casing}


def linear_steps(study: Study) -> LinearSteps:
    """Those of a case."""
    k = diameter_of(study, 1)
    vane, casing = rom_step(study, "vane", ()), casing_step(study, k)
    bare = without_friction(study)
    system, meshed = joined_step(bare, {0, k}), meshed_step(bare, vane, casing)
    limits = limits_step(study.response.mode, system, (vane, casing), meshed)
    return LinearSteps(vane, casing, system, limits, stuck_modes_step(system, 1))
