"""How much the meshes raise the natural frequencies of the joined structure, by estimate.

The modes of the reduced structure, interlock free and stuck, are expanded to all nodes of both
parts, where `fem.excess_stiffness` estimates by how much each mesh is too stiff for them:

    Δf/f = Σ_parts Δ / (2 ω²)        at unit modal mass.

Where the study takes this off (`mesh.correction`), a quarter of it remains in doubt.

The nodal diameters of higher harmonics get the errors of the same frequencies at that of the first.

How much of the peak's amplitude stands in doubt because of the meshes, by each study's own peak.

What a mesh adds to the stiffness (`vanelock.rom.joining.mesh_excess`) lowers or raises the friction
peak by the peak's own gradient. It acts in two ways that have little to do with one another: at
rest it changes how interference loads the joints, in vibration how the structure yields to them. Of
either, by the vane and by the casing, a quarter remains in doubt where it is taken off; the four
add up, since nothing says that they cancel. Where it is not taken off, their sum with its signs is
an error besides.

One harmonic is enough to know a gradient to some tens of per cent.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vanelock import fem, nonlinear, rom
from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.input.cases.values import diameter_of
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.pipeline.step import Step, step
from vanelock.rom import MeshExcess, System
from vanelock.rom.joining.mesh_excess import DOUBT
from vanelock.stages.parts.components import PARTS, mesh_step, recovery_step
from vanelock.stages.parts.segment import ESTIMATED, StudyStructure
from vanelock.stages.response.limits import Limits, frequencies
from vanelock.stages.response.responses import frequency_keys

MODES = 5
"""Modes of the stuck structure that are expanded, the mode of interest and its next ones."""


@dataclass(frozen=True)
class MeshErrors(Product):
    """Estimated relative errors of natural frequencies by the meshes.

    Attributes
    ----------
    frequency : (m,) float
        Of the modes with the interlock stuck, Hz, ascending.
    parts : (m, 2) float
        What the vane's and the casing's mesh contribute.
    free : (2,) float
        The same of the mode of interest with the interlock free.
    stuck_mode : int
        Place of the mode of interest among the others.
    """

    frequency: Floats = field(metadata={"unit": "Hz"})
    parts: Floats
    free: Floats
    stuck_mode: int

    @property
    def interest(self) -> float:
        """The larger error of the mode of interest, free and stuck."""
        return float(max(self.free.sum(), self.parts[self.stuck_mode].sum()))

    @property
    def vane_share(self) -> float:
        """Of the vane's mesh in that error; a half where there is none."""
        by_part = max(self.free, self.parts[self.stuck_mode], key=np.sum)
        return float(by_part[0] / by_part.sum()) if by_part.sum() else 0.5

    def at(self, nodal_diameter: int, frequency: Floats) -> Floats:
        """(n,) errors of natural frequencies (n,), Hz, of the stuck structure.

        Between the known ones they follow a line, beyond they stay as they are.
        """
        errors = self.parts.sum(axis=1)
        return np.asarray(np.interp(frequency, self.frequency, errors))


def mesh_errors_step(study: Study, system: Step[System], limits: Step[Limits]) -> Step[MeshErrors]:
    """Estimates for the meshes of a case, by its linear system and limits."""
    k = diameter_of(study, 1)
    recovered = [recovery_step(study, part, k) for part in PARTS]
    corrects = study.mesh.correction != "none"

    def compute(system: System, limits: Limits, *recoveries: rom.Recovery) -> MeshErrors:
        count = min(max(MODES, limits.stuck_mode + 3), len(system.at(k).K))
        closed = ~system.contacts.opens
        stuck, shapes = rom.linear_modes(system, k, count)
        free, free_shapes = rom.linear_modes(system, k, limits.free_mode + 1, closed)
        x = np.hstack([shapes, free_shapes[:, -1:]])
        omega2 = (2 * np.pi * np.append(stuck, free[-1])) ** 2
        raised, own = [], system.at(k).split(x)
        for name, recovery in zip(PARTS, recoveries, strict=True):
            u = recovery.displacement(own[name], k)
            taken_off = corrects and recovery.model.part.cell_type == ESTIMATED
            share = DOUBT if taken_off else 1.0
            raised.append(share * np.diagonal(fem.excess_stiffness(recovery.model, u)).real)
        none, moves = np.zeros((count + 1, 2)), omega2[:, None] > 0
        errors = np.divide(np.array(raised).T, 2 * omega2[:, None], out=none, where=moves)
        return MeshErrors(stuck, errors[:-1], errors[-1], limits.stuck_mode)

    needs = (system, limits, *recovered)
    inputs = {"corrects": corrects}
    return step("mesh errors", "fem", inputs, MeshErrors, needs, compute)


AMPLITUDE = {"none": 1.5, "modal": 3.0}
"""Error of the peak's amplitude over that of its frequency, by `mesh.correction`, in the example:
of peaks that are not known (docs/theory/mesh_correction.md)."""


@dataclass(frozen=True)
class AmplitudeErrors(Product):
    """What the meshes add to a peak's amplitude, relative to it, to first order.

    Attributes
    ----------
    parts : (2, 2) float
        By the vane's and the casing's mesh, at rest and in vibration. NaN where no peak with a
        gradient was found, or a part's elements have no estimate.
    corrected : bool
        Whether it is taken off.
    """

    parts: Floats
    corrected: bool

    @property
    def total(self) -> float:
        """Estimated relative error of the amplitude."""
        left = 0.0 if self.corrected else abs(float(self.parts.sum()))
        return left + DOUBT * float(np.abs(self.parts).sum())

    @property
    def vane_share(self) -> float:
        """Of the vane's mesh in what both add; NaN where that is not known."""
        added = np.abs(self.parts).sum(axis=1)
        return float(added[0] / added.sum()) if added.sum() else np.nan


def amplitude_errors_step(
    structure: StudyStructure, system: Step[System], limits: Step[Limits]
) -> Step[AmplitudeErrors]:
    """Estimates for a case by its system and its limits."""
    study = structure.problem
    corrects = study.mesh.correction != "none"
    k, response = diameter_of(study, 1), study.response
    options: dict[str, Any] = {
        "harmonics": 1,
        "coupling": response.coupling,
        "friction": response.friction,
    }
    excess = tuple(map(structure.mesh_excess, structure.loaded))
    meshes = tuple(mesh_step(study, part) for part in PARTS)

    def compute(system: System, limits: Limits, *others: Part | MeshExcess) -> AmplitudeErrors:
        """What either part's excess, N/m by nodal diameter, adds at rest and in vibration."""
        unknown = AmplitudeErrors(np.full((2, 2), np.nan), corrects)
        if any(isinstance(each, Part) and each.cell_type != ESTIMATED for each in others):
            return unknown
        wanted = np.asarray(frequencies(study, limits))
        near = float(wanted.min()), float(wanted.max())
        try:
            found = nonlinear.peak_gradient(system, near, nonlinear.Options(**options))
        except InputError:
            return unknown
        if found.peak.sharp:  # it moves by what its contacts do
            return unknown
        stiffness = {
            j: matrices.stiffness
            for each in others
            if isinstance(each, MeshExcess)
            for j, matrices in each.diameters.items()
        }
        acting: tuple[tuple[int, ...], ...] = ((0,), (k,) if k else ())
        added = [
            [found.at_peak.by_stiffness({j: stiffness[j][part] for j in at}) for at in acting]
            for part in range(len(PARTS))
        ]
        return AmplitudeErrors(np.array(added) / found.amplitude, corrects)

    needs = (system, limits, *meshes, *excess)
    inputs = {**frequency_keys(study), "corrects": corrects, "options": options}
    return step("mesh errors, peak", "nonlinear", inputs, AmplitudeErrors, needs, compute)


def amplitude_error(errors: AmplitudeErrors, frequency: float) -> float:
    """Relative error of a peak's amplitude by the meshes, by that of its frequency if need be."""
    if np.isnan(errors.total):
        return AMPLITUDE["modal" if errors.corrected else "none"] * frequency
    return errors.total
