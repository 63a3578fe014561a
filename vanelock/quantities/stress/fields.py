"""All nodes of a case: stress cycles and displacements at a peak, and the mode of interest.

They are recovered from reduced coordinates once, and stored; pictures and margins take them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vanelock import fem, rom
from vanelock.common.arrays import Complex, Floats
from vanelock.common.product import Product
from vanelock.fem.gauges import skin
from vanelock.mesh import Part
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import code_of
from vanelock.pipeline.step import Step, step
from vanelock.quantities.stress.fatigue import Cycle, cycle
from vanelock.rom import System
from vanelock.stages.parts.components import PARTS, mesh_step, model_step, recovery_step
from vanelock.stages.parts.loads import growth
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import LIMITS, Limit, Limits
from vanelock.stages.response.responses import as_solved

_Get = Callable[[Step[Any]], Any]

_CASING_HARMONICS = 1
"""Highest harmonic whose stress in the casing is recovered: each costs a factorisation at its nodal
diameter, and the vane's own take none."""


@dataclass(frozen=True)
class NodalFields(Product):
    """All nodes at a point of a response.

    Attributes
    ----------
    vane, casing : Cycle
        Stress cycles of every node of a part; the casing's of the mean and the first harmonic.
    largest : (n,) float
        Largest von Mises stress of the vane in a period, with that at rest, Pa.
    gauges : Cycle or None
        Of the strain gauges' places on the vane.
    vane_shape, casing_shape : (h, n, 3) complex
        Displacement by harmonics from the first, m; `h` as many as are shown.
    """

    vane: Cycle
    casing: Cycle
    largest: Floats = field(metadata={"unit": "Pa"})
    gauges: Cycle | None
    vane_shape: Complex = field(metadata={"unit": "m"})
    casing_shape: Complex = field(metadata={"unit": "m"})

    def shape(self, harmonic: int) -> list[Complex]:
        """(n, 3) displacement of a harmonic, from 1, of vane and casing."""
        return [self.vane_shape[harmonic - 1], self.casing_shape[harmonic - 1]]


@dataclass(frozen=True)
class ModeShapes(Product):
    """The mode of interest, mass-normalised, with contacts free and, where they open, stuck.

    Attributes
    ----------
    vane, casing : (1 or 2, n, 3) complex
        Displacement of every node.
    """

    vane: Complex = field(metadata={"unit": "kg^-0.5"})
    casing: Complex = field(metadata={"unit": "kg^-0.5"})

    def shape(self, which: Limit) -> list[Complex]:
        """(n, 3) of vane and casing, "free" or "stuck"."""
        place = LIMITS.index(which)
        return [self.vane[place], self.casing[place]]


def fields_step(
    planned: Planned, top: Step[Response], point: int, shown: int = 0
) -> Step[NodalFields]:
    """All nodes of a case, `solved`, at a point of a response, with so many harmonics shown."""
    inputs = {"point": point, "shown": shown, "code": code_of("quantities.stress")}
    needs: list[Step[Any]] = [top, planned.system, *planned.structure.reduced(planned.diameters)]
    needs += [model_step(planned.case.study, part) for part in PARTS]
    if planned.gauges is not None:
        needs.append(planned.gauges)

    def compute(get: _Get) -> NodalFields:
        at_point = as_solved(get(top), point)
        vane, vane_shape = _recovered(get, planned, at_point, "vane", at_point.harmonics, shown)
        casing, shape = _recovered(get, planned, at_point, "casing", _CASING_HARMONICS, shown)
        gauges = None
        if planned.gauges is not None:
            mesh = get(mesh_step(planned.case.study, "vane"))
            gauges = cycle(_at_places(mesh, vane, get(planned.gauges).positions))
        largest = fem.peak_von_mises(vane)
        return NodalFields(cycle(vane), cycle(casing), largest, gauges, vane_shape, shape)

    of = planned.case.name
    return step("stress", "rom", inputs, NodalFields, tuple(needs), compute, pulls=True, of=of)


def _recovered(
    get: _Get, planned: Planned, top: Response, part: str, highest: int, shown: int
) -> tuple[Complex, Complex]:
    """Stress (H+1, n, 6), Pa, to a highest harmonic, and displacement (h, n, 3), m, of a part."""
    stresses, shapes, system = list[Any](), list[Any](), get(planned.system)
    shown, highest = min(top.harmonics, shown), min(top.harmonics, highest)
    for h in range(max(highest, shown) + 1):
        k = int(top.harmonic_diameters[h])
        own = system.at(k).split(np.asarray(top.x[h][0], complex))[part]
        recovery = _recovery(get, planned, part, k)
        if h <= highest:
            grown = None if h else growth(planned.case.study, part, recovery.model.part)
            stresses.append(recovery.stress(own, k, growth=grown))
        if 1 <= h <= shown:
            shapes.append(recovery.displacement(own, k))
    nodes = stresses[0].shape[0]
    return np.stack(stresses), np.array(shapes, complex).reshape(-1, nodes, 3)


def _recovery(get: _Get, planned: Planned, part: str, k: int) -> rom.Recovery:
    """What takes a part's reduced coordinates to its nodes; too large to be remembered."""
    recovery = recovery_step(planned.case.study, part, planned.structure.folded(k))
    found: rom.Recovery = recovery.compute(*map(get, recovery.needs))
    return found


def _at_places(part: Part, harmonics: Complex, positions: Sequence[Any]) -> Complex:
    """Stress at points of the surface from that of the nodes, (H+1, g, 6) Pa."""
    surface = skin(part)
    found = []
    for position in np.asarray(positions):
        place = surface.nearest(position)
        found.append(np.einsum("a,hac->hc", place.weights, harmonics[:, place.nodes]))
    return np.stack(found, axis=1)


def mode_shapes_step(planned: Planned) -> Step[ModeShapes]:
    """The mode of interest of a study's case."""
    linear = planned.linear
    needs = [linear.system, linear.limits, *planned.structure.reduced(planned.structure.loaded)]
    needs += [model_step(planned.case.study, part) for part in PARTS]

    def compute(get: _Get) -> ModeShapes:
        system, limits = get(linear.system), get(linear.limits)
        k = limits.nodal_diameter
        shapes = list(_modes(system, limits))
        made = []
        for part in PARTS:
            recovery = _recovery(get, planned, part, k)
            own = [system.at(k).split(shape)[part] for shape in shapes]
            made.append(np.array([recovery.displacement(x, k) for x in own]))
        return ModeShapes(*made)

    return step("mode shapes", "rom", {}, ModeShapes, tuple(needs), compute, pulls=True)


def _modes(system: System, limits: Limits) -> list[Complex]:
    """The mode of interest in reduced coordinates, contacts free and, where they open, stuck."""
    k, found = limits.nodal_diameter, []
    for which in limits.conditions:
        place, _ = limits.of_interest(which)
        closed = ~system.contacts.opens if which == "free" else None
        modes = rom.linear_modes(system, k, place + 1, closed)[1]
        found.append(np.asarray(modes[:, place], complex))
    return found
