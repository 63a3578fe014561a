"""Refuse dimensions that contradict one another, before anything is meshed.

The models of `dimensions` check themselves; what also depends on the number of sectors, or on
the other part, is checked here.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.mesh import aerofoil
from vanelock.mesh.bosses import check_bosses
from vanelock.mesh.dimensions import (
    CLEARANCE,
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
)
from vanelock.mesh.fillets import check_casing_fillet, check_clear_fillets, check_vane_fillet

FEWEST, MOST = 6, 360  # sectors of a ring
_USUAL = 16  # sectors

PROFILE = ("chord", "thickness", "edge_thickness", "camber", "stagger")
"""Dimensions that make an aerofoil's profile."""
_SHROUD = ("inner_shroud_inner_radius", "inner_shroud_outer_radius")


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
    _below("casing.groove_bottom", casing.groove_bottom, "vane.foot_front", vane.foot_front)
    _below("casing.groove_mouth", casing.groove_mouth, "vane.leg_front", vane.leg_front)
    _below(
        "vane.outer_shroud_outer_radius",
        vane.outer_shroud_outer_radius,
        "casing.rail_inner_radius",
        casing.rail_inner_radius,
    )
    check_clear_fillets(vane, casing)


def check_casing(casing: CasingDimensions, hook: HookDimensions, sectors: int) -> None:
    """Refuse a casing whose grooves do not hold the bands, or whose rails overlap."""
    check_sectors(sectors)
    radii = (
        ("casing.rail_inner_radius", casing.rail_inner_radius),
        ("vane.hook.lip_radius", hook.lip_radius),
        ("vane.hook.roof_radius", hook.roof_radius),
        ("casing.inner_radius", casing.inner_radius),
    )
    positions = (
        ("casing.groove_bottom", casing.groove_bottom),
        ("vane.hook.band_position", hook.band_position),
        ("casing.groove_mouth", casing.groove_mouth),
        ("vane.hook.mid_plane", hook.mid_plane),
    )
    ends = (
        ("2 vane.hook.mid_plane - casing.rail_front", 2 * hook.mid_plane - casing.rail_front),
        ("casing.length - casing.flange_thickness", casing.length - casing.flange_thickness),
    )
    for chain in (radii, positions, ends):
        for low, high in pairwise(chain):
            _below(*low, *high)
    check_casing_fillet(casing, hook)
    check_bosses(casing, sectors)


def check_vane(vane: VaneDimensions, sectors: int) -> None:
    """Refuse aerofoils that leave their shrouds.

    Each then lies between slanted planes that share the pitch out among the aerofoils, so that
    none touches its neighbour.
    """
    check_sectors(sectors)
    check_vane_fillet(vane)
    sides = aerofoil.profile(vane)
    across, axial = sides[..., 0].ravel(), sides[..., 1].ravel()
    half = np.abs(axial).max()
    for name in ("inner_shroud_front", "outer_shroud_front"):
        front = getattr(vane, name)
        clear = vane.hook.mid_plane - half
        if front > clear - CLEARANCE:
            raise InputError(
                f"{_entering(vane, None, PROFILE, name)}: the aerofoils' front, at {clear:g} m, "
                f"must lie at least {CLEARANCE:g} m behind the shroud's"
            )
    _check_interlock(vane, sectors, across, axial)
    _check_outer_shroud(vane, sectors, across)


def _check_interlock(
    vane: VaneDimensions,
    sectors: int,
    across: NDArray[np.float64],
    axial: NDArray[np.float64],
) -> None:
    """The outermost aerofoils must stay inside the slanted interlock planes."""
    slant = np.radians(vane.interlock_slant)
    rest = np.pi / sectors - aerofoil.angles(vane, sectors)[-1]
    along, _ = aerofoil.ends(vane)  # where the pitch is shortest
    normal, radial = np.cos(slant) * np.cos(rest), -np.cos(slant) * np.sin(rest)
    lean = np.sin(slant) * axial
    # Distance from the right-hand plane, in which the aerofoil's axis lies `rest` before it; the
    # left-hand plane is the mirror image.
    right = -(normal * across + radial * along - lean)
    left = -(-normal * across + radial * along + lean)
    room = float(min(right.min(), left.min()))
    if room < CLEARANCE:
        raise InputError(
            f"{_entering(vane, sectors, (*PROFILE, 'aerofoils', *_SHROUD), 'interlock_slant')}: "
            f"the outermost of {vane.aerofoils} aerofoils {_distance(room)} the interlock face: "
            f"at least {CLEARANCE * 1e3:g} mm is needed"
        )


def _check_outer_shroud(vane: VaneDimensions, sectors: int, across: NDArray[np.float64]) -> None:
    edge = vane.outer_shroud_extent * np.pi / sectors - aerofoil.angles(vane, sectors)[-1]
    extent = np.abs(across).max()
    room = float(vane.outer_shroud_inner_radius * np.sin(max(edge, 0.0)) - extent)
    names = (*PROFILE, "aerofoils", "outer_shroud_inner_radius")
    if room < CLEARANCE:
        raise InputError(
            f"{_entering(vane, sectors, names, 'outer_shroud_extent')}: the outermost of "
            f"{vane.aerofoils} aerofoils {_distance(room)} the shroud's end: at least "
            f"{CLEARANCE * 1e3:g} mm is needed"
        )


def _entering(vane: VaneDimensions, sectors: int | None, names: Sequence[str], last: str) -> str:
    """What a check depends on: of `names` those that differ from the defaults, and `last`."""
    usual = VaneDimensions()
    shown = []
    for name in (*names, last):
        field, value = VaneDimensions.model_fields[name], getattr(vane, name)
        if name == last or value != getattr(usual, name):
            unit = (field.description or "").partition(" [")[2].rstrip("]")
            shown.append(f"vane.{name} = {value:g} {unit}".rstrip())
    if sectors not in (None, _USUAL):
        shown.append(f"ring.sectors = {sectors}")
    return ", ".join(shown)


def _distance(room: float) -> str:
    if room < 0:
        return f"reaches {-room * 1e3:.2f} mm past"
    return f"stays only {room * 1e3:.2f} mm from"


def _below(low_name: str, low: float, high_name: str, high: float) -> None:
    if low > high - CLEARANCE:
        raise InputError(
            f"{low_name} = {low:g} m: must lie at least {CLEARANCE:g} m below "
            f"{high_name} = {high:g} m"
        )
