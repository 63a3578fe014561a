"""Where a study's contacts and strain gauges are, and what gauges read in a response.

The program's own parts know areas by geometry, whether contacts act on them or on nodes: those of
`mesh.patches`, which tile the contact faces. A user's mesh knows them where its contact sets
consist of whole faces.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from vanelock import fem, mesh, rom
from vanelock.common.arrays import Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.fem.gauges import skin
from vanelock.input.cases.values import Problem
from vanelock.input.schema.outputs import GaugeKeys
from vanelock.input.schema.study import Study
from vanelock.mesh import CasingDimensions, Part, VaneDimensions
from vanelock.mesh.contact_patches import hook_overlap, hook_patches, interlock_patches
from vanelock.nonlinear import Response
from vanelock.nonlinear.forced_response.response import half_peak_to_peak
from vanelock.pipeline.step import Step, step
from vanelock.rom import Contacts, System
from vanelock.stages.parts.components import recovery_step

HOOKS = ("hook_front", "hook_rear")
TANGENTS = {"hook": ("circumferential", "axial"), "interlock": ("radial", "along the slant")}
"""The friction directions of the joints of a study, the tangents of `mesh.Part.frames`."""
WORDS = {"hook_front": "front hook", "hook_rear": "rear hook", "interlock_right": "interlock"}


@dataclass(frozen=True)
class Places:
    """Contacts of a case, in the order of its system.

    Attributes
    ----------
    names : tuple of str
        "interlock 3", "front hook 12": counted along their sets, or in their joints.
    joint : tuple of str
        Name of each one's joint.
    nodes : (c,) int
        The vane's node of each; -1 of a contact between matrices.
    points : (c, 3) float
        Its place, m; NaN there.
    area : (c,) float
        m²; NaN where it is not known.
    coefficient : (c,) float
        Wear coefficient, m²/N; NaN where none is given.
    """

    names: tuple[str, ...]
    joint: tuple[str, ...]
    nodes: Integers
    points: Floats
    area: Floats
    coefficient: Floats


def tangents(problem: Problem, joint: str) -> tuple[str, str]:
    """What the two friction directions of a joint's contacts are called."""
    plain = ("tangent 1", "tangent 2")
    return TANGENTS.get(joint, plain) if isinstance(problem, Study) else plain


def places(problem: Problem, contacts: Contacts, vane: Part | None) -> Places:
    """Contacts of a case, on its vane if it has one."""
    if vane is not None:
        assert isinstance(problem, Study)
        return _places_on(problem, vane)
    joint, unknown = contacts.joints, np.full(contacts.count, np.nan)
    names = tuple(f"{name} {joint[: i + 1].count(name)}" for i, name in enumerate(joint))
    none = np.full(contacts.count, -1)
    return Places(names, joint, none, np.full((contacts.count, 3), np.nan), unknown, unknown)


def _places_on(study: Study, vane: Part) -> Places:
    """Contacts of a case on its vane."""
    areas = _areas(study, vane)
    sets = [*HOOKS, *(["interlock_right"] if study.joints.interlock else [])]
    names: list[str] = []
    joint: list[str] = []
    nodes, area, coefficient = [], [], []
    for name in sets:
        own = vane.node_sets[name]
        kept = np.ones(len(own), bool)
        if name in HOOKS:  # the key nodes are merged and carry no contact
            kept = ~np.isin(own, vane.node_sets.get("key", ()))
        count = int(kept.sum())
        kind = "hook" if name in HOOKS else "interlock"
        k = getattr(study.joints, kind).wear_coefficient
        names += [f"{WORDS[name]} {i + 1}" for i in range(count)]
        joint += [kind] * count
        nodes.append(own[kept])
        area.append(areas[name][kept])
        coefficient.append(np.full(count, np.nan if k is None else k))
    found, *known = map(np.concatenate, (nodes, area, coefficient))
    return Places(tuple(names), tuple(joint), found, vane.points[found], *known)


def _areas(study: Study, vane: Part) -> dict[str, Floats]:
    """Area of every node of the vane's contact sets, m²."""
    found = {
        name: vane.areas.get(name, np.full(len(own), np.nan))
        for name, own in vane.node_sets.items()
    }
    dimensions, casing = study.vane, study.casing
    if not isinstance(dimensions, VaneDimensions):
        return found
    if isinstance(casing, CasingDimensions):
        overlap = hook_overlap(dimensions, casing)
        bands = hook_patches(dimensions.hook, overlap, study.ring.sectors)
        for i, name in enumerate(HOOKS):
            both = [patch.area for band in bands[2 * i : 2 * i + 2] for patch in band]
            found[name] = np.array(both)
    right = interlock_patches(dimensions, study.ring.sectors)[1]
    found["interlock_right"] = np.array([patch.area for patch in right])
    return found


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
    positions: Floats = field(metadata={"unit": "m"})
    directions: Floats
    rows: Floats = field(metadata={"unit": "1/m"})

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
    harmonics: Complex

    @property
    def amplitude(self) -> Floats:
        """(p, g) half the peak-to-peak over a period."""
        return half_peak_to_peak(self.harmonics.swapaxes(0, 1))


def gauges_step(study: Study) -> Step[Gauges]:
    """The gauges of a study on its vane; costs a factorisation and a solve for each gauge."""
    wanted = study.outputs.gauges
    dimensions = study.vane
    assert isinstance(dimensions, VaneDimensions)  # else the study is refused before
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
            at = gauge.model_dump(exclude={"length"})
            place = mesh.on_aerofoil(dimensions, study.ring.sectors, **at)
            where = place.position, place.direction, gauge.length, place.normal
            try:
                placed.append(fem.gauge(part, *where, surface=surface))
            except InputError as error:
                raise InputError(f"outputs.gauges[{i}]: {error}") from None
        rows = recovery.rows(sp.vstack([each.row for each in placed]), 0)
        return Gauges(
            tuple(_name(gauge) for gauge in wanted),
            np.array([each.position for each in placed]),
            np.array([each.direction for each in placed]),
            np.ascontiguousarray(rows.real),
        )

    needs = (recovery_step(study, "vane"),)
    return step("gauges", "rom", inputs, Gauges, needs, compute)


def _name(gauge: GaugeKeys) -> str:
    """What tables and files call a gauge."""
    along = gauge.direction if isinstance(gauge.direction, str) else f"{gauge.direction:g} deg"
    return (
        f"aerofoil {gauge.aerofoil}, {gauge.side} side, span {gauge.span:g}, "
        f"chord {gauge.chord:g}, along {along}"
    )
