"""All steps of a study, case by case, known before anything is computed."""

from collections.abc import Sequence
from dataclasses import dataclass

from vanelock.nonlinear import Response
from vanelock.rom import Component, System
from vanelock.study.forced import (
    Limit,
    Progress,
    limits_step,
    linear_step,
    linear_system_step,
    preload_step,
    response_step,
)
from vanelock.study.limits import Limits
from vanelock.study.model import Study
from vanelock.study.stages import PARTS, diameters, model_step, rom_step, system_step
from vanelock.study.steps import Step
from vanelock.study.strains import Gauges, gauges_step
from vanelock.study.sweep import Case, label

LIMITS: tuple[Limit, ...] = ("free", "stuck")


@dataclass(frozen=True)
class Linear:
    """Linear limits that one or more cases share.

    Attributes
    ----------
    name : str
        The swept values that tell them from those of other cases, "" if there are no others.
    study : Study
        One of those cases.
    system : Step
        The system without friction and preload.
    limits : Step
        Its modes.
    responses : dict of "free" | "stuck" to Step
        Linear responses.
    """

    name: str
    study: Study
    system: Step[System]
    limits: Step[Limits]
    responses: dict[Limit, Step[Response]]

    @property
    def key(self) -> str:
        """Hash of all that it depends on."""
        return " ".join(step.key for step in self.responses.values())


@dataclass(frozen=True)
class Planned:
    """A case and the steps to its response.

    Attributes
    ----------
    case : Case
        Its name, values and study.
    rom : dict of str to Step
        Reduced parts.
    system, preload, response : Step
        The system, its state at rest and its nonlinear response.
    linear : Linear
        Its linear limits.
    preload_name : str
        The swept values that the preload depends on.
    gauges : Step or None
        Strain gauges, if the study has any.
    """

    case: Case
    rom: dict[str, Step[Component]]
    system: Step[System]
    preload: Step[Response]
    response: Step[Response]
    linear: Linear
    preload_name: str
    gauges: Step[Gauges] | None


def plan(cases: Sequence[Case], progress: Progress) -> tuple[Planned, ...]:
    """Steps of every case; cases that differ in harmonics only share one reduced model."""
    bare = [model_step(case.study, "casing").key for case in cases]
    wanted = [
        diameters(other.study for other, key in zip(cases, bare, strict=True) if key == own)
        for own in bare
    ]
    roms = [
        {part: rom_step(case.study, part, ks) for part in PARTS}
        for case, ks in zip(cases, wanted, strict=True)
    ]
    systems = [system_step(c.study, **rom) for c, rom in zip(cases, roms, strict=True)]
    bases = [linear_system_step(c.study, **rom) for c, rom in zip(cases, roms, strict=True)]
    modes = [
        limits_step(c.study, base, **rom) for c, base, rom in zip(cases, bases, roms, strict=True)
    ]
    linears = [
        {which: linear_step(c.study, which, base, mode) for which in LIMITS}
        for c, base, mode in zip(cases, bases, modes, strict=True)
    ]
    keys = [tuple(step.key for step in linear.values()) for linear in linears]
    names = label(cases, keys)
    preloads = [preload_step(c.study, system) for c, system in zip(cases, systems, strict=True)]
    preload_names = label(cases, [preload.key for preload in preloads])
    planned = []
    for i, case in enumerate(cases):
        linear = Linear(names[i], case.study, bases[i], modes[i], linears[i])
        response = response_step(case.name, case.study, systems[i], modes[i], progress)
        gauged = bool(case.study.outputs.gauges)
        gauges = gauges_step(case.study, roms[i]["vane"]) if gauged else None
        planned.append(
            Planned(
                case, roms[i], systems[i], preloads[i], response, linear, preload_names[i], gauges
            )
        )
    return tuple(planned)
