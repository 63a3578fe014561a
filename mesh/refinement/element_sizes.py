"""Which element sizes are expected to bring the error of a frequency down to what is wanted.

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
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.geometry.element_size import LARGEST, SMALLEST
from vanelock.mesh.refinement.dof_estimate import MOST, casing_dofs, vane_dofs

RATE = 0.6
"""Power of the degrees of freedom with which a mesh's error falls."""
STRETCH = 3
"""Of the casing, where it has no bosses."""
GAIN = 0.55
"""Error of a casing stretched so, over that of one that is not, at as many degrees of freedom."""
STEP = 1e-4
"""Sizes are rounded to multiples of this, m."""


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
    wanted: float,
    found: Mapping[str, float],
    now: Sizes,
    vane: VaneDimensions | None,
    casing: CasingDimensions | None,
    sectors: int = 16,
    hook: HookDimensions | None = None,
) -> Refinement:
    """Sizes of the cheapest meshes whose error is expected to be what is wanted.

    Parameters
    ----------
    wanted : float
        Relative error of a frequency.
    found : mapping of "vane" and "casing" to float
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
        If `wanted` is not positive, or an error is negative.

    Examples
    --------
    >>> found = {"vane": 0.034, "casing": 0.012}
    >>> vane, casing = VaneDimensions(root_fillet=0), CasingDimensions()
    >>> chosen = sizes_for(0.03, found, Sizes(0.0115, 0.0125), vane, casing)
    >>> chosen.sizes.stretch, chosen.error < 0.03
    (3, True)
    """
    if not wanted > 0 or min(found.values()) < 0:
        raise InputError(
            f"wanted = {wanted:g}, errors {dict(found)}: must be > 0, and not negative"
        )
    hook = hook or (HookDimensions() if vane is None else vane.hook)
    stretch = now.stretch
    gain = 1.0
    if casing is not None and not casing.bosses and stretch == 1:
        stretch, gain = STRETCH, GAIN

    def of_vane(size: float) -> float:
        return 0.0 if vane is None else vane_dofs(vane, sectors, size)

    def of_casing(size: float, times: int = stretch) -> float:
        return 0.0 if casing is None else casing_dofs(casing, hook, sectors, size, times)

    grid = np.arange(round(SMALLEST / STEP), round(LARGEST / STEP) + 1) * STEP
    tables = [
        _table(of_vane, of_vane(now.vane), found["vane"], now.vane, grid),
        _table(
            of_casing, of_casing(now.casing, now.stretch), gain * found["casing"], now.casing, grid
        ),
    ]
    (vane_sizes, vane_dof, vane_error), (casing_sizes, casing_dof, casing_error) = tables
    dofs = vane_dof[:, None] + casing_dof
    error = vane_error[:, None] + casing_error
    allowed = dofs <= MOST
    enough = allowed & (error <= wanted)
    if enough.any():
        best = np.argmin(np.where(enough, dofs, np.inf))
    else:
        best = np.argmin(np.where(allowed, error, np.inf))
    i, j = np.unravel_index(int(best), dofs.shape)
    sizes = Sizes(float(vane_sizes[i]), float(casing_sizes[j]), stretch)
    return Refinement(sizes, float(dofs[i, j]), float(error[i, j]))


def _table(
    count: Callable[[float], float],
    dofs: float,
    error: float,
    size: float,
    grid: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sizes, dofs and expected errors; the part's own alone where it is not to be meshed."""
    if not dofs:
        return np.array([size]), np.zeros(1), np.array([error])
    found = np.array([count(s) for s in grid])
    return grid.round(6), found, error * (found / dofs) ** -RATE
