"""Strain gauges of a study: where they sit, and what they read in a response."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock import fem, mesh, rom
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.fem.gauges import skin
from vanelock.input.schema.outputs import GaugeKeys
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Response
from vanelock.nonlinear.forced_response.response import half_peak_to_peak
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.parts.components import recovery_step


@dataclass(frozen=True)
class Gauges(Product):
    """Strain gauges on the vane.

    Attributes
    ----------
    names : tuple of str
        Where each is.
    positions, directions : (g, 3) float
        Its middle on the surface, m, and its unit direction.
    rows : (g, n) float
        Strain = rows @ the vane's n reduced coordinates, at any nodal diameter; 1/m.
    """

    names: tuple[str, ...]
    positions: NDArray[np.float64] = field(metadata={"unit": "m"})
    directions: NDArray[np.float64]
    rows: NDArray[np.float64] = field(metadata={"unit": "1/m"})

    def watched(self, system: System, gauge: int) -> System:
        """The system with a gauge's strain as its only output, direction 0."""
        diameters = {}
        for k, matrices in system.diameters.items():
            output = np.zeros((1, 3, len(matrices.K)))
            np.add.at(output[0, 0], matrices.parts["vane"], self.rows[gauge])
            diameters[k] = replace(matrices, output=output)
        return replace(system, diameters=diameters, output_names=(self.names[gauge],))

    def read(self, response: Response, system: System) -> "Strain":
        """What they read in a response of a system."""
        parts = [
            (self.rows @ system.at(int(k)).split(response.x[h].T)["vane"]).T
            for h, k in enumerate(response.harmonic_diameters)
        ]
        return Strain(self, np.stack(parts, axis=1).astype(complex))


@dataclass(frozen=True)
class Strain:
    """What gauges read in a response.

    Attributes
    ----------
    gauges : Gauges
    harmonics : (p, H+1, g) complex
        Coefficients of harmonics 0, the mean, to H at each point.
    """

    gauges: Gauges
    harmonics: NDArray[np.complex128]

    @property
    def amplitude(self) -> NDArray[np.float64]:
        """(p, g) half the peak-to-peak over a period."""
        return half_peak_to_peak(self.harmonics.swapaxes(0, 1))


def gauges_step(study: Study) -> Step[Gauges]:
    """The gauges of a study on its vane; costs a factorisation and a solve for each gauge."""
    wanted = study.outputs.gauges
    dimensions = study.vane
    if not isinstance(dimensions, mesh.VaneDimensions):  # the study is refused before
        raise InputError("outputs.gauges: their places need dimensions, while vane.mesh is given")
    inputs: dict[str, Any] = {
        "gauges": [gauge.model_dump() for gauge in wanted],
        "dimensions": dimensions.model_dump(),
        "sectors": study.ring.sectors,
    }

    def compute(recovery: rom.Recovery) -> Gauges:
        part = recovery.model.part
        surface = skin(part)
        placed = []
        for i, gauge in enumerate(wanted):
            place = mesh.on_aerofoil(
                dimensions, study.ring.sectors, **gauge.model_dump(exclude={"length"})
            )
            try:
                found = fem.gauge(
                    part,
                    place.position,
                    place.direction,
                    gauge.length,
                    place.normal,
                    surface=surface,
                )
            except InputError as error:
                raise InputError(f"outputs.gauges[{i}]: {error}") from None
            placed.append(found)
        rows = recovery.rows(sp.vstack([each.row for each in placed]), 0)
        return Gauges(
            tuple(name(gauge) for gauge in wanted),
            np.array([each.position for each in placed]),
            np.array([each.direction for each in placed]),
            np.ascontiguousarray(rows.real),
        )

    needs = (recovery_step(study, "vane"),)
    return step("gauges", "rom", inputs, Gauges, needs, compute)


def name(gauge: GaugeKeys) -> str:
    """What tables and files call a gauge."""
    along = gauge.direction if isinstance(gauge.direction, str) else f"{gauge.direction:g} deg"
    return (
        f"aerofoil {gauge.aerofoil}, {gauge.side} side, span {gauge.span:g}, "
        f"chord {gauge.chord:g}, along {along}"
    )
