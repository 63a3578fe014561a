"""How many unknowns a mesh of given dimensions will have, and which sizes an error asks for.

The error of a part's mesh falls as a power of its degrees of freedom: about 0.6 in vanes and
casings, whose sharp edges limit it, whether elements are small everywhere or, by `stretch`, across
the casing's ring only. These meshes then start lower. Both parts' errors add up; the cheapest pair
of meshes has dE/dN equal in both.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vanelock.common.arguments import OfKind
from vanelock.common.errors import InputError
from vanelock.mesh.checks import check_resolved
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
from vanelock.mesh.generate.bosses import check_meshable
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


_RATE = 0.6  # power of the degrees of freedom with which a mesh's error falls
_STRETCH = 3  # of the casing, where it has no bosses
_GAIN = 0.55
"""Error of a casing stretched so, over that of one that is not, at as many degrees of freedom."""
_STEP = 1e-4  # sizes are rounded to multiples of this, m


@dataclass(frozen=True)
class Sizes(OfKind):
    """Element sizes of both parts, m; `stretch` of the casing's around the ring."""

    vane: float
    casing: float
    stretch: int = 1


@dataclass(frozen=True)
class Refinement:
    """Sizes that are expected to do.

    Attributes
    ----------
    sizes : Sizes
        Those of a part that is not to be meshed are what they were.
    dofs : float
        Degrees of freedom expected of both parts.
    error : float
        Relative error expected of the frequency; larger than wanted where no size that is allowed
        reaches that.
    """

    sizes: Sizes
    dofs: float
    error: float


def sizes_for(
    accuracy: float,
    errors: Mapping[str, float],
    now: Sizes,
    vane: VaneDimensions | None,
    casing: CasingDimensions | None,
    sectors: int = 16,
    hook: HookDimensions | None = None,
) -> Refinement:
    """Sizes of the cheapest meshes whose error is expected to be what is wanted.

    Parameters
    ----------
    accuracy : float
        Relative error of a frequency.
    errors : mapping of "vane" and "casing" to float
        What the part's mesh adds to the frequency now, relative: `fem.excess_stiffness` of the
        mode, over 2 ω² and the modal mass.
    now : Sizes
        Of the meshes for which that was found.
    vane, casing : dimensions or None
        Of the parts; None keeps a part as it is, such as a user's own mesh.
    sectors : int
        In the ring.
    hook : HookDimensions, optional
        Of the casing; the vane's unless given.

    Raises
    ------
    InputError
        If `accuracy` is not positive, or an error is negative.

    Examples
    --------
    >>> found = {"vane": 0.034, "casing": 0.012}
    >>> vane, casing = VaneDimensions(root_fillet=0), CasingDimensions()
    >>> chosen = sizes_for(0.03, found, Sizes(0.0115, 0.0125), vane, casing)
    >>> chosen.sizes.stretch, chosen.error < 0.03
    (3, True)
    """
    if not accuracy > 0 or min(errors.values()) < 0:
        raise InputError(
            f"wanted = {accuracy:g}, errors {dict(errors)}: must be > 0, and not negative"
        )
    hook = hook or (HookDimensions() if vane is None else vane.hook)
    stretch = now.stretch
    gain = 1.0
    if casing is not None and not casing.bosses and stretch == 1:
        stretch, gain = _STRETCH, _GAIN

    def of_vane(size: float) -> float:
        return 0.0 if vane is None else vane_dofs(vane, sectors, size)

    def of_casing(size: float, times: int = stretch) -> float:
        return 0.0 if casing is None else casing_dofs(casing, hook, sectors, size, times)

    grid = np.arange(round(SMALLEST / _STEP), round(LARGEST / _STEP) + 1) * _STEP
    tables = [
        _table(of_vane, of_vane(now.vane), errors["vane"], now.vane, grid),
        _table(
            of_casing, of_casing(now.casing, now.stretch), gain * errors["casing"], now.casing, grid
        ),
    ]
    (vane_sizes, vane_dof, vane_error), (casing_sizes, casing_dof, casing_error) = tables
    dofs = vane_dof[:, None] + casing_dof
    error = vane_error[:, None] + casing_error
    allowed = dofs <= MOST
    enough = allowed & (error <= accuracy)
    if enough.any():
        best = np.argmin(np.where(enough, dofs, np.inf))
    else:
        best = np.argmin(np.where(allowed, error, np.inf))
    i, j = np.unravel_index(int(best), dofs.shape)
    sizes = Sizes(float(vane_sizes[i]), float(casing_sizes[j]), stretch)
    return Refinement(sizes, float(dofs[i, j]), float(error[i, j]))


def _table(
    count: Callable[[float], float], dofs: float, error: float, size: float, grid: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sizes, dofs and expected errors; the part's own alone where it is not to be meshed."""
    if not dofs:
        return np.array([size]), np.zeros(1), np.array([error])
    found = np.array([count(s) for s in grid])
    return grid.round(6), found, error * (found / dofs) ** -_RATE
