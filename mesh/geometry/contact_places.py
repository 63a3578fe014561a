"""Where the nodes of the named sets lie, and the contact frames there, in closed form.

The sector spans the angles -π/N to π/N. Contact nodes lie evenly along their curves, every one of
them or every second, third, ... node of the mesh there.
"""

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.cyclic import rotation, turn
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions

_STRETCH = 1.2  # how much longer than other elements those along a row of contact nodes may be


def pieces(length: float, nodes: int, size: float) -> int:
    """Mesh nodes from one contact node to the next along a curve, so that its elements fit.

    An element has a node in its middle, so that two contact nodes' distances make one element, or
    two, three, ...
    """
    return max(1, int(np.ceil(2 * length / (nodes - 1) / (_STRETCH * size) - 1e-9)))


def _cylindrical(radius: float, angle: Floats, z: float | Floats) -> Floats:
    """Cartesian points (k, 3) of a radius, angles (k,) and axial positions."""
    return np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), np.broadcast_to(z, np.shape(angle))],
        axis=-1,
    )


def band_pieces(hook: HookDimensions, sectors: int, size: float) -> int:
    """Mesh nodes from one contact node of a hook's band to the next, see `pieces`."""
    length = hook.band_extent * 2 * np.pi / sectors * hook.roof_radius
    return pieces(length, hook.band_nodes, size)


def hook_bands(hook: HookDimensions, sectors: int, pieces: int = 1) -> Floats:
    """Nodes of the four contact bands, each by ascending angle."""
    half = hook.band_extent * np.pi / sectors
    angle = np.linspace(-half, half, (hook.band_nodes - 1) * pieces + 1)
    rear = 2 * hook.mid_plane - hook.band_position
    return np.array(
        [
            _cylindrical(radius, angle, z)
            for z in (hook.band_position, rear)
            for radius in (hook.roof_radius, hook.lip_radius)
        ]
    )


def hook_frames(bands: Floats, outward: float) -> Floats:
    """Contact frames at the nodes of `hook_bands`.

    Rows are the outward normal ±e_r, e_θ, and ±e_z with the normal's sign: right-handed, and a
    part's frame is its mate's with the normal and the second tangent reversed.
    """
    angle = np.arctan2(bands[..., 1], bands[..., 0])
    sign = outward * np.array([1.0, -1.0, 1.0, -1.0])[:, None]  # roof, lip, roof, lip
    zero = np.zeros_like(angle)
    normal = np.stack([sign * np.cos(angle), sign * np.sin(angle), zero], axis=-1)
    around = np.stack([-np.sin(angle), np.cos(angle), zero], axis=-1)
    axial = np.stack([zero, zero, sign + zero], axis=-1)
    return np.stack([normal, around, axial], axis=-2)


def interlock_frame(vane: VaneDimensions, sectors: int) -> Floats:
    """Frame of the left interlock face, a plane, the same at each of its nodes.

    Rows are the outward normal sin γ·e_z - cos γ·e_θ, the radial direction e_r, and the direction
    across the face sin γ·e_θ + cos γ·e_z; e_r and e_θ are those of the angle -π/N.
    """
    slant = np.radians(vane.interlock_slant)
    c, s = np.cos(slant), np.sin(slant)
    local = np.array([[0.0, -c, s], [1.0, 0.0, 0.0], [0.0, s, c]])
    return local @ rotation(-np.pi / sectors).T


def opposite(frames: Floats, sectors: int) -> Floats:
    """Frames (..., 3, 3) of the face that meets this one in the next sector, in this sector.

    The normal and the second tangent are reversed and all is turned by 2π/N.
    """
    reversed_ = np.array([-1.0, 1.0, -1.0])[:, None] * frames
    return np.asarray(reversed_ @ turn(sectors).T)


def interlock_rows(vane: VaneDimensions, sectors: int, pieces: int = 1) -> Floats:
    """Nodes of the left interlock face, on its two long edges, each by ascending z."""
    mid = vane.hook.mid_plane
    half = mid - vane.inner_shroud_front
    axial = np.linspace(-half, half, (vane.interlock_nodes - 1) * pieces + 1)
    return np.array(
        [
            _interlock_edge(vane, sectors, radius, axial)
            for radius in (vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius)
        ]
    )


def _interlock_edge(vane: VaneDimensions, sectors: int, radius: float, axial: Floats) -> Floats:
    """Points (k, 3) where the left interlock plane cuts a cylinder, at heights from mid-plane."""
    # The plane holds the radial direction of its angle, and leans across by the slant.
    across = axial * np.tan(np.radians(vane.interlock_slant))
    local = [np.sqrt(radius**2 - across**2), across, vane.hook.mid_plane + axial]
    return np.asarray(np.stack(local, axis=-1) @ rotation(-np.pi / sectors).T)


def force_points(casing: CasingDimensions, sectors: int) -> Floats:
    """Loaded nodes, evenly around the ring on the shell's outside at mid-length: (k, 3) m."""
    count = casing.force_nodes
    angle = np.pi / sectors * ((2 * np.arange(count) + 1) / count - 1)
    return _cylindrical(casing.outer_radius, angle, 0.5 * casing.length)


def boss_angles(casing: CasingDimensions, sectors: int) -> Floats:
    """Where the bosses stand, evenly over the whole ring: (b,) rad."""
    count = casing.bosses
    return np.asarray(np.pi / sectors * ((2 * np.arange(count) + 1) / max(count, 1) - 1))


def casing_output_points(casing: CasingDimensions, sectors: int) -> Floats:
    """Output nodes on the shell's outside above the front rail: (3, 3) m.

    The first lies in the middle of the sector, the others a quarter of the pitch to either side.
    """
    angle = np.pi / sectors * np.array([0.0, -0.5, 0.5])
    return _cylindrical(casing.outer_radius, angle, 0.5 * (casing.rail_front + casing.groove_mouth))
