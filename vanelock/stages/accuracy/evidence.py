"""Gathers what the errors of a case need: with an accuracy words, costs and evidence."""

import numpy as np

from vanelock import rom
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages, Step
from vanelock.rom import Component
from vanelock.stages.accuracy.amplitude_errors import AmplitudeErrors, amplitude_errors_step
from vanelock.stages.accuracy.errors import Errors, errors
from vanelock.stages.accuracy.left_out import LeftOut, left_out
from vanelock.stages.parts.components import PARTS, prepared_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.monitor import Monitor


def amplitude_errors_of(planned: Planned) -> Step[AmplitudeErrors] | None:
    """What the meshes leave in doubt of the peak of a study's case without an accuracy."""
    study = planned.case.given
    if not isinstance(study, Study) or planned.chosen_mesh is not None:
        return None
    casings = planned.base
    return amplitude_errors_step(
        study, planned.system, planned.linear.limits, planned.rom["vane"], casings, casings
    )


def judged(
    planned: Planned, response: Response, stages: Stages, watched: Monitor
) -> tuple[Errors, list[LeftOut]]:
    """Errors of a case by source, and what it left out."""
    chosen_mesh = planned.chosen_mesh
    assert chosen_mesh is not None
    limits = stages.get(planned.linear.limits)
    found = errors(
        response,
        chosen_mesh.budget,
        chosen_mesh.rounds,
        chosen_mesh.short,
        _settings(planned, response, stages),
        _costs(planned, stages),
        planned.case.study.mesh.correction,
    )
    N = planned.case.study.ring.sectors
    used = list(planned.diameters)
    never = [k for k in range(N // 2 + 1) if k not in used]
    system = stages.get(planned.system)
    parts = {part: stages.get(planned.rom[part]) for part in PARTS}
    k = limits.nodal_diameter
    above = {part: each.at(k).complete for part, each in parts.items()}
    modes = next((each for each in found.sources if each.name == "modes"), None)
    without = left_out(
        response,
        system.contacts.joint,
        (used, never),
        energies(parts["vane"], parts["casing"], stages.get(planned.linear.system), limits),
        (len(system.output_names), watched.name),
        {part: hertz for part, hertz in above.items() if hertz is not None},
        float("nan") if modes is None else modes.amplitude,
    )
    return found, without


def energies(
    vane: Component, casing: Component, system: rom.System, limits: Limits
) -> dict[str, float]:
    """Shares of the strain energy of the mode of interest, interlock stuck, by part and joint."""
    k, place = limits.nodal_diameter, limits.stuck_mode
    _, shapes = rom.linear_modes(system, k, place + 1)
    x = shapes[:, -1]
    found = {}
    for name, part, q in zip(PARTS, (vane, casing), rom.split(vane, casing, x), strict=True):
        found[name] = float((q.conj() @ part.at(k).K @ q).real)
    moved = np.abs(system.contact_rows(k) @ x) ** 2 * system.contacts.stiffness
    for joint in dict.fromkeys(system.contacts.joint):
        own = [i for i, each in enumerate(system.contacts.joint) if each == joint]
        found[f"{joint} joint"] = float(moved[own].sum())
    total = sum(found.values())
    return {name: energy / total for name, energy in found.items()}


def _settings(planned: Planned, response: Response, stages: Stages) -> dict[str, str]:
    """What was chosen of each setting, in words."""
    chosen_mesh, study = planned.chosen_mesh, planned.case.study
    assert chosen_mesh is not None
    pinned = chosen_mesh.budget.pinned
    last, tried = chosen_mesh.rounds[-1], len(chosen_mesh.rounds)
    parts = [stages.get(planned.rom[part]) for part in PARTS]
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
    own = {planned.rom["vane"].key} | prepared | needed
    assert planned.chosen_mesh is not None
    tried = len(planned.chosen_mesh.rounds) > 1  # reductions of other meshes; else of other cases
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
