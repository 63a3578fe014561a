"""Where the contacts of a case are, what they are called, and the area that belongs to each.

The program's own parts know areas by geometry, whether contacts act on them or on nodes: those of
`mesh.patches`, which tile the contact faces. A user's mesh knows them where its contact sets
consist of whole faces.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.input.cases.values import Given
from vanelock.input.schema.study import Study
from vanelock.mesh import CasingDimensions, Part, VaneDimensions
from vanelock.mesh.contact_patches import hook_overlap, hook_patches, interlock_patches
from vanelock.rom import Contacts

Floats = NDArray[np.float64]

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
    nodes: NDArray[np.int64]
    points: Floats
    area: Floats
    coefficient: Floats


def tangents(given: Given, joint: str) -> tuple[str, str]:
    """What the two friction directions of a joint's contacts are called."""
    plain = ("tangent 1", "tangent 2")
    return TANGENTS.get(joint, plain) if isinstance(given, Study) else plain


def places(given: Given, contacts: Contacts, vane: Part | None) -> Places:
    """Contacts of a case, on its vane if it has one."""
    if vane is not None:
        assert isinstance(given, Study)
        return places_on(given, vane)
    joint, unknown = contacts.joints, np.full(contacts.count, np.nan)
    names = tuple(f"{name} {joint[: i + 1].count(name)}" for i, name in enumerate(joint))
    none = np.full(contacts.count, -1)
    return Places(names, joint, none, np.full((contacts.count, 3), np.nan), unknown, unknown)


def places_on(study: Study, vane: Part) -> Places:
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
    found = np.concatenate(nodes)
    return Places(
        tuple(names),
        tuple(joint),
        found,
        vane.points[found],
        np.concatenate(area),
        np.concatenate(coefficient),
    )


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
