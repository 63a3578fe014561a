"""Gathers what the errors of a case need: with an accuracy words, costs and evidence."""

from collections.abc import Mapping

import numpy as np

from vanelock import rom
from vanelock.input.cases.values import diameter_of
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages, Step
from vanelock.rom import Component
from vanelock.stages.accuracy.amplitude_errors import AmplitudeErrors, amplitude_errors_step
from vanelock.stages.accuracy.errors import Errors, errors
from vanelock.stages.accuracy.left_out import LeftOut, left_out
from vanelock.stages.parts.components import PARTS, prepared_step
from vanelock.stages.parts.study_structure import StudyStructure
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.monitor import Monitor


def amplitude_errors_of(planned: Planned) -> Step[AmplitudeErrors] | None:
    """What the meshes leave in doubt of the peak of a study's case without an accuracy."""
    structure = planned.structure
    if not isinstance(structure, StudyStructure) or planned.choice is not None:
        return None
    return amplitude_errors_step(structure, planned.system, planned.linear.limits)


def judged(
    planned: Planned, response: Response, stages: Stages, watched: Monitor
) -> tuple[Errors, list[LeftOut]]:
    """Errors of a case by source, and what it left out."""
    choice = planned.choice
    assert choice is not None
    limits = stages.get(planned.linear.limits)
    found = errors(
        response,
        choice.budget,
        choice.rounds,
        choice.short,
        _settings(planned, response, stages),
        _costs(planned, stages),
        planned.case.study.mesh.correction,
    )
    N = planned.case.study.ring.sectors
    used = list(planned.diameters)
    never = [k for k in range(N // 2 + 1) if k not in used]
    system = stages.get(planned.system)
    k = limits.nodal_diameter
    parts = {part: stages.get(planned.part(part, k)) for part in PARTS}
    above = {part: each.at(k).complete for part, each in parts.items()}
    modes = next((each for each in found.sources if each.name == "modes"), None)
    without = left_out(
        response,
        system.contacts.joint,
        (used, never),
        _energies(parts, stages.get(planned.linear.system), limits),
        (len(system.output_names), watched.name),
        {part: hertz for part, hertz in above.items() if hertz is not None},
        float("nan") if modes is None else modes.amplitude,
    )
    return found, without


def _energies(
    parts: Mapping[str, Component], system: rom.System, limits: Limits
) -> dict[str, float]:
    """Shares of the strain energy of the mode of interest, interlock stuck, by part and joint."""
    k, place = limits.nodal_diameter, limits.stuck_mode
    _, shapes = rom.linear_modes(system, k, place + 1)
    x = shapes[:, -1]
    found = {}
    own = system.at(k).split(x)
    for name, part in parts.items():
        found[name] = float((own[name].conj() @ part.at(k).K @ own[name]).real)
    moved = np.abs(system.contact_rows(k) @ x) ** 2 * system.contacts.stiffness
    for joint in dict.fromkeys(system.contacts.joint):
        own = [i for i, each in enumerate(system.contacts.joint) if each == joint]
        found[f"{joint} joint"] = float(moved[own].sum())
    total = sum(found.values())
    return {name: energy / total for name, energy in found.items()}


def _settings(planned: Planned, response: Response, stages: Stages) -> dict[str, str]:
    """What was chosen of each setting, in words."""
    choice, study = planned.choice, planned.case.study
    assert choice is not None
    pinned = choice.budget.pinned
    last, tried = choice.rounds[-1], len(choice.rounds)
    k = diameter_of(study, 1)
    parts = [stages.get(planned.part(part, k)) for part in PARTS]
    vectors = " + ".join(str(part.fixed_modes) for part in parts)
    assert response.estimates is not None
    own = response.estimates.harmonics
    spread = f"{own.min()} to {own.max()}" if own.min() < own.max() else str(own.max())
    accuracy = study.rom.accuracy
    chosen = {
        "mesh": f"mesh.size: {last.size}, {last.dofs:,} dofs" + _of(tried, "mesh", "meshes"),
        "modes": f"rom.accuracy: {accuracy:.1g}, {vectors} vectors"
        if accuracy
        else f"{vectors} vectors",
        "harmonics": f"response.harmonics: {spread} by point",
        "frequencies": f"response.points: {response.points}",
        "samples": f"response.samples: {response.samples}",
    }
    for source, key in pinned.items():
        chosen[source] = f"{chosen[source].partition(':')[2].strip()}: {key} is given"
    return chosen


def _of(count: int, one: str, many: str) -> str:
    return f" ({count} {one if count == 1 else many} tried)"


def _costs(planned: Planned, stages: Stages) -> dict[str, float]:
    """Processor time by source, s: of the stages that are there because of it."""
    k = stages.get(planned.linear.limits).nodal_diameter
    needed = {planned.part("casing", each).key for each in (0, k)}
    further = {planned.part("casing", each).key for each in planned.diameters} - needed
    prepared = {prepared_step(planned.case.study, part).key for part in PARTS}
    own = {planned.part("vane", 0).key} | prepared | needed
    assert planned.choice is not None
    tried = len(planned.choice.rounds) > 1  # reductions of other meshes; else of other cases
    meshing = ("mesh", "fem", "rom") if tried else ("mesh", "fem")
    costs = dict.fromkeys(("mesh", "modes", "harmonics"), 0.0)
    for key, done in stages.done.items():
        if key in further or key == planned.response.key:
            source = "harmonics"
        elif key in own:
            source = "modes"
        elif done.stage.partition(" ")[0] in meshing:
            source = "mesh"
        else:
            continue
        costs[source] += stages.cpu.get(key, 0.0)
    return costs
