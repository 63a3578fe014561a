"""How many unknowns a mesh of given dimensions will have, and element sizes with too many."""

from collections.abc import Callable

import numpy as np

from vanelock.common.errors import InputError
from vanelock.mesh.checks import check_meshable, check_resolved
from vanelock.mesh.element_size import (
    HOOKS,
    LARGEST,
    SHROUD,
    SMALLEST,
    Size,
    checked_stretch,
    element_size,
    words_of,
)
from vanelock.mesh.generate.aerofoils import ROUND, arc_rows, divisions
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.geometry.root_fillet import filleted

MOST = 1_000_000
"""Degrees of freedom of both parts together; beyond, meshing takes minutes and memory runs out."""

_Plate = tuple[float, float]  # area of the mid-surface, m^2, and thickness, m

_CASING_LEAST, _CASING = 6180.0, (35.9, 13.8)  # by area and by volume
_VANE_LEAST, _VANE = 5670.0, (45.8, 17.7)  # with the finer elements at aerofoils and contacts
_A_CELL = 7.73  # nodes of an aerofoil on a cell of its faces, what lies beneath included


def casing_dofs(
    casing: CasingDimensions, hook: HookDimensions, sectors: int, size: float, stretch: int = 1
) -> float:
    """Estimate for a casing sector meshed with elements of `size`, m; fillets apart."""
    plates = _casing_plates(casing, hook, sectors * stretch)
    return _CASING_LEAST + _plates_dofs(plates, size, _CASING)


def vane_dofs(vane: VaneDimensions, sectors: int, size: float) -> float:
    """Estimate for a vane segment meshed with elements of `size`, m; fillets of hooks apart.

    Aerofoils and their fillets are counted by the rows and columns of their faces, half of the
    fillets' rows: they spare small elements beside them.
    """
    vane = filleted(vane, sectors)
    divided = divisions(vane, size)
    rows = divided.rows + (arc_rows(vane) if vane.root_fillet else 0)
    cells = vane.aerofoils * rows * 2 * (divided.columns + ROUND)
    shares = (1.0, SHROUD, HOOKS, HOOKS)
    plates = zip(_shroud_plates(vane, sectors), shares, strict=True)
    regions = (_plates_dofs([plate], share * size, _VANE) for plate, share in plates)
    return _VANE_LEAST + 3 * _A_CELL * cells + sum(regions)


def _plates_dofs(plates: list[_Plate], size: float, factors: tuple[float, float]) -> float:
    """Estimate for plates.

    Besides what contacts and corners need anyway, a plate thinner than an element has its nodes
    by area and a thicker one by volume. The constants are fitted to 30 meshes of casings and 21
    of vanes, with elements of 4 to 30 mm, thin and thick walls, 8 to 24 sectors, none missed by a
    quarter (casings) or a tenth (vanes).
    """
    area = sum(area for area, _ in plates)
    volume = sum(area * thickness for area, thickness in plates)
    return factors[0] * area / size**2 + factors[1] * volume / size**3


def check_size(
    size: Size,
    vane: VaneDimensions | None,
    casing: CasingDimensions | None,
    sectors: int,
    hook: HookDimensions | None = None,
    stretch: int | None = None,
) -> None:
    """Refuse elements so small that both meshes together would be too large, or too large.

    None stands for a part that is meshed already; `hook` then is the one that a casing shares.
    """
    if vane is not None:
        vane = filleted(vane, sectors)
        check_resolved("vane.fillet", vane.fillet, element_size(size, "vane"), HOOKS)
        check_resolved("vane.root_fillet", vane.root_fillet or 0.0, element_size(size, "vane"))
    if casing is not None:
        check_resolved("casing.fillet", casing.fillet, element_size(size, "casing"))
        check_meshable(casing, element_size(size, "casing"))
        stretch = checked_stretch(stretch, casing)
    hook, times = hook or (HookDimensions() if vane is None else vane.hook), stretch or 1

    def count(vane_size: float, casing_size: float) -> float:
        return (0 if vane is None else vane_dofs(vane, sectors, vane_size)) + (
            0 if casing is None else casing_dofs(casing, hook, sectors, casing_size, times)
        )

    estimate = count(element_size(size, "vane"), element_size(size, "casing"))
    if estimate <= MOST:
        return
    shown = f'"{size}"' if isinstance(size, str) else words_of(size)
    raise InputError(
        f"mesh.size = {shown}: about {float(f'{estimate:.2g}'):,.0f} degrees of freedom: at most "
        f"{MOST:,} are allowed{_advice(count)}"
    )


def _advice(count: Callable[[float, float], float]) -> str:
    """The smallest size allowed, in tenths of a millimetre."""
    for tenth in range(round(SMALLEST * 1e4), round(LARGEST * 1e4) + 1):
        if count(tenth * 1e-4, tenth * 1e-4) <= MOST:
            return f", that is sizes from {tenth / 10:g} mm here"
    return ", and no size reaches that: reduce the dimensions"


def _shroud_plates(vane: VaneDimensions, sectors: int) -> list[_Plate]:
    """The shrouds, legs and feet of a vane segment."""
    hook, pitch = vane.hook, 2 * np.pi / sectors
    long = pitch * vane.outer_shroud_extent
    inner, outer = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    return [
        (
            2 * (hook.mid_plane - vane.inner_shroud_front) * pitch * inner,
            inner - vane.inner_shroud_inner_radius,
        ),
        (
            2 * (hook.mid_plane - vane.outer_shroud_front) * long * outer,
            vane.outer_shroud_outer_radius - outer,
        ),
        (
            2 * (hook.roof_radius - vane.outer_shroud_outer_radius) * long * hook.lip_radius,
            vane.leg_rear - vane.leg_front,
        ),
        (
            2 * (vane.leg_front - vane.foot_front) * long * hook.roof_radius,
            hook.roof_radius - hook.lip_radius,
        ),
    ]


def _casing_plates(casing: CasingDimensions, hook: HookDimensions, sectors: int) -> list[_Plate]:
    """The shell, flanges and bosses of a casing sector, and its rails' walls, roofs and lips."""
    pitch = 2 * np.pi / sectors
    groove = casing.groove_mouth - casing.groove_bottom
    return [
        (
            casing.length * pitch * (casing.inner_radius + casing.outer_radius) / 2,
            casing.outer_radius - casing.inner_radius,
        ),
        (pitch * (casing.flange_radius**2 - casing.outer_radius**2), casing.flange_thickness),
        (
            2 * (casing.inner_radius - casing.rail_inner_radius) * pitch * casing.inner_radius,
            casing.groove_bottom - casing.rail_front,
        ),
        (2 * groove * pitch * casing.inner_radius, casing.inner_radius - hook.roof_radius),
        (2 * groove * pitch * hook.lip_radius, hook.lip_radius - casing.rail_inner_radius),
        (casing.bosses * np.pi * casing.boss_diameter**2 / 4, casing.boss_height),
    ]
