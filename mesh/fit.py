"""Refuse dimensions that contradict one another, before anything is meshed.

The models of `dimensions` check themselves; what also depends on the number of sectors, or on
the other part, is checked here.
"""

import numpy as np

from vanelock.errors import InputError
from vanelock.mesh import aerofoil
from vanelock.mesh.dimensions import CasingDimensions, HookDimensions, VaneDimensions

CLEARANCE = 5e-4  # m; thinner walls and gaps are beyond any mesh


def check_sectors(sectors: int) -> None:
    """Refuse a number of sectors that makes no ring."""
    if not 3 <= sectors <= 360:
        raise InputError(f"ring.sectors = {sectors}: must lie between 3 and 360")


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


def check_casing(casing: CasingDimensions, hook: HookDimensions, sectors: int) -> None:
    """Refuse a casing whose grooves do not hold the bands, or whose rails overlap."""
    check_sectors(sectors)
    prefix = "casing."
    _below(
        f"{prefix}rail_inner_radius", casing.rail_inner_radius, "hook.lip_radius", hook.lip_radius
    )
    _below("hook.roof_radius", hook.roof_radius, f"{prefix}inner_radius", casing.inner_radius)
    _below(f"{prefix}groove_bottom", casing.groove_bottom, "hook.band_position", hook.band_position)
    _below("hook.band_position", hook.band_position, f"{prefix}groove_mouth", casing.groove_mouth)
    _below(f"{prefix}groove_mouth", casing.groove_mouth, "hook.mid_plane", hook.mid_plane)
    _below(
        "rear rail's rear face",
        2 * hook.mid_plane - casing.rail_front,
        "rear flange's front face",
        casing.length - casing.flange_thickness,
    )


def check_vane(vane: VaneDimensions, sectors: int) -> None:
    """Refuse aerofoils that leave their shrouds or touch one another."""
    check_sectors(sectors)
    sides = aerofoil.profile(vane)
    across, axial = sides[..., 0].ravel(), sides[..., 1].ravel()
    half = np.abs(axial).max()
    for name in ("inner_shroud_front", "outer_shroud_front"):
        front = getattr(vane, name)
        _below(f"vane.{name}", front, "the aerofoils' front", vane.hook.mid_plane - half)
    _check_interlock(vane, sectors, across, axial)
    _check_outer_shroud(vane, sectors, across)
    _check_passage(vane, sectors)


def _check_interlock(
    vane: VaneDimensions,
    sectors: int,
    across: np.ndarray,
    axial: np.ndarray,
) -> None:
    """The outermost aerofoils must stay inside the slanted interlock planes."""
    slant = np.radians(vane.interlock_slant)
    rest = np.pi / sectors - aerofoil.angles(vane, sectors)[-1]
    radius = vane.inner_shroud_outer_radius
    normal, radial = np.cos(slant) * np.cos(rest), -np.cos(slant) * np.sin(rest)
    along = np.sqrt(radius**2 - across**2)
    lean = np.sin(slant) * axial
    # Distance from the right-hand plane, in which the aerofoil's axis lies `rest` before it; the
    # left-hand plane is the mirror image.
    right = -(normal * across + radial * along - lean)
    left = -(-normal * across + radial * along + lean)
    room = float(min(right.min(), left.min()))
    if room < CLEARANCE:
        raise InputError(
            f"vane.chord = {vane.chord:g} m: with {vane.aerofoils} aerofoils, stagger "
            f"{vane.stagger:g} deg and slant {vane.interlock_slant:g} deg an aerofoil comes "
            f"{room * 1e3:.2f} mm near the interlock face: at least "
            f"{CLEARANCE * 1e3:.1f} mm is needed"
        )


def _check_outer_shroud(vane: VaneDimensions, sectors: int, across: np.ndarray) -> None:
    edge = vane.outer_shroud_extent * np.pi / sectors - aerofoil.angles(vane, sectors)[-1]
    extent = np.abs(across).max()
    room = float(vane.outer_shroud_inner_radius * np.sin(max(edge, 0.0)) - extent)
    if room < CLEARANCE:
        raise InputError(
            f"vane.outer_shroud_extent = {vane.outer_shroud_extent:g}: the outermost aerofoil "
            f"comes {room * 1e3:.2f} mm near the shroud's end: at least "
            f"{CLEARANCE * 1e3:.1f} mm is needed"
        )


def _check_passage(vane: VaneDimensions, sectors: int) -> None:
    """Neighbouring aerofoils must leave a passage between them."""
    if vane.aerofoils == 1:
        return
    spacing = 2 * np.pi / sectors / vane.aerofoils * vane.inner_shroud_outer_radius
    convex, concave = aerofoil.profile(vane)
    low, high = concave[:, 1].min(), convex[:, 1].max()
    z = np.linspace(max(low, convex[:, 1].min()), min(high, concave[:, 1].max()), 201)
    gap = spacing - np.abs(
        np.interp(z, convex[:, 1], convex[:, 0]) - np.interp(z, concave[:, 1], concave[:, 0])
    )
    if gap.min() < 2 * CLEARANCE:
        raise InputError(
            f"vane.aerofoils = {vane.aerofoils}: neighbouring aerofoils leave "
            f"{gap.min() * 1e3:.2f} mm between them: at least {2e3 * CLEARANCE:.1f} mm is needed"
        )


def _below(low_name: str, low: float, high_name: str, high: float) -> None:
    if low > high - CLEARANCE:
        raise InputError(
            f"{low_name} = {low:g} m: must be less than {high_name} = {high:g} m "
            f"by at least {CLEARANCE:g} m"
        )
