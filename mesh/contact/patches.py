"""Contact patches: the pieces of the contact faces that belong to each contact node, by geometry.

A patch is cut out of its face by planes and does not depend on the mesh, so that the two faces of
a joint, meshed apart, share it. At the hooks it is the interval of angle nearest to its node, the
outermost ones reaching to the band's end, over the axial length in which foot and groove touch. At
the interlock it is half of the face's height times the length nearest to its node. There the face
is bounded by arcs of the ellipses in which its plane cuts the shroud's cylinders.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import turn
from vanelock.mesh.geometry import contact_places
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions


@dataclass(frozen=True)
class Patch:
    """A piece of a surface.

    Attributes
    ----------
    planes : (p, 4) float
        Unit normals n and offsets d, m: the patch is where n·x ≤ d for all of them.
    area : float
        m².
    centroid : (3,) float
        Of the curved surface, m; so it lies a little inside a cylinder.
    """

    planes: NDArray[np.float64]
    area: float
    centroid: NDArray[np.float64]

    def turned(self, rotation: NDArray[np.float64]) -> "Patch":
        """The patch turned about the origin."""
        planes = np.column_stack([self.planes[:, :3] @ rotation.T, self.planes[:, 3]])
        return Patch(planes, self.area, rotation @ self.centroid)


def hook_overlap(vane: VaneDimensions, casing: CasingDimensions) -> tuple[float, float]:
    """Axial range, m, in which both faces of the front foot lie on those of the groove.

    Fillets belong to neither face.
    """
    return (
        max(vane.foot_front, casing.groove_bottom + casing.fillet),
        min(vane.leg_front - vane.fillet, casing.groove_mouth),
    )


def hook_patches(
    hook: HookDimensions, overlap: tuple[float, float], sectors: int
) -> list[list[Patch]]:
    """Patches of the nodes of `contact_places.hook_bands`, band by band."""
    front_roof = contact_places.hook_bands(hook, sectors)[0]
    limits = _nearest(np.arctan2(front_roof[:, 1], front_roof[:, 0]))  # the same on all bands
    mirrored = (2 * hook.mid_plane - overlap[1], 2 * hook.mid_plane - overlap[0])
    return [
        [_on_cylinder(radius, angles, axial) for angles in pairwise(limits)]
        for axial in (overlap, mirrored)
        for radius in (hook.roof_radius, hook.lip_radius)
    ]


def _nearest(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ends and mid-points (k + 1,) of the intervals nearest to ascending positions (k,)."""
    middles = 0.5 * (positions[:-1] + positions[1:])
    return np.concatenate([positions[:1], middles, positions[-1:]])


def _on_cylinder(radius: float, angles: tuple[float, float], axial: tuple[float, float]) -> Patch:
    (first, last), (front, rear) = angles, axial
    planes = np.array(
        [
            [np.sin(first), -np.cos(first), 0.0, 0.0],  # half-planes from the axis outwards
            [-np.sin(last), np.cos(last), 0.0, 0.0],
            [0.0, 0.0, -1.0, -front],
            [0.0, 0.0, 1.0, rear],
        ]
    )
    half, middle = 0.5 * (last - first), 0.5 * (first + last)
    inside = radius * np.sin(half) / half
    centroid = [inside * np.cos(middle), inside * np.sin(middle), 0.5 * (front + rear)]
    return Patch(planes, radius * (last - first) * (rear - front), np.array(centroid))


def interlock_patches(vane: VaneDimensions, sectors: int) -> tuple[list[Patch], list[Patch]]:
    """Patches of the nodes of the left interlock face, in their order, and of the right one."""
    frame = contact_places.interlock_frame(vane, sectors)
    origin = np.array([0.0, 0.0, vane.hook.mid_plane])
    positions = (contact_places.interlock_rows(vane, sectors)[0] - origin) @ frame[
        2
    ]  # the same on both
    slope = np.sin(np.radians(vane.interlock_slant))
    radii = (vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius)
    local = [
        _beside_arc(ends, radius, sum(radii) - radius, slope)
        for radius in radii
        for ends in pairwise(_nearest(positions))
    ]
    left = []
    for sides, area, centre in local:
        normals = sides[:, :2] @ frame[[2, 1]]
        planes = np.column_stack([normals, sides[:, 2] + normals @ origin])
        left.append(Patch(planes, area, origin + centre @ frame[[2, 1]]))
    return left, [patch.turned(turn(sectors)) for patch in left]


def _beside_arc(
    ends: tuple[float, float], radius: float, opposite: float, slope: float
) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Piece of an interlock face from one of its arcs to the line at half height.

    In coordinates of the face, across it and radial, the arcs are y² + (slope x)² = radius². The
    line is straight and meets the mean of both arcs at the ends in x.
    """

    def arc(r: float, at: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.sqrt(r**2 - (slope * at) ** 2)

    start, end = ends
    low, high = 0.5 * (arc(radius, np.array(ends)) + arc(opposite, np.array(ends)))
    points, weights = np.polynomial.legendre.leggauss(20)
    x = start + (end - start) * 0.5 * (1 + points)
    y = np.stack([arc(radius, x), low + (high - low) * 0.5 * (1 + points)])
    share = 0.5 * (end - start) * weights * np.abs(y[1] - y[0])
    area = float(share.sum())
    upwards = np.array([low - high, end - start]) / np.hypot(high - low, end - start)
    towards_arc = np.sign(radius - opposite) * upwards
    corner = np.array([start, low])
    sides = np.array([[-1.0, 0.0, -start], [1.0, 0.0, end], [*-towards_arc, -towards_arc @ corner]])
    return sides, area, np.array([share @ x, share @ y.mean(axis=0)]) / area
