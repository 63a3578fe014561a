"""All steps of a study or a scene, case by case, known before anything is computed.

But for what an accuracy chooses first, the mesh above all.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from vanelock.common.cyclic import folded
from vanelock.input.cases.sweep import Case, label
from vanelock.input.schema.scene import Scene
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.nonlinear import HarmonicModes, Response
from vanelock.pipeline.step import Step
from vanelock.rom import System
from vanelock.stages.accuracy.choose_mesh import MeshChoice
from vanelock.stages.accuracy.mesh_errors import MeshErrors, mesh_errors_step
from vanelock.stages.matrices import steps as of_matrices
from vanelock.stages.matrices.gather import gathered
from vanelock.stages.parts.adaptive import adaptive_step
from vanelock.stages.parts.components import (
    PARTS,
    casing_step,
    diameter_of,
    diameters,
    reference_step,
    rom_step,
    shared_step,
)
from vanelock.stages.parts.gauges import Gauges, gauges_step
from vanelock.stages.parts.loads import at_rest_step, loads_of
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.parts.nodal_diameters import linear_steps
from vanelock.stages.parts.systems import (
    is_loaded,
    meshed_step,
    system_step,
    united_step,
    without_friction,
    without_load,
)
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.responses import (
    LIMITS,
    Limit,
    Progress,
    limits_step,
    linear_step,
    preload_step,
    response_step,
    stuck_modes_step,
)


@dataclass(frozen=True, slots=True)
class Linear:
    """Linear limits that one or more cases share.

    Attributes
    ----------
    name : str
        The swept values that distinguish them from those of other cases, "" if there are no others.
    system : Step
        The system without friction and preload.
    limits : Step
        Its modes.
    responses : dict of "free" | "stuck" to Step
        Linear responses.
    """

    name: str
    system: Step[System]
    limits: Step[Limits]
    responses: dict[Limit, Step[Response]]

    @property
    def key(self) -> str:
        """Hash of all that it depends on."""
        return " ".join(step.key for step in self.responses.values())


@dataclass(frozen=True, slots=True)
class Planned:
    """A case and the steps to its response.

    Attributes
    ----------
    case : Case
        Its name, values and file.
    meshes : dict of str to Step
        Meshes of its parts; none where parts are matrices.
    rom : dict of str to Step
        Reduced parts.
    system, preload, response : Step
        The system, its state at rest and its nonlinear response.
    linear : Linear
        Its linear limits.
    modes : Step
        Modes with all contacts stuck that its response takes; with an accuracy those of the first
        harmonic.
    preload_name : str
        The swept values that the preload depends on.
    gauges : Step or None
        Strain gauges, if the study has any.
    chosen_mesh : MeshChoice or None
        What an accuracy chose before, if the study has one; the casing then is reduced at one
        nodal diameter after the other.
    mesh_errors : Step or None
        Errors of natural frequencies by the mesh, with an accuracy.
    diameters : tuple of int
        Nodal diameters, 0 to N/2, at which its casing is known to be reduced.
    other : Step or None
        The response in the other direction, where both are wanted.
    apart : tuple of str
        A line for each part that nothing joins to another.
    held : tuple of int
        Nodal diameters, 0 to N/2, of its system; with an accuracy they are not known before.
    analyses : dict of str to tuple of Step
        Products of the analyses that its file asks for.
    pieces : tuple of Step
        What these are made from and can be computed side by side.
    """

    case: Case
    meshes: dict[str, Step[Part]]
    rom: dict[str, Step[Any]]
    system: Step[System]
    preload: Step[Response]
    response: Step[Response]
    linear: Linear
    modes: Step[HarmonicModes]
    preload_name: str
    gauges: Step[Gauges] | None
    chosen_mesh: MeshChoice | None = None
    mesh_errors: Step[MeshErrors] | None = None
    diameters: tuple[int, ...] = ()
    other: Step[Response] | None = None
    apart: tuple[str, ...] = ()
    held: tuple[int, ...] = ()
    analyses: Mapping[str, tuple[Step[Any], ...]] = field(default_factory=dict)
    pieces: tuple[Step[Any], ...] = ()

    @property
    def responses(self) -> tuple[Step[Response], ...]:
        """Its nonlinear responses, in one direction or both."""
        return (self.response,) if self.other is None else (self.response, self.other)

    @property
    def at_rest(self) -> Step[HarmonicModes]:
        """Modes with all contacts stuck that its state at rest takes."""
        return self.preload.needs[1]

    @property
    def analysed(self) -> tuple[Step[Any], ...]:
        """The steps of all analyses."""
        return tuple(each for steps in self.analyses.values() for each in steps)

    def turned(self, by_response: Collection[str]) -> "Planned":
        """The same with both directions exchanged, those of analyses of each response, too."""
        assert self.other is not None
        analyses = {k: v[::-1] if k in by_response else v for k, v in self.analyses.items()}
        return replace(self, response=self.other, other=self.response, analyses=analyses)

    def at_end(self, system: Step[System], response: Step[Response]) -> "Planned":
        """The same with other contacts, and the only point of a response to it."""
        return replace(self, system=system, response=response, other=None, analyses={})

    def part(self, name: str, nodal_diameter: int) -> Step[Any]:
        """A reduced part that holds a nodal diameter."""
        if self.chosen_mesh is None or name == "vane":
            return self.rom[name]
        study = self.case.study
        return casing_step(study, folded(nodal_diameter, study.ring.sectors))

    @property
    def base(self) -> tuple[Step[Any], ...]:
        """Casings that hold the nodal diameters of rest and load, where not one step each."""
        return (self.rom["casing"],) if self.chosen_mesh is None else ()

    def solved(self, response: Response) -> "Planned":
        """The same when it is known which nodal diameters the response took."""
        if self.chosen_mesh is None:
            return self
        study = self.case.study
        tried = response.estimates.tried if response.estimates else response.harmonics
        used = tuple(sorted({diameter_of(study, h) for h in range(tried + 1)}))
        return replace(self, system=united_step(study, tried), diameters=used)


def plan(
    cases: Sequence[Case], progress: Progress, chosen_mesh: Sequence[MeshChoice | None] = ()
) -> tuple[Planned, ...]:
    """Steps of every case; cases that differ in harmonics only share one reduced model."""
    if isinstance(cases[0].given, Scene):
        found = [from_matrices(case, progress) for case in cases]
    elif any(chosen_mesh):
        chosen = [each for each in chosen_mesh if each is not None]
        free = free_step(chosen[0])
        found = [adaptive(c, s, free, progress) for c, s in zip(cases, chosen, strict=True)]
    else:
        wanted = shared_diameters(cases)
        found = [fixed(c, ks, progress) for c, ks in zip(cases, wanted, strict=True)]
    cases = [each.case for each in found]
    linear = label(cases, [each.linear.key for each in found])
    preload = label(cases, [each.preload.key for each in found])
    return tuple(
        replace(each, linear=replace(each.linear, name=name), preload_name=other)
        for each, name, other in zip(found, linear, preload, strict=True)
    )


def from_matrices(case: Case, progress: Progress) -> Planned:
    """Steps of a case of a scene."""
    scene = case.given
    assert isinstance(scene, Scene)
    given = gathered(scene)
    system, base = (of_matrices.system_step(scene, given, bare) for bare in (False, True))
    rom = {name: of_matrices.piece_step(scene, name, given) for name in scene.components}
    placed = of_matrices.joined_coordinates(scene, given)
    modes = limits_step(scene.response.mode, base, tuple(rom.values()), placed=placed)
    planned = _planned(case, rom, system, base, base, modes, progress)
    return replace(planned, apart=tuple(given.apart()), held=diameters([scene]))


def meshes_of(study: Study) -> dict[str, Step[Part]]:
    """Meshes of both parts."""
    return {part: mesh_step(study, part) for part in PARTS}


def fixed(case: Case, wanted: Iterable[int], progress: Progress) -> Planned:
    """Steps of a case without an accuracy, its casing reduced at the `wanted` diameters."""
    study = case.study
    shared = {"casing": shared_step(study)}
    rom = {part: rom_step(study, part, wanted, shared.get(part)) for part in PARTS}
    bare = without_friction(study)
    own = (rom["casing"],)
    system, base = system_step(study, **rom, base=own), system_step(bare, **rom, base=own)
    system = at_rest_step(system, (rom["vane"], rom["casing"]), loads_of(study))
    meshed = meshed_step(bare, **rom)
    modes = limits_step(study.response.mode, base, tuple(rom.values()), meshed)
    still = system_step(without_load(study), **rom, base=own) if is_loaded(study) else base
    planned = _planned(case, rom, system, base, still, modes, progress)
    gauges = gauges_step(study, rom["vane"]) if study.outputs.gauges else None
    return replace(planned, meshes=meshes_of(study), gauges=gauges, held=tuple(wanted))


def _planned(
    case: Case,
    rom: dict[str, Step[Any]],
    system: Step[System],
    base: Step[System],
    still: Step[System],
    modes: Step[Limits],
    progress: Progress,
) -> Planned:
    """Steps from a system on: `base` without friction and preload, `still` without friction."""
    given = case.given
    at_rest, first, stuck = (
        stuck_modes_step(still, harmonics) for harmonics in (0, 1, given.response.harmonics)
    )
    linear = {which: linear_step(given, which, base, modes, first) for which in LIMITS}
    swept = partial(response_step, case.name, given, system, modes, stuck, progress)
    return Planned(
        case=case,
        meshes={},
        rom=rom,
        system=system,
        preload=preload_step(given.response.friction, system, at_rest),
        response=swept(),
        other=swept("down") if given.response.direction == "both" else None,
        linear=Linear("", base, modes, linear),
        modes=stuck,
        preload_name="",
        gauges=None,
    )


def shared_diameters(cases: Sequence[Case]) -> list[tuple[int, ...]]:
    """Nodal diameters at which the casing of each case is reduced: all that any other needs."""
    bare = [reference_step(case.study, "casing").key for case in cases]
    alike: dict[str, list[Study]] = {}
    for case, key in zip(cases, bare, strict=True):
        alike.setdefault(key, []).append(case.study)
    found = {key: diameters(studies) for key, studies in alike.items()}
    return [found[key] for key in bare]


def adaptive(
    case: Case, chosen_mesh: MeshChoice, free: Step[Response], progress: Progress
) -> Planned:
    """Steps of a case with an accuracy; the `free` linear response says what is monitored."""
    case = replace(case, given=chosen_mesh.study)
    study, own = case.study, linear_steps(chosen_mesh.study)
    linear = {which: own.response(study, which) for which in LIMITS}
    system = united_step(study, 1)
    mesh = mesh_errors_step(study, own.limits)
    return Planned(
        case=case,
        meshes=meshes_of(study),
        rom=own.rom,
        system=system,
        preload=preload_step(study.response.friction, system, own.modes),
        response=adaptive_step(case.name, study, chosen_mesh.budget, own, free, mesh, progress),
        linear=Linear("", own.system, own.limits, linear),
        modes=own.modes,
        preload_name="",
        gauges=gauges_step(study, own.vane) if study.outputs.gauges else None,
        chosen_mesh=chosen_mesh,
        mesh_errors=mesh,
        diameters=tuple(sorted({0, diameter_of(study, 1)})),
    )


def free_step(chosen_mesh: MeshChoice) -> Step[Response]:
    """The linear response that says what all cases monitor: the first one's, interlock free."""
    return linear_steps(chosen_mesh.study).response(chosen_mesh.study, "free")
