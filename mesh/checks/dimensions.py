"""Refuse dimensions that contradict one another, before anything is meshed.

The models of `dimensions` check themselves; what also depends on the number of sectors, or on
the other part, is checked here.
"""

from collections.abc import Sequence
from itertools import pairwise

from vanelock.common.errors import InputError
from vanelock.mesh.checks.aerofoils import check_aerofoils
from vanelock.mesh.checks.fillets import check_casing_fillet, check_clear_fillets, check_vane_fillet
from vanelock.mesh.checks.root_fillets import check_root_fillet
from vanelock.mesh.generate.bosses import check_bosses
from vanelock.mesh.geometry.dimensions import (
    CLEARANCE,
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
)

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
    _ordered(
        (("casing.groove_bottom", casing.groove_bottom), ("vane.foot_front", vane.foot_front)),
        (("casing.groove_mouth", casing.groove_mouth), ("vane.leg_front", vane.leg_front)),
        (
            ("vane.outer_shroud_outer_radius", vane.outer_shroud_outer_radius),
            ("casing.rail_inner_radius", casing.rail_inner_radius),
        ),
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
    _ordered(radii, positions, ends)
    check_casing_fillet(casing, hook)
    check_bosses(casing, sectors)


def check_vane(vane: VaneDimensions, sectors: int) -> None:
    """Refuse aerofoils that leave their shrouds or meet each other, and their fillets."""
    check_sectors(sectors)
    check_vane_fillet(vane)
    check_aerofoils(vane, sectors)
    check_root_fillet(vane, sectors)


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
