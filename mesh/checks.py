"""Refuse dimensions that contradict one another and fillets that do not fit, before meshing.

The models of `dimensions` check themselves; what also depends on the number of sectors, or on
the other part, is checked here.

Aerofoils must not leave their shrouds or meet one another. Along the straight lines that rule an
aerofoil its distance from a plane changes evenly, so that the ends of the piece between two radii
decide.
"""

from collections.abc import Sequence
from itertools import pairwise
from operator import attrgetter
from types import SimpleNamespace

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh.geometry import aerofoil, contact_places
from vanelock.mesh.geometry.dimensions import (
    CLEARANCE,
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
)
from vanelock.mesh.geometry.root_fillet import check_root_fillet

_USUAL = 16  # sectors
_PROFILE = ("chord", "thickness", "edge_thickness", "camber", "stagger", "twist", "lean")
_ROOT = ("inner_shroud_inner_radius", "inner_shroud_outer_radius")
_TIP = ("outer_shroud_inner_radius", "outer_shroud_outer_radius")


def _check_aerofoils(vane: VaneDimensions, sectors: int) -> None:
    """Refuse aerofoils that leave their shrouds or meet one another."""
    start, end = aerofoil.ends(vane)
    root, tip = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    if vane.chord < 2 * vane.thickness:
        raise InputError(
            f"vane.chord = {vane.chord:g} m: must be at least twice "
            f"vane.thickness = {vane.thickness:g} m"
        )
    _check_fronts(vane, "inner_shroud_front", (start, root))
    _check_fronts(vane, "outer_shroud_front", (tip, end))
    outermost = f"the outermost of {vane.aerofoils} aerofoils"
    for room, names, last, what, where in (
        (_beside_interlock(vane, sectors, (start, root)), _ROOT, "interlock_slant", outermost,
         "the interlock face"),
        (_beside_ends(vane, sectors, (tip, end)), _TIP, "outer_shroud_extent", outermost,
         "the shroud's end"),
        (_between(vane, sectors, (root, 0.5 * (root + tip), tip)), (*_ROOT, *_TIP), "chord",
         "an aerofoil", "the next"),
    ):  # fmt: skip
        if room < CLEARANCE:
            past = f"reaches {-room * 1e3:.2f} mm past"
            how = past if room < 0 else f"stays only {room * 1e3:.2f} mm from"
            given = _entering(vane, sectors, (*_PROFILE, "aerofoils", *names), last)
            raise InputError(
                f"{given}: {what} {how} {where}: at least {CLEARANCE * 1e3:g} mm is needed"
            )


def _check_fronts(vane: VaneDimensions, name: str, cuts: Sequence[float]) -> None:
    half = max(float(np.abs(aerofoil.around(vane, cut)[:, 1]).max()) for cut in cuts)
    clear = vane.hook.mid_plane - half
    if getattr(vane, name) > clear - CLEARANCE:
        raise InputError(
            f"{_entering(vane, None, _PROFILE, name)}: the aerofoils' front, at {clear:g} m, "
            f"must lie at least {CLEARANCE:g} m behind the shroud's"
        )


def _beside_interlock(vane: VaneDimensions, sectors: int, cuts: Sequence[float]) -> float:
    """Between the outermost aerofoils and the slanted interlock planes, m."""
    left = contact_places.interlock_frame(vane, sectors)
    normals = np.stack([left[0], contact_places.opposite(left, sectors)[0]])
    outermost = aerofoil.angles(vane, sectors)[[0, -1]]
    return min(
        float(-(_standing(vane, cut, angle) @ normal).max())
        for cut in cuts
        for angle, normal in zip(outermost, normals, strict=True)
    )


def _beside_ends(vane: VaneDimensions, sectors: int, cuts: Sequence[float]) -> float:
    """Between the outermost aerofoils and the ends of the outer shroud, m."""
    half = vane.outer_shroud_extent * np.pi / sectors
    room = np.inf
    for cut in cuts:
        for angle in aerofoil.angles(vane, sectors)[[0, -1]]:
            x, y, _ = _standing(vane, cut, angle).T
            beyond = np.abs(np.arctan2(y, x)) - half
            room = min(room, float(-(np.hypot(x, y) * np.sin(beyond)).max()))
    return room


def _between(vane: VaneDimensions, sectors: int, cuts: Sequence[float]) -> float:
    """Between neighbouring aerofoils, m."""
    step = 2 * np.pi / (sectors * vane.aerofoils)
    return min(_gap(aerofoil.around(vane, cut, 24), cut * step) for cut in cuts)


def _gap(section: Floats, step: float) -> float:
    """Distance of a closed curve (k, 2) from the same one, shifted by `step` along the first axis.

    Negative where they cross: how much further apart they would have to be.
    """
    axial = section[:, 1]
    start, stop = section, np.roll(section, -1, axis=0)
    # Width along the first axis at the height of every corner.
    low, high = np.minimum(start[:, 1], stop[:, 1]), np.maximum(start[:, 1], stop[:, 1])
    crossed = (low <= axial[:, None]) & (axial[:, None] <= high) & (high > low)
    share = (axial[:, None] - start[:, 1]) / np.where(high > low, stop[:, 1] - start[:, 1], 1.0)
    place = start[:, 0] + share * (stop[:, 0] - start[:, 0])
    largest = np.where(crossed, place, -np.inf).max(axis=1)
    smallest = np.where(crossed, place, np.inf).min(axis=1)
    wide = float(np.max(largest - smallest, initial=0.0, where=np.isfinite(largest)))
    if wide >= step:
        return step - wide
    edge = stop - start
    to = section[:, None] + [step, 0.0] - start
    at = np.clip((to * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    return float(np.linalg.norm(to - at[..., None] * edge, axis=-1).min())


def _standing(vane: VaneDimensions, along: float, angle: float) -> Floats:
    """The section around the aerofoil at an angle: (k, 3) m, axially from mid-plane."""
    section = aerofoil.around(vane, along, 24)
    points = np.column_stack([np.full(len(section), along), section])
    return np.asarray(points @ rotation(angle).T)


def _entering(vane: VaneDimensions, sectors: int | None, names: Sequence[str], last: str) -> str:
    """What a check depends on: of `names` those that differ from the defaults, and `last`."""
    usual = VaneDimensions()
    shown = []
    for name in dict.fromkeys((*names, last)):
        field, value = VaneDimensions.model_fields[name], getattr(vane, name)
        if name == last or value != getattr(usual, name):
            unit = (field.description or "").partition(" [")[2].rstrip("]")
            shown.append(f"vane.{name} = {value:g} {unit}".rstrip())
    if sectors not in (None, _USUAL):
        shown.append(f"ring.sectors = {sectors}")
    return ", ".join(shown)


FEWEST, MOST = 6, 360  # sectors of a ring


def check_sectors(sectors: int) -> None:
    """Refuse a number of sectors that makes no ring."""
    if not FEWEST <= sectors <= MOST:
        raise InputError(f"ring.sectors = {sectors}: must lie between {FEWEST} and {MOST}")


def check_fit(vane: VaneDimensions, casing: CasingDimensions, sectors: int) -> None:
    """Refuse a vane and a casing that cannot be assembled.

    Raises
    ------
    InputError
        Naming the dimension, what was given and what it must respect.
    """
    check_vane(vane, sectors)
    check_casing(casing, vane.hook, sectors)
    check_clearances(vane, casing)


def check_clearances(vane: VaneDimensions, casing: CasingDimensions) -> None:
    """Refuse a vane and a casing that touch beside the hooks' bands, a line for each place."""
    both = SimpleNamespace(vane=vane, casing=casing)
    _ordered(
        _lengths(both, "casing.groove_bottom", "vane.foot_front"),
        _lengths(both, "casing.groove_mouth", "vane.leg_front"),
        _lengths(both, "vane.outer_shroud_outer_radius", "casing.rail_inner_radius"),
    )
    # Fillets must not touch the other part: foot and groove meet on their faces alone.
    room = _room(both, "casing.groove_bottom", "vane.foot_front")
    _check_fillet("casing.fillet", casing.fillet, room)
    _check_fillet("vane.fillet", vane.fillet, _room(both, "casing.groove_mouth", "vane.leg_front"))


def _check_bosses(casing: CasingDimensions, sectors: int) -> None:
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
    angle = contact_places.boss_angles(casing, sectors)
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


def _floor(length: float) -> float:
    """A length in whole tenths of a millimetre, so that what is printed does fit."""
    return float(max(0.0, np.floor(length * 1e4) / 1e4))


_FLAT, _NARROW = 20.0, 5.0
"""Elements may be so many times longer than a boss is high, and than it is wide."""


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


def check_casing(casing: CasingDimensions, hook: HookDimensions, sectors: int) -> None:
    """Refuse a casing whose grooves do not hold the bands, or whose rails overlap."""
    check_sectors(sectors)
    both = SimpleNamespace(casing=casing, vane=SimpleNamespace(hook=hook))
    radii = ("casing.rail_inner_radius", "vane.hook.lip_radius", "vane.hook.roof_radius")
    positions = ("casing.groove_bottom", "vane.hook.band_position", "casing.groove_mouth")
    rear = 2 * hook.mid_plane - casing.rail_front
    _ordered(
        _lengths(both, *radii, "casing.inner_radius"),
        _lengths(both, *positions, "vane.hook.mid_plane"),
        [
            ("2 vane.hook.mid_plane - casing.rail_front", rear),
            ("casing.length - casing.flange_thickness", casing.length - casing.flange_thickness),
        ],
    )
    between = 2 * (hook.mid_plane - casing.groove_mouth)
    _check_fillet(
        "casing.fillet",
        casing.fillet,
        ("between casing.groove_mouth and its mirror image", (between - CLEARANCE) / 2),
        _room(both, "vane.hook.roof_radius", "casing.inner_radius"),
        _room(both, "vane.hook.lip_radius", "vane.hook.roof_radius", 2),
        _room(both, "casing.groove_bottom", "vane.hook.band_position"),
        _room(both, "casing.rail_inner_radius", "casing.inner_radius"),
        ("in front of casing.rail_front", casing.rail_front - CLEARANCE),
        ("behind the rear rail", casing.length - rear - CLEARANCE),
    )
    _check_bosses(casing, sectors)


def check_vane(vane: VaneDimensions, sectors: int) -> None:
    """Refuse aerofoils that leave their shrouds or meet each other, and their fillets."""
    check_sectors(sectors)
    both = SimpleNamespace(vane=vane)
    between = 2 * (vane.hook.mid_plane - vane.leg_rear)
    _check_fillet(
        "vane.fillet",
        vane.fillet,
        _room(both, "vane.outer_shroud_outer_radius", "vane.hook.lip_radius", 2),
        ("between vane.leg_rear and its mirror image", (between - CLEARANCE) / 2),
        _room(both, "vane.hook.band_position", "vane.leg_front"),
        _room(both, "vane.outer_shroud_front", "vane.leg_front"),
    )
    _check_aerofoils(vane, sectors)
    check_root_fillet(vane, sectors)


def _lengths(parts: SimpleNamespace, *names: str) -> list[tuple[str, float]]:
    """Dimensions of parts with their dotted names."""
    return [(name, attrgetter(name)(parts)) for name in names]


def _ordered(*chains: Sequence[tuple[str, float]]) -> None:
    """Refuse named lengths that do not ascend by a clearance, a line for each pair."""
    wrong = [
        f"{low_name} = {low:g} m: must lie at least {CLEARANCE:g} m below {high_name} = {high:g} m"
        for chain in chains
        for (low_name, low), (high_name, high) in pairwise(chain)
        if low > high - CLEARANCE
    ]
    if wrong:
        raise InputError("\n".join(wrong))


_SIZE = 20.0
"""Elements may be so many radii of a fillet long: beyond, those beside it become slivers."""

_Room = tuple[str, float]  # what bounds a fillet, and the largest radius there, m


def _room(parts: SimpleNamespace, low: str, high: str, fillets: int = 1) -> _Room:
    """The largest radius of so many fillets between two dimensions."""
    (_, start), (_, end) = _lengths(parts, low, high)
    return f"between {low} and {high}", (end - start - CLEARANCE) / fillets


def check_resolved(name: str, fillet: float, size: float, share: float = 1.0) -> None:
    """Refuse a fillet too small for an element size, m, of which elements there are a share."""
    if 0 < fillet < share * size / _SIZE:
        raise InputError(
            f"{name} = {fillet:g} m: too small for elements of {share * size * 1e3:g} mm: allowed "
            f"are 0, {share * size / _SIZE:g} m and more, or mesh.size up to "
            f"{_SIZE * fillet / share:g} m"
        )


def _check_fillet(name: str, fillet: float, *rooms: _Room) -> None:
    """Refuse a fillet that reaches another one, an edge, a contact band or the other part."""
    where, largest = min(rooms, key=lambda room: room[1])
    if fillet > largest:
        least = f"at most {largest:g} m" if largest >= CLEARANCE else "none"
        raise InputError(f"{name} = {fillet:g} m: {where} {least} fits")
