"""Strut bosses: cylinders that stand radially on the outside of the casing's shell."""

from typing import Any

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.mesh.generate import occ_solids
from vanelock.mesh.geometry import contact_places
from vanelock.mesh.geometry.dimensions import CLEARANCE, CasingDimensions

_SIDES = 8  # fewest elements around a boss

_FLAT, _NARROW = 20.0, 5.0
"""Elements may be so many times longer than a boss is high, and than it is wide."""


def boss_angles(casing: CasingDimensions, sectors: int) -> Floats:
    """Where the bosses stand, evenly over the whole ring: (b,) rad."""
    count = casing.bosses
    return np.asarray(np.pi / sectors * ((2 * np.arange(count) + 1) / max(count, 1) - 1))


def check_bosses(casing: CasingDimensions, sectors: int) -> None:
    """Refuse bosses that reach a flange, a cyclic face, each other, or a force or output node."""
    if not casing.bosses:
        return
    radius, at = casing.boss_diameter / 2, casing.boss_position
    room = radius + CLEARANCE
    flange = casing.flange_thickness
    widest = casing.length - 2 * (flange + CLEARANCE)
    if 2 * radius > widest:
        raise InputError(
            f"casing.boss_diameter = {2 * radius:g} m: at most {_floor(widest):g} m fits between "
            "the flanges"
        )
    if not flange + room <= at <= casing.length - flange - room:
        raise InputError(
            f"casing.boss_position = {at:g} m: a boss of {2 * radius:g} m clears the flanges "
            f"between {flange + room:g} m and {casing.length - flange - room:g} m"
        )
    # Bosses draw apart outwards: they are nearest to each other, and to the faces between two of
    # them, where their sides stand on the shell.
    half = np.pi / (sectors * casing.bosses)
    foot = np.sqrt(max(casing.outer_radius**2 - radius**2, 0.0))
    if foot * np.sin(half) < room:
        raise InputError(
            f"casing.boss_diameter = {2 * radius:g} m: {casing.bosses} bosses in one of {sectors} "
            "sectors touch each other or the cyclic faces: at most "
            f"{_floor(2 * (casing.inner_radius * np.sin(half) - CLEARANCE)):g} m fits"
        )
    if foot < casing.inner_radius + CLEARANCE:
        wall = casing.outer_radius**2 - (casing.inner_radius + CLEARANCE) ** 2
        raise InputError(
            f"casing.boss_diameter = {2 * radius:g} m: the shell is too thin for it: at most "
            f"{_floor(2 * np.sqrt(max(wall, 0.0))):g} m fits"
        )
    angle = boss_angles(casing, sectors)
    axes = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    for what, nodes in (
        ("a force node", contact_places.force_points(casing, sectors)),
        ("an output node", contact_places.casing_output_points(casing, sectors)),
    ):
        from_foot = nodes - [0.0, 0.0, at]
        off = np.linalg.norm(np.cross(from_foot[:, None], axes), axis=-1)
        if off.min() < room:
            raise InputError(
                f"casing.boss_position = {at:g} m: a boss of {2 * radius:g} m covers {what}: it "
                f"must stay {room:g} m away from {nodes[0, 2]:g} m"
            )


def check_meshable(casing: CasingDimensions, size: float) -> None:
    """Refuse bosses too flat or too narrow for an element size, m."""
    if not casing.bosses:
        return
    for name, ratio in (("boss_height", _FLAT), ("boss_diameter", _NARROW)):
        value = getattr(casing, name)
        if value < size / ratio:
            raise InputError(
                f"casing.{name} = {value:g} m: too small for elements of {size * 1e3:g} mm: "
                f"at least {size / ratio:g} m, or mesh.size up to {ratio * value:g} m"
            )


def add_bosses(
    gmsh: Any, casing: CasingDimensions, sectors: int, shell: occ_solids.Entity
) -> occ_solids.Entity:
    """The shell with its bosses; each begins within the wall, so that no faces coincide."""
    if not casing.bosses:
        return shell
    kernel, radius = gmsh.model.occ, casing.boss_diameter / 2
    start = 0.5 * (casing.inner_radius + np.sqrt(casing.outer_radius**2 - radius**2))
    deep = casing.outer_radius + casing.boss_height - start
    cylinders = []
    for angle in boss_angles(casing, sectors):
        c, s = np.cos(angle), np.sin(angle)
        at = (start * c, start * s, casing.boss_position)
        cylinders.append((3, kernel.addCylinder(*at, deep * c, deep * s, 0.0, radius)))
    fused, _ = kernel.fuse([shell], cylinders)
    if len(fused) != 1:
        raise InputError(f"casing: shell and bosses make {len(fused)} bodies instead of one")
    entity: occ_solids.Entity = fused[0]
    return entity


def divide_bosses(gmsh: Any, casing: CasingDimensions, size: float) -> None:
    """Divide the bosses' round edges evenly, in no fewer than `_SIDES` elements."""
    if not casing.bosses:
        return
    for _, edge in gmsh.model.getEntities(1):
        ends = gmsh.model.getBoundary([(1, edge)], combined=True)
        if not ends:  # closed: no other edge of the casing is
            length = gmsh.model.occ.getMass(1, edge)
            intervals = max(_SIDES, int(np.ceil(length / size)))
            gmsh.model.mesh.setTransfiniteCurve(edge, intervals + 1)


def _floor(length: float) -> float:
    """A length in whole tenths of a millimetre, so that what is printed does fit."""
    return float(max(0.0, np.floor(length * 1e4) / 1e4))
