"""The linear limits of a case, contacts free and stuck, and the steps to them."""

from dataclasses import dataclass

from vanelock.input.cases.values import diameter_of
from vanelock.nonlinear import HarmonicModes, Response
from vanelock.pipeline.step import Step
from vanelock.rom import System
from vanelock.stages.response.limits import LIMITS, Limit, Limits
from vanelock.stages.response.responses import limits_step, linear_step
from vanelock.stages.structure import CaseStructure


@dataclass(frozen=True, slots=True)
class Linear:
    """Linear limits that one or more cases share.

    Attributes
    ----------
    name : str
        The swept values that distinguish them from those of other cases, "" if there are no others.
    system : Step
        The system without friction and preload, at the nodal diameters of rest and load.
    limits : Step
        Its modes.
    modes : Step
        Those with all contacts stuck at all these nodal diameters, by which responses are computed.
    responses : dict of "free" | "stuck" to Step
        Linear responses.
    """

    name: str
    system: Step[System]
    limits: Step[Limits]
    modes: Step[HarmonicModes]
    responses: dict[Limit, Step[Response]]

    @property
    def key(self) -> str:
        """Hash of all that it depends on."""
        return " ".join(step.key for step in self.responses.values())


def linear_of(structure: CaseStructure) -> Linear:
    """The linear limits of a case."""
    given, loaded = structure.given, structure.loaded
    k = diameter_of(given, 1)
    system = structure.bare.system(loaded)
    parts = tuple(structure.component(name, k) for name in structure.names)
    mode = given.response.mode
    limits = limits_step(mode, system, structure.names, parts, structure.uncorrected)
    modes = structure.stuck_modes(loaded)
    responses = {which: linear_step(given, which, system, limits, modes) for which in LIMITS}
    return Linear("", system, limits, modes, responses)
