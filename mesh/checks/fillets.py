"""Refuse fillets that do not fit, before anything is meshed."""

from vanelock.common.errors import InputError
from vanelock.mesh.geometry.dimensions import (
    CLEARANCE,
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
)

ASPECT, DRAWN_OUT = 10.0, 24.0
"""Elements along a fillet are at most so many times longer than its pieces are wide: as they are
meshed, and once they are drawn out around the ring."""

SIZE = 20.0
"""Elements may be so many radii of a fillet long: beyond, those beside it become slivers."""

Room = tuple[str, float]
"""What bounds a fillet, and the largest radius there, m."""


def check_casing_fillet(casing: CasingDimensions, hook: HookDimensions) -> None:
    """Refuse a fillet of the casing's rails that reaches another one, an edge or a contact band."""
    height = casing.inner_radius - hook.roof_radius
    between = 2 * (hook.mid_plane - casing.groove_mouth)
    _check(
        "casing.fillet",
        casing.fillet,
        ("between casing.groove_mouth and its mirror image", (between - CLEARANCE) / 2),
        ("between vane.hook.roof_radius and casing.inner_radius", height - CLEARANCE),
        (
            "between vane.hook.lip_radius and vane.hook.roof_radius",
            (hook.roof_radius - hook.lip_radius - CLEARANCE) / 2,
        ),
        (
            "between casing.groove_bottom and vane.hook.band_position",
            hook.band_position - casing.groove_bottom - CLEARANCE,
        ),
        (
            "between casing.rail_inner_radius and casing.inner_radius",
            casing.inner_radius - casing.rail_inner_radius - CLEARANCE,
        ),
        ("in front of casing.rail_front", casing.rail_front - CLEARANCE),
        (
            "behind the rear rail",
            casing.length - 2 * hook.mid_plane + casing.rail_front - CLEARANCE,
        ),
    )


def check_vane_fillet(vane: VaneDimensions) -> None:
    """Refuse a fillet of the vane's hooks that reaches another one, an edge or a contact band."""
    hook = vane.hook
    leg = hook.lip_radius - vane.outer_shroud_outer_radius
    between = 2 * (hook.mid_plane - vane.leg_rear)
    _check(
        "vane.fillet",
        vane.fillet,
        (
            "between vane.outer_shroud_outer_radius and vane.hook.lip_radius",
            (leg - CLEARANCE) / 2,
        ),
        ("between vane.leg_rear and its mirror image", (between - CLEARANCE) / 2),
        (
            "between vane.hook.band_position and vane.leg_front",
            vane.leg_front - hook.band_position - CLEARANCE,
        ),
        (
            "between vane.outer_shroud_front and vane.leg_front",
            vane.leg_front - vane.outer_shroud_front - CLEARANCE,
        ),
    )


def check_clear_fillets(vane: VaneDimensions, casing: CasingDimensions) -> None:
    """Refuse fillets that touch the other part: foot and groove meet on their faces alone."""
    _check(
        "casing.fillet",
        casing.fillet,
        (
            "between casing.groove_bottom and vane.foot_front",
            vane.foot_front - casing.groove_bottom - CLEARANCE,
        ),
    )
    _check(
        "vane.fillet",
        vane.fillet,
        (
            "between casing.groove_mouth and vane.leg_front",
            vane.leg_front - casing.groove_mouth - CLEARANCE,
        ),
    )


def check_resolved(name: str, fillet: float, size: float, share: float = 1.0) -> None:
    """Refuse a fillet too small for an element size, m, of which elements there are a share."""
    if 0 < fillet < share * size / SIZE:
        raise InputError(
            f"{name} = {fillet:g} m: too small for elements of {share * size * 1e3:g} mm: allowed "
            f"are 0, {share * size / SIZE:g} m and more, or mesh.size up to "
            f"{SIZE * fillet / share:g} m"
        )


def _check(name: str, fillet: float, *rooms: Room) -> None:
    where, largest = min(rooms, key=lambda room: room[1])
    if fillet > largest:
        least = f"at most {largest:g} m" if largest >= CLEARANCE else "none"
        raise InputError(f"{name} = {fillet:g} m: {where} {least} fits")
