"""How much the meshes raise the natural frequencies of the joined structure, by estimate.

The modes of the reduced structure, interlock free and stuck, are expanded to all nodes of both
parts, where `fem.excess_stiffness` estimates by how much each mesh is too stiff for them:

    Δf/f = Σ_parts Δ / (2 ω²)        at unit modal mass.

Where the study takes this off (`mesh.correction`), a quarter of it remains in doubt.

The nodal diameters of higher harmonics get the errors of the same frequencies at that of the first.
"""

from dataclasses import dataclass, field

import numpy as np

from vanelock import fem, rom
from vanelock.common.arrays import Floats
from vanelock.common.product import Product
from vanelock.input.cases.values import diameter_of
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.rom.joining.mesh_excess import DOUBT
from vanelock.stages.parts.components import PARTS, recovery_step
from vanelock.stages.parts.mesh_excess import ESTIMATED
from vanelock.stages.response.limits import Limits

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
        errors = np.divide(
            np.array(raised).T, 2 * omega2[:, None], out=np.zeros((count + 1, 2)),
            where=omega2[:, None] > 0,
        )  # fmt: skip
        return MeshErrors(stuck, errors[:-1], errors[-1], limits.stuck_mode)

    needs = (system, limits, *recovered)
    inputs = {"corrects": corrects}
    return step("mesh errors", "fem", inputs, MeshErrors, needs, compute)
