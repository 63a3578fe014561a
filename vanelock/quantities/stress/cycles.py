"""The stage that turns a response at its peak into stress cycles of every node and gauge."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.product import Product
from vanelock.fem.gauges import skin
from vanelock.mesh import Part
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import code_of
from vanelock.pipeline.step import Step, step
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.stress.fatigue import Cycle, cycle
from vanelock.stages.parts.components import PARTS, model_step
from vanelock.stages.parts.loads import growth
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.solved import as_solved

Stress = NDArray[np.complex128]
Get = Callable[[Step[Any]], Any]

CASING_HARMONICS = 1
"""Highest harmonic whose stress in the casing is recovered: each costs a factorisation at its nodal
diameter, and the vane's own take none."""


@dataclass(frozen=True)
class Stressed(Product):
    """Stress cycles at the peak of a response.

    Attributes
    ----------
    vane, casing : Cycle
        Of every node of a part; the casing's of the mean and the first harmonic.
    gauges : Cycle or None
        Of the strain gauges' places on the vane.
    """

    vane: Cycle
    casing: Cycle
    gauges: Cycle | None


def stressed_step(run: RunResult, planned: Planned, point: int) -> Step[Stressed]:
    """Stress cycles of a case, `solved`, at a point of its response."""
    inputs = {"point": point, "code": code_of("quantities.stress")}
    needs: list[Step[Any]] = [planned.response, *planned.structure.reduced(planned.diameters)]
    needs += [model_step(planned.case.study, part) for part in PARTS]
    if planned.gauges is not None:
        needs.append(planned.gauges)

    def compute(get: Get) -> Stressed:
        top = as_solved(get(planned.response), point)
        vane = harmonics_of(run, planned, top, "vane")
        casing = harmonics_of(run, planned, top, "casing", CASING_HARMONICS)
        gauges = None
        if planned.gauges is not None:
            mesh = get(mesh_step(planned.case.study, "vane"))
            gauges = cycle(_at_places(mesh, vane, get(planned.gauges).positions))
        return Stressed(cycle(vane), cycle(casing), gauges)

    of = planned.case.name
    return step("stress", "rom", inputs, Stressed, tuple(needs), compute, pulls=True, of=of)


def harmonics_of(
    run: RunResult,
    planned: Planned,
    top: Response,
    part: str,
    highest: int | None = None,
) -> Stress:
    """Stress of every node of a part at the only point of a response, (H+1, n, 6) Pa.

    Harmonics above `highest` are left out.
    """
    found, system = [], run.stages.get(planned.system)
    for h in range(min(top.harmonics, highest or top.harmonics) + 1):
        k = int(top.harmonic_diameters[h])
        own = system.at(k).split(np.asarray(top.x[h][0], complex))[part]
        recovery = run.recovery(planned, part, k)
        grown = None if h else growth(planned.case.study, part, recovery.model.part)
        found.append(recovery.stress(own, k, growth=grown))
    return np.stack(found)


def _at_places(part: Part, harmonics: Stress, positions: Sequence[Any]) -> Stress:
    """Stress at points of the surface from that of the nodes, (H+1, g, 6) Pa."""
    surface = skin(part)
    found = []
    for position in np.asarray(positions):
        place = surface.nearest(position)
        found.append(np.einsum("a,hac->hc", place.weights, harmonics[:, place.nodes]))
    return np.stack(found, axis=1)
