"""How much of the peak's amplitude stands in doubt because of the meshes, by each study's own peak.

What a mesh adds to the stiffness (`vanelock.rom.joining.mesh_excess`) lowers or raises the friction
peak by the peak's own gradient. It acts in two ways that have little to do with one another: at
rest it changes how interference loads the joints, in vibration what the joints are worth. Of the
vane and of the casing, in either, a quarter of what is taken off remains in doubt, all of it where
nothing is; the errors of these four add up, since nothing says that they cancel.

One harmonic is enough to know a gradient to some tens of per cent.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.input.schema.study import Study
from vanelock.mesh import Part
from vanelock.pipeline.step import Step, step
from vanelock.rom import Component, MeshExcess, System
from vanelock.rom.joining.mesh_excess import DOUBT
from vanelock.stages.accuracy.mesh_sizes import AMPLITUDE
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.diameters import diameter_of
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.parts.systems import ESTIMATED, excess_steps
from vanelock.stages.response.limits import Limits, frequencies

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class AmplitudeErrors(Product):
    """What the meshes leave in doubt of a peak's amplitude, relative to it.

    Attributes
    ----------
    parts : (2, 2) float
        By the vane's and the casing's mesh, at rest and in vibration. NaN where no peak with a
        gradient was found, or a part's elements have no estimate.
    """

    parts: Floats

    @property
    def total(self) -> float:
        """All of them together."""
        return float(np.abs(self.parts).sum())


def amplitude_errors_step(
    study: Study,
    system: Step[System],
    limits: Step[Limits],
    vane: Step[Component],
    casings: Sequence[Step[Component]],
    base: Sequence[Step[Component]] = (),
) -> Step[AmplitudeErrors]:
    """Estimates for a case whose system is joined of a vane and of casings, `base` as there."""
    corrects = study.mesh.correction != "none"
    k, response = diameter_of(study, 1), study.response
    options = {"harmonics": 1, "coupling": response.coupling, "friction": response.friction}
    mesh = study.mesh.model_copy(update={"correction": "modal"})
    excess = excess_steps(study.model_copy(update={"mesh": mesh}), vane, casings, base)
    meshes = tuple(mesh_step(study, part) for part in PARTS)

    def compute(system: System, limits: Limits, *others: Part | MeshExcess) -> AmplitudeErrors:
        parts = [each for each in others if isinstance(each, Part)]
        found = [each for each in others if isinstance(each, MeshExcess)]
        if any(part.cell_type != ESTIMATED for part in parts):
            return AmplitudeErrors(np.full((2, 2), np.nan))
        wanted = np.asarray(frequencies(study, limits))
        near = float(wanted.min()), float(wanted.max())
        diameters = {k: each for excess in found for k, each in excess.diameters.items()}
        return amplitude_errors(
            system, near, nonlinear.Options(1, response.coupling, response.friction),
            {0: diameters[0].stiffness}, {k: diameters[k].stiffness} if k else {},
            DOUBT if corrects else 1.0,
        )  # fmt: skip

    needs = (system, limits, *meshes, *excess)
    inputs = {"corrects": corrects, "options": options}
    return step("mesh errors, peak", "nonlinear", inputs, AmplitudeErrors, needs, compute)


def amplitude_errors(
    system: System,
    near: tuple[float, float],
    options: nonlinear.Options,
    rest: Mapping[int, NDArray[np.generic]],
    vibration: Mapping[int, NDArray[np.generic]],
    share: float,
) -> AmplitudeErrors:
    """Estimates from (2, n, n) of what both parts' meshes add, N/m, by nodal diameter."""
    parts = np.zeros((2, 2))
    try:
        peak = nonlinear.peak_gradient(system, near, options)
    except InputError:
        return AmplitudeErrors(np.full((2, 2), np.nan))
    if peak.peak.sharp:
        return AmplitudeErrors(np.full((2, 2), np.nan))
    for column, excess in enumerate((rest, vibration)):
        for part in range(len(PARTS)):
            changes = {k: each[part] for k, each in excess.items()}
            parts[part, column] = share * peak.by_stiffness(changes) / peak.amplitude
    return AmplitudeErrors(parts)


def amplitude_error(found: AmplitudeErrors, frequency: float, correction: str) -> float:
    """Relative error of a peak's amplitude by the meshes, from that of its frequency if need be."""
    if np.isnan(found.total):
        return AMPLITUDE[correction] * frequency
    return found.total
