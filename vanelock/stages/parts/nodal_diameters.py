"""The steps to a response whose casing is reduced at one nodal diameter after the other."""

from dataclasses import dataclass

from vanelock.input.schema.study import Study
from vanelock.pipeline.step import Step
from vanelock.rom import Component, System
from vanelock.stages.parts.bare import without_friction
from vanelock.stages.parts.components import rom_step
from vanelock.stages.parts.diameters import casing_step, diameter_of, joined_step
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.responses import limits_step


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
    """

    vane: Step[Component]
    casing: Step[Component]
    system: Step[System]
    limits: Step[Limits]

    @property
    def rom(self) -> dict[str, Step[Component]]:
        """The parts by name."""
        return {"vane": self.vane, "casing": self.casing}


def linear_steps(study: Study) -> LinearSteps:
    """Those of a case."""
    k = diameter_of(study, 1)
    vane, casing = rom_step(study, "vane", ()), casing_step(study, k)
    system = joined_step(without_friction(study), {0, k})
    modes = limits_step(study.response.mode, system, (vane, casing))
    return LinearSteps(vane, casing, system, modes)
