"""Where the nodes of the named sets lie, and the contact frames there, in closed form.

The sector spans the angles -π/N to π/N. Elements are straight-sided, so a node between two
corner nodes lies on their chord.
"""

import numpy as np
from numpy.typing import NDArray

from vanelock.cyclic import rotation, turn
from vanelock.mesh.dimensions import CasingDimensions, HookDimensions, VaneDimensions

HOOK_CORNERS = 8  # corner nodes of a hook's band; with those between them, 15
INTERLOCK_CORNERS = 3  # of a row on an interlock face; with those between them, 5
FORCES = 16


def cylindrical(
    radius: float, angle: NDArray[np.float64], z: float | NDArray[np.float64]
) -> NDArray[np.float64]:
    """Cartesian points (k, 3) of a radius, angles (k,) and axial positions."""
    return np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), np.broadcast_to(z, np.shape(angle))],
        axis=-1,
    )


def with_chords(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Put the middle of each chord between its corners: (k, 3) to (2k - 1, 3)."""
    nodes = np.empty((2 * len(corners) - 1, 3))
    nodes[::2] = corners
    nodes[1::2] = 0.5 * (corners[:-1] + corners[1:])
    return nodes


def hook_bands(hook: HookDimensions, sectors: int) -> NDArray[np.float64]:
    """Nodes of the four contact bands, each by ascending angle.

    Returns
    -------
    (4, 15, 3) float
        Front roof, front lip, rear roof, rear lip, m.
    """
    half = hook.band_extent * np.pi / sectors
    angle = np.linspace(-half, half, HOOK_CORNERS)
    rear = 2 * hook.mid_plane - hook.band_position
    return np.array(
        [
            with_chords(cylindrical(radius, angle, z))
            for z in (hook.band_position, rear)
            for radius in (hook.roof_radius, hook.lip_radius)
        ]
    )


def hook_frames(bands: NDArray[np.float64], outward: float) -> NDArray[np.float64]:
    """Contact frames at the nodes of `hook_bands`.

    Rows are the outward normal ±e_r, e_θ, and ±e_z with the normal's sign: right-handed, and a
    part's frame is its mate's with the normal and the second tangent reversed.

    Parameters
    ----------
    bands : (4, 15, 3) float
        Nodes.
    outward : float
        +1 for the vane, whose normal at the roof is +e_r; -1 for the casing.

    Returns
    -------
    (4, 15, 3, 3) float
    """
    angle = np.arctan2(bands[..., 1], bands[..., 0])
    sign = outward * np.array([1.0, -1.0, 1.0, -1.0])[:, None]  # roof, lip, roof, lip
    zero = np.zeros_like(angle)
    normal = np.stack([sign * np.cos(angle), sign * np.sin(angle), zero], axis=-1)
    around = np.stack([-np.sin(angle), np.cos(angle), zero], axis=-1)
    axial = np.stack([zero, zero, sign + zero], axis=-1)
    return np.stack([normal, around, axial], axis=-2)


def interlock_frame(vane: VaneDimensions, sectors: int) -> NDArray[np.float64]:
    """Frame of the left interlock face, a plane, the same at each of its nodes.

    Rows are the outward normal sin γ·e_z - cos γ·e_θ, the radial direction e_r, and the direction
    across the face sin γ·e_θ + cos γ·e_z; e_r and e_θ are those of the angle -π/N.

    Returns
    -------
    (3, 3) float
    """
    slant = np.radians(vane.interlock_slant)
    c, s = np.cos(slant), np.sin(slant)
    local = np.array([[0.0, -c, s], [1.0, 0.0, 0.0], [0.0, s, c]])
    return local @ rotation(-np.pi / sectors).T


def opposite(frames: NDArray[np.float64], sectors: int) -> NDArray[np.float64]:
    """Frames (..., 3, 3) of the face that meets this one in the next sector, in this sector.

    The normal and the second tangent are reversed and all is turned by 2π/N.
    """
    reversed_ = np.array([-1.0, 1.0, -1.0])[:, None] * frames
    return np.asarray(reversed_ @ turn(sectors).T)


def interlock_rows(vane: VaneDimensions, sectors: int) -> NDArray[np.float64]:
    """Nodes of the left interlock face, on its two long edges, each by ascending z.

    Returns
    -------
    (2, 5, 3) float
        The row at the inner radius, then the one at the outer radius, m.
    """
    slant = np.radians(vane.interlock_slant)
    mid = vane.hook.mid_plane
    axial = np.linspace(vane.inner_shroud_front - mid, mid - vane.inner_shroud_front, 3)
    rows = []
    for radius in (vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius):
        # A point a of the plane's own axial direction further on lies a·sin γ off the radius.
        across = axial * np.tan(slant)
        corners = np.stack([np.sqrt(radius**2 - across**2), across, mid + axial], axis=-1)
        rows.append(with_chords(corners @ rotation(-np.pi / sectors).T))
    return np.array(rows)


def force_points(casing: CasingDimensions, sectors: int) -> NDArray[np.float64]:
    """Loaded nodes, evenly around the ring on the shell's outside at mid-length: (16, 3) m."""
    angle = np.pi / sectors * ((2 * np.arange(FORCES) + 1) / FORCES - 1)
    return cylindrical(casing.outer_radius, angle, 0.5 * casing.length)


def casing_accessory_points(casing: CasingDimensions, sectors: int) -> NDArray[np.float64]:
    """Output nodes on the shell's outside above the front rail: (3, 3) m.

    The first lies in the middle of the sector, the others a quarter of the pitch to either side.
    """
    angle = np.pi / sectors * np.array([0.0, -0.5, 0.5])
    return cylindrical(casing.outer_radius, angle, 0.5 * (casing.rail_front + casing.groove_mouth))
