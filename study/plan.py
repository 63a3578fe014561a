"""All steps of a study, case by case, known before anything is computed.

But for what an accuracy settles first, the mesh above all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vanelock.cyclic import folded
from vanelock.nonlinear import Response
from vanelock.rom import Component, System
from vanelock.study.adaptive import adaptive_step
from vanelock.study.chain import linear_steps
from vanelock.study.diameters import casing_step, diameter_of, united_step
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
from vanelock.study.mesh_errors import MeshErrors, mesh_errors_step
from vanelock.study.model import Study
from vanelock.study.settle import Settled
from vanelock.study.stages import PARTS, diameters, reference_step, rom_step, system_step
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
    settled : Settled or None
        What an accuracy chose before, if the study has one; the casing then is reduced at one
        nodal diameter after the other.
    mesh_errors : Step or None
        Errors of natural frequencies by the mesh, with an accuracy.
    diameters : tuple of int
        Nodal diameters, 0 to N/2, at which its casing is known to be reduced.
    """

    case: Case
    rom: dict[str, Step[Component]]
    system: Step[System]
    preload: Step[Response]
    response: Step[Response]
    linear: Linear
    preload_name: str
    gauges: Step[Gauges] | None
    settled: Settled | None = None
    mesh_errors: Step[MeshErrors] | None = None
    diameters: tuple[int, ...] = ()

    def part(self, name: str, nodal_diameter: int) -> Step[Component]:
        """A reduced part that holds a nodal diameter."""
        if self.settled is None or name == "vane":
            return self.rom[name]
        study = self.case.study
        return casing_step(study, folded(nodal_diameter, study.ring.sectors))

    def solved(self, response: Response) -> "Planned":
        """The same when it is known which nodal diameters the response took."""
        if self.settled is None:
            return self
        study = self.case.study
        tried = response.estimates.tried if response.estimates else response.harmonics
        used = tuple(sorted({diameter_of(study, h) for h in range(tried + 1)}))
        return replace(self, system=united_step(study, tried), diameters=used)


def plan(
    cases: Sequence[Case], progress: Progress, settled: Sequence[Settled | None] = ()
) -> tuple[Planned, ...]:
    """Steps of every case; cases that differ in harmonics only share one reduced model.

    Parameters
    ----------
    cases : sequence of Case
        Those of a study.
    progress : callable
        Told of each point.
    settled : sequence of Settled or None
        What the accuracy of each case chose, whose studies replace those of the cases.
    """
    if any(settled):
        return _adaptive(cases, progress, [each for each in settled if each is not None])
    wanted = shared_diameters(cases)
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
    names = label(cases, _keys(linears))
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


def shared_diameters(cases: Sequence[Case]) -> list[tuple[int, ...]]:
    """Nodal diameters at which the casing of each case is reduced: all that any other needs."""
    bare = [reference_step(case.study, "casing").key for case in cases]
    return [
        diameters(other.study for other, key in zip(cases, bare, strict=True) if key == own)
        for own in bare
    ]


def _keys(linears: Sequence[dict[Limit, Step[Response]]]) -> list[tuple[str, ...]]:
    return [tuple(step.key for step in linear.values()) for linear in linears]


def _adaptive(
    cases: Sequence[Case], progress: Progress, settled: Sequence[Settled]
) -> tuple[Planned, ...]:
    """Steps of cases with an accuracy."""
    cases = [replace(c, study=each.study) for c, each in zip(cases, settled, strict=True)]
    steps = [linear_steps(case.study) for case in cases]
    linears = [
        {which: linear_step(case.study, which, own.system, own.limits) for which in LIMITS}
        for case, own in zip(cases, steps, strict=True)
    ]
    names = label(cases, _keys(linears))
    systems = [united_step(case.study, 1) for case in cases]
    preloads = [preload_step(c.study, system) for c, system in zip(cases, systems, strict=True)]
    preload_names = label(cases, [preload.key for preload in preloads])
    planned = []
    for i, (case, own) in enumerate(zip(cases, steps, strict=True)):
        mesh = mesh_errors_step(case.study, own.limits)
        gauged = bool(case.study.outputs.gauges)
        planned.append(
            Planned(
                case=case,
                rom=own.rom,
                system=systems[i],
                preload=preloads[i],
                response=adaptive_step(
                    case.name,
                    case.study,
                    settled[i].budget,
                    own,
                    linears[0]["free"],
                    mesh,
                    progress,
                ),
                linear=Linear(names[i], case.study, own.system, own.limits, linears[i]),
                preload_name=preload_names[i],
                gauges=gauges_step(case.study, own.vane) if gauged else None,
                settled=settled[i],
                mesh_errors=mesh,
                diameters=tuple(sorted({0, diameter_of(case.study, 1)})),
            )
        )
    return tuple(planned)
