"""Gathers what the errors of a case need: with an accuracy words, costs and evidence.

Where meshes have their error: what each element adds to the stiffness of the mode of interest.

The places listed are the elements that add most, each with what lies around it.

What neglected harmonics are worth at the peak of a case without an accuracy.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from vanelock import fem, nonlinear, rom
from vanelock.common.arrays import Floats, Integers
from vanelock.common.product import Product
from vanelock.common.tables import Cell, Column, Table, counted, heads
from vanelock.input.cases.values import diameter_of
from vanelock.input.schema.structure.own_mesh import OwnCasing, OwnVane
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Stages, Step, step
from vanelock.rom import Component, System
from vanelock.stages.accuracy.errors import Errors, LeftOut, errors, left_out
from vanelock.stages.accuracy.mesh_errors import AmplitudeErrors, amplitude_errors_step
from vanelock.stages.parts.components import PARTS, prepared_step, recovery_step
from vanelock.stages.parts.segment import StudyStructure
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.responses import Monitor, monitor
from vanelock.stages.response.summary import peak_of


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
    used, k = planned.diameters, limits.nodal_diameter
    parts = {part: stages.get(planned.part(part, k)) for part in PARTS}
    settings = _settings(planned, response, parts)
    found = errors(response, choice, settings, _costs(planned, stages))
    without = left_out(
        response,
        stages.get(planned.system),
        watched.name,
        (used, sorted({*planned.structure.every_diameter} - {*used})),
        _energies(parts, stages.get(planned.linear.system), limits),
        {part: each.at(k).complete for part, each in parts.items()},
        next((each.amplitude for each in found.sources if each.name == "modes"), float("nan")),
    )
    return found, list(without)


def _energies(
    parts: Mapping[str, Component], system: rom.System, limits: Limits
) -> dict[str, float]:
    """Shares of the strain energy of the mode of interest, interlock stuck, by part and joint."""
    k, place = limits.nodal_diameter, limits.stuck_mode
    _, shapes = rom.linear_modes(system, k, place + 1)
    x = shapes[:, -1]
    own = system.at(k).split(x)
    found = {
        name: float((own[name].conj() @ part.at(k).K @ own[name]).real)
        for name, part in parts.items()
    }
    moved = np.abs(system.contact_rows(k) @ x) ** 2 * system.contacts.stiffness
    joints = np.array(system.contacts.joint)
    for joint in dict.fromkeys(system.contacts.joint):
        found[f"{joint} joint"] = float(moved[joints == joint].sum())
    total = sum(found.values())
    return {name: energy / total for name, energy in found.items()}


def _settings(
    planned: Planned, response: Response, parts: Mapping[str, Component]
) -> dict[str, str]:
    """What was chosen of each setting, in words."""
    choice, study = planned.choice, planned.case.study
    assert choice is not None
    pinned = choice.budget.pinned
    last = choice.rounds[-1]
    vectors = " + ".join(str(part.fixed_modes) for part in parts.values())
    assert response.estimates is not None
    own = response.estimates.harmonics
    spread = f"{own.min()} to {own.max()}" if own.min() < own.max() else str(own.max())
    meshes = counted(len(choice.rounds), "mesh")
    accuracy = f"rom.accuracy: {study.rom.accuracy:.1g}, " if study.rom.accuracy else ""
    chosen = {
        "mesh": f"mesh.size: {last.size}, {last.dofs:,} dofs ({meshes} tried)",
        "modes": f"{accuracy}{vectors} vectors",
        "harmonics": f"response.harmonics: {spread} by point",
        "frequencies": f"response.points: {response.points}",
        "samples": f"response.samples: {response.samples}",
    }
    for source, key in pinned.items():
        chosen[source] = f"{chosen[source].partition(':')[2].strip()}: {key} is given"
    return chosen


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


COUNT = 6
"""Places listed."""
AROUND = 3.0
"""What belongs to a place, in lengths of its element's edges."""


@dataclass(frozen=True)
class ErrorPlaces(Product):
    """What the meshes add to the stiffness of the mode of interest with the interlock stuck.

    Attributes
    ----------
    vane, casing : (n,) float
        At each node, energy per volume over the mean of both parts.
    part : (p,) int
        Of each place, 0 the vane, 1 the casing.
    share : (p,) float
        Of all that the meshes add, what lies around the place.
    position : (p, 3) float
        Middle of its element, m.
    edge : (p,) float
        Mean length of its element's edges, m.
    """

    vane: Floats
    casing: Floats
    part: Integers
    share: Floats
    position: Floats = field(metadata={"unit": "m"})
    edge: Floats = field(metadata={"unit": "m"})

    @property
    def table(self) -> Table:
        """A line for each place, the worst first."""
        columns = (
            *heads("part"),
            Column("share of the mesh's error", "%", ".3g", "share_percent"),
            Column("radius", "mm", ".1f", "radius_mm"),
            Column("angle", "°", ".2f", "angle_degrees"),
            Column("z", "mm", ".1f", "z_mm"),
            Column("element edges", "mm", ".3g", "edge_mm"),
        )
        x, y, z = self.position.T
        part, angle = [PARTS[each] for each in self.part], np.degrees(np.arctan2(y, x))
        cells = part, self.share, np.hypot(x, y), angle, z, self.edge
        rows: list[tuple[Cell, ...]] = list(zip(*cells, strict=True))
        note = (
            "Smaller elements there lower the error most: half the edges, about half of its share"
        )
        return Table("Where the meshes err", columns, rows, (note,), "mesh_error")


def of_own_meshes(planned: Planned) -> Step[ErrorPlaces] | None:
    """The step of a case of which a part is a user's own mesh."""
    study = planned.case.problem
    if not isinstance(study, Study) or not any(
        isinstance(part, OwnVane | OwnCasing) for part in (study.vane, study.casing)
    ):
        return None
    k = diameter_of(study, 1)
    recovered = [recovery_step(study, part, k) for part in PARTS]

    def compute(system: System, limits: Limits, *recovery: rom.Recovery) -> ErrorPlaces:
        k = limits.nodal_diameter
        shape = rom.linear_modes(system, k, limits.stuck_mode + 1)[1][:, -1]
        own = system.at(k).split(np.asarray(shape, complex))
        energies = [
            fem.excess_by_element(each.model, each.displacement(own[part], k))
            for part, each in zip(PARTS, recovery, strict=True)
        ]
        return _error_places([each.model.part for each in recovery], energies)

    needs = (planned.linear.system, planned.linear.limits, *recovered)
    return step("mesh error by place", "fem", {}, ErrorPlaces, needs, compute)


def _error_places(parts: list[Part], energies: list[Floats]) -> ErrorPlaces:
    """The worst places of both parts, from what each of their elements adds, J."""
    boxes = [_volumes(part) for part in parts]
    mean = sum(e.sum() for e in energies) / sum(volume.sum() for volume, *_ in boxes)
    densities = [
        _at_nodes(part, e, volume) / mean
        for part, e, (volume, *_) in zip(parts, energies, boxes, strict=True)
    ]
    of = np.repeat(np.arange(len(parts)), [len(e) for e in energies])
    energy, middle, edge = (
        np.concatenate(each) for each in (energies, [b[1] for b in boxes], [b[2] for b in boxes])
    )
    left, chosen, share = energy.copy(), [], []
    for _ in range(min(COUNT, len(energy))):
        worst = int(left.argmax())
        near = np.linalg.norm(middle - middle[worst], axis=1) < AROUND * edge[worst]
        near &= of == of[worst]
        chosen.append(worst)
        share.append(float(left[near].sum() / energy.sum()))
        left[near] = 0
    order = np.argsort(share)[::-1]
    places = np.array(chosen)[order]
    return ErrorPlaces(
        densities[0], densities[1], of[places], np.array(share)[order], middle[places], edge[places]
    )


def _volumes(part: Part) -> tuple[Floats, Floats, Floats]:
    """Volumes of the elements' corners' boxes or tetrahedra, middles, and mean edges."""
    corners = part.points[part.cells[:, : 8 if part.cell_type.startswith("hexa") else 4]]
    middle = corners.mean(axis=1)
    edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean(axis=1)
    if corners.shape[1] == 8:
        return edge**3, middle, edge
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    return volume, middle, edge


def _at_nodes(part: Part, energy: Floats, volume: Floats) -> Floats:
    """Energy per volume at nodes: that of their elements together."""
    count = part.cells.shape[1]
    found, around = (
        np.bincount(part.cells.ravel(), np.repeat(each, count), len(part.points))
        for each in (energy, volume)
    )
    return np.divide(found, around, out=np.zeros_like(found), where=around > 0)


@dataclass(frozen=True)
class NeglectedHarmonics(Product):
    """Relative error of a peak's amplitude by neglected harmonics; NaN where it is not known."""

    amplitude: float


def neglected_harmonics_step(planned: Planned) -> Step[NeglectedHarmonics]:
    """The estimate, of the peak of a case's response."""
    wanted = planned.case.problem.outputs.monitor

    def compute(
        system: System, response: Response, linear: System, free: Response
    ) -> NeglectedHarmonics:
        watched = monitor(wanted, linear, free)
        peak = peak_of(response, watched.amplitude(response))
        if peak is None:
            return NeglectedHarmonics(float("nan"))
        at = peak.point, (watched.node, watched.component)
        return NeglectedHarmonics(nonlinear.neglected_harmonics(system, response, *at))

    linear = planned.linear
    needs = (planned.system, planned.response, linear.system, linear.responses["free"])
    inputs = {"monitor": wanted}
    return step(
        "neglected harmonics, peak", "nonlinear", inputs, NeglectedHarmonics, needs, compute
    )
