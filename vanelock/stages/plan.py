"""All steps of a study or a scene, case by case, known before anything is computed.

But for what an accuracy chooses first, the mesh above all.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, cast

from vanelock import nonlinear, rom
from vanelock.input.cases.sweep import Case, label
from vanelock.input.cases.values import diameter_of, diameters_of
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.nonlinear import HarmonicModes, PointStore, Response
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.accuracy.budget import Budget
from vanelock.stages.accuracy.choose_mesh import MeshChoice
from vanelock.stages.accuracy.mesh_errors import mesh_errors_step
from vanelock.stages.matrices.scene_structure import SceneStructure
from vanelock.stages.parts.outputs import Gauges, gauges_step
from vanelock.stages.parts.segment import StudyStructure
from vanelock.stages.response.limits import frequencies
from vanelock.stages.response.responses import (
    Progress,
    frequency_keys,
    monitor,
    preload_step,
    response_step,
)
from vanelock.stages.structure import CaseStructure, Linear, linear_of


def _adaptive_step(
    name: str,
    structure: StudyStructure,
    budget: Budget,
    linear: Linear,
    free: Step[Response],
    progress: Progress,
) -> Step[Response]:
    """Nonlinear response of a case to its budget, by harmonics and frequencies chosen meanwhile.

    Which nodal diameters of the casing it takes is known at its end alone. The step may need all of
    them, so its key holds all their keys; it pulls those that a point needs.
    """
    study, base = structure.problem, structure.system(structure.loaded)
    mesh = mesh_errors_step(study, linear.system, linear.limits)
    shares = {key: budget.shares.get(key, budget.accuracy) for key in ("harmonics", "frequencies")}
    fixed = study.response.model_dump(include={"coupling", "samples", "friction"})
    fixed["harmonics"] = study.response.harmonics if "harmonics" in budget.pinned else None
    inputs = {**frequency_keys(study), **fixed, "shares": shares, "monitor": study.outputs.monitor}

    def compute(get: Callable[[Step[Any]], Any], store: PointStore) -> Response:
        limits, errors, system = get(linear.limits), get(mesh), get(base)
        watched = monitor(study.outputs.monitor, system, get(free))

        def systems(harmonics: int) -> System:
            return cast(System, get(structure.system(diameters_of(study, harmonics))))

        def neglected(nodal_diameter: int) -> Any:
            k = nodal_diameter
            parts = {name: get(structure.component(name, k)) for name in structure.names}
            return rom.neglected_forms(get(structure.system([k])), parts, k)

        k = diameter_of(study, 1)
        modal = [get(structure.component(name, k)) for name in structure.names]
        # parts by number of modes may have none
        estimable = all(part.at(k).neglected is not None for part in modal)
        return nonlinear.adaptive_response(
            systems,
            frequencies(study, limits),
            nonlinear.Shares(**shares),
            nonlinear.Options(**fixed),
            monitor=(watched.node, watched.component),
            neglected=neglected if estimable else None,
            mesh_error=errors.at,
            progress=progress,
            store=store,
        )

    needs: tuple[Step[Any], ...] = (linear.limits, mesh, free, base)
    needs += structure.reduced(structure.every_diameter)
    return step(
        "response", "nonlinear", inputs, Response, needs, compute, pulls=True, resumes=True, of=name
    )


@dataclass(frozen=True, slots=True)
class Planned:
    """A case and the steps to its response."""

    case: Case
    """Its name, values and file."""
    structure: CaseStructure
    """Its components and their system at each nodal diameter."""
    diameters: tuple[int, ...]
    """Nodal diameters, 0 to N/2, that the response takes; with an accuracy those known before."""
    system: Step[System]
    """That of the response."""
    preload: Step[Response]
    """Its state at rest."""
    response: Step[Response]
    """Its nonlinear response."""
    linear: Linear
    """Its linear limits."""
    modes: Step[HarmonicModes]
    """Modes with all contacts stuck that its response takes; with an accuracy those of the first
    harmonic."""
    preload_name: str = ""
    """The swept values that the preload depends on."""
    gauges: Step[Gauges] | None = None
    """Strain gauges, if the study has any."""
    choice: MeshChoice | None = None
    """What an accuracy chose before, if the study has one."""
    other: Step[Response] | None = None
    """The response in the other direction, where both are wanted."""
    analyses: Mapping[str, tuple[Step[Any], ...]] = field(default_factory=dict)
    """Products of the analyses that its file asks for."""
    pieces: tuple[Step[Any], ...] = ()
    """What these are made from and can be computed side by side."""

    @property
    def meshes(self) -> Mapping[str, Step[Part]]:
        """Meshes of its parts; none where parts are matrices."""
        return self.structure.meshes

    def part(self, name: str, nodal_diameter: int) -> Step[Any]:
        """A component at a nodal diameter."""
        return self.structure.component(name, nodal_diameter)

    @property
    def responses(self) -> tuple[Step[Response], ...]:
        """Its nonlinear responses, in one direction or both."""
        return (self.response,) if self.other is None else (self.response, self.other)

    @property
    def analysed(self) -> tuple[Step[Any], ...]:
        """The steps of all analyses."""
        return tuple(each for steps in self.analyses.values() for each in steps)

    def turned(self, by_response: Collection[str]) -> "Planned":
        """The same with both directions exchanged, those of analyses of each response, too."""
        assert self.other is not None
        analyses = {k: v[::-1] if k in by_response else v for k, v in self.analyses.items()}
        return replace(self, response=self.other, other=self.response, analyses=analyses)

    def solved(self, response: Response) -> "Planned":
        """The same when it is known which nodal diameters the response took."""
        tried = response.estimates.tried if response.estimates else response.harmonics
        diameters = diameters_of(self.case.problem, tried)
        if diameters == self.diameters:
            return self
        return replace(self, diameters=diameters, system=self.structure.system(diameters))


def plan(
    cases: Sequence[Case],
    progress: Progress = lambda *_: None,
    choices: Sequence[MeshChoice | None] = (),
) -> tuple[Planned, ...]:
    """Steps of every case; `choices` are what accuracies chose for them."""
    found: list[Planned] = []
    # the nodal diameter that is reduced last
    last = None if any(choices) else max(max(diameters_of(case.problem)) for case in cases)
    for case, choice in zip(cases, choices or [None] * len(cases), strict=True):
        given = case.problem if choice is None else choice.study
        structure: CaseStructure
        structure = (
            StudyStructure(given, last=last) if isinstance(given, Study) else SceneStructure(given)
        )
        found.append(_planned(case, structure, choice, found[0] if found else None, progress))
    cases = [each.case for each in found]
    linear = label(cases, [each.linear.key for each in found])
    preload = label(cases, [each.preload.key for each in found])
    return tuple(
        replace(each, linear=replace(each.linear, name=name), preload_name=other)
        for each, name, other in zip(found, linear, preload, strict=True)
    )


def _planned(
    case: Case,
    structure: CaseStructure,
    choice: MeshChoice | None,
    planned: Planned | None,
    progress: Progress,
) -> Planned:
    """Steps of a case; with an accuracy the linear response of the `planned` says what counts."""
    given = structure.problem
    case = replace(case, problem=given)
    linear = linear_of(structure)
    diameters = structure.loaded
    if choice is None:
        diameters = diameters_of(given)
    system, modes = structure.system(diameters), linear.modes
    if diameters != structure.loaded:
        modes = structure.stuck_modes(diameters, linear.modes)
    at_rest = structure.system(structure.loaded)
    other = None
    if choice is None:
        swept = partial(response_step, case.name, given, system, linear.limits, modes, progress)
        response = swept()
        other = swept("down") if given.response.direction == "both" else None
    else:
        assert isinstance(structure, StudyStructure)
        free = (linear if planned is None else planned.linear).responses["free"]
        response = _adaptive_step(case.name, structure, choice.budget, linear, free, progress)
    gauged = given if isinstance(given, Study) and given.outputs.gauges else None
    return Planned(
        case=case,
        structure=structure,
        diameters=diameters,
        system=system,
        preload=preload_step(given.response.friction, at_rest, linear.modes),
        response=response,
        linear=linear,
        modes=modes,
        gauges=None if gauged is None else gauges_step(gauged),
        choice=choice,
        other=other,
    )
