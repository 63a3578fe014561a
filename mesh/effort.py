"""How many degrees of freedom a mesh will have, told from dimensions before anything is meshed."""

import numpy as np

from vanelock.errors import InputError
from vanelock.mesh.bosses import check_meshable
from vanelock.mesh.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.fillets import check_resolved
from vanelock.mesh.size import LARGEST, SMALLEST, element_size

MOST = 1_000_000
"""Degrees of freedom of both parts together; beyond, meshing takes minutes and memory runs out."""

Plate = tuple[float, float]
"""Area of the mid-surface, m^2, and thickness, m."""

_LEAST, _SHEET, _BULK = 6180.0, 35.9, 13.8


def degrees_of_freedom(plates: list[Plate], size: float) -> float:
    """Estimate for a part made of plates, meshed with elements of `size`, m.

    Besides what contacts and corners need anyway, a plate thinner than an element has its nodes
    by area and a thicker one by volume. The constants are fitted to 30 meshes of both parts, with
    elements of 4 to 25 mm, thin and thick walls, 8 to 24 sectors; none is missed by a fifth.
    """
    area = sum(area for area, _ in plates)
    volume = sum(area * thickness for area, thickness in plates)
    return _LEAST + _SHEET * area / size**2 + _BULK * volume / size**3


def check_size(
    size: str | float,
    vane: VaneDimensions | None,
    casing: CasingDimensions | None,
    sectors: int,
    hook: HookDimensions | None = None,
) -> None:
    """Refuse elements so small that both meshes together would be too large, or too large.

    None stands for a part that is meshed already; `hook` then is the one that a casing shares.

    Raises
    ------
    InputError
        Naming `mesh.size`, the estimate and about the smallest size allowed; or a fillet or boss
        that is too small for the elements.
    """
    if vane is not None:
        check_resolved("vane", vane.fillet, element_size(size, "vane"))
    if casing is not None:
        check_resolved("casing", casing.fillet, element_size(size, "casing"))
        check_meshable(casing, element_size(size, "casing"))
    hook = hook or (HookDimensions() if vane is None else vane.hook)
    parts = {
        **({} if vane is None else {"vane": vane_plates(vane, sectors)}),
        **({} if casing is None else {"casing": casing_plates(casing, hook, sectors)}),
    }
    count = sum(degrees_of_freedom(p, element_size(size, name)) for name, p in parts.items())
    if count <= MOST:
        return
    shown = f'"{size}"' if isinstance(size, str) else f"{size:g} m"
    raise InputError(
        f"mesh.size = {shown}: about {float(f'{count:.2g}'):,.0f} degrees of freedom: at most "
        f"{MOST:,} are allowed{_advice([p for plates in parts.values() for p in plates])}"
    )


def _advice(plates: list[Plate]) -> str:
    """The smallest size allowed, in tenths of a millimetre; both parts' least nodes count."""
    for tenth in range(round(SMALLEST * 1e4), round(LARGEST * 1e4) + 1):
        if degrees_of_freedom(plates, tenth * 1e-4) + _LEAST <= MOST:
            return f", that is sizes from {tenth / 10:g} mm here"
    return ", and no size reaches that: reduce the dimensions"


def vane_plates(vane: VaneDimensions, sectors: int) -> list[Plate]:
    """The shrouds, aerofoils, legs and feet of a vane segment."""
    hook, pitch = vane.hook, 2 * np.pi / sectors
    long = pitch * vane.outer_shroud_extent
    inner, outer = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    mean = (2 * vane.thickness + vane.edge_thickness) / 3
    return [
        (
            2 * (hook.mid_plane - vane.inner_shroud_front) * pitch * inner,
            inner - vane.inner_shroud_inner_radius,
        ),
        (
            2 * (hook.mid_plane - vane.outer_shroud_front) * long * outer,
            vane.outer_shroud_outer_radius - outer,
        ),
        (vane.aerofoils * vane.chord * (outer - inner), mean),
        (
            2 * (hook.roof_radius - vane.outer_shroud_outer_radius) * long * hook.lip_radius,
            vane.leg_rear - vane.leg_front,
        ),
        (
            2 * (vane.leg_front - vane.foot_front) * long * hook.roof_radius,
            hook.roof_radius - hook.lip_radius,
        ),
    ]


def casing_plates(casing: CasingDimensions, hook: HookDimensions, sectors: int) -> list[Plate]:
    """The shell, flanges and bosses of a casing sector, and its rails' walls, roofs and lips."""
    pitch = 2 * np.pi / sectors
    groove = casing.groove_mouth - casing.groove_bottom
    return [
        (
            casing.length * pitch * (casing.inner_radius + casing.outer_radius) / 2,
            casing.outer_radius - casing.inner_radius,
        ),
        (
            pitch * (casing.flange_radius**2 - casing.outer_radius**2),
            casing.flange_thickness,
        ),
        (
            2 * (casing.inner_radius - casing.rail_inner_radius) * pitch * casing.inner_radius,
            casing.groove_bottom - casing.rail_front,
        ),
        (2 * groove * pitch * casing.inner_radius, casing.inner_radius - hook.roof_radius),
        (2 * groove * pitch * hook.lip_radius, hook.lip_radius - casing.rail_inner_radius),
        (casing.bosses * np.pi * casing.boss_diameter**2 / 4, casing.boss_height),
    ]
