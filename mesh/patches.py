"""Contact patches: the pieces of the contact faces that belong to each contact node, by geometry.

A patch is cut out of its face by planes and does not depend on the mesh, so that the two faces of
a joint, meshed apart, share it. At the hooks it is the interval of angle nearest to its node, the
outermost ones reaching to the band's end, over the axial length in which foot and groove touch. At
the interlock it is half of the face's height times the length nearest to its node.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vanelock.cyclic import turn
from vanelock.mesh import sets
from vanelock.mesh.dimensions import CasingDimensions, HookDimensions, VaneDimensions


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
    """Axial range, m, in which both faces of the front foot lie on those of the groove."""
    return (
        max(vane.foot_front, casing.groove_bottom),
        min(vane.leg_front, casing.groove_mouth),
    )


def hook_patches(
    hook: HookDimensions, overlap: tuple[float, float], sectors: int
) -> list[list[Patch]]:
    """Patches of the nodes of `sets.hook_bands`, band by band.

    Parameters
    ----------
    hook : HookDimensions
        The bands.
    overlap : (front, rear) float
        Axial range in which the front hook's faces touch, m; see `hook_overlap`.
    sectors : int
        N.
    """
    half = hook.band_extent * np.pi / sectors
    limits = _nearest(np.linspace(-half, half, 2 * sets.HOOK_CORNERS - 1))
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
    """Patches of the nodes of the left interlock face, in their order, and of the right one.

    The face is bounded by the chords between the corner nodes of its long edges, which every mesh
    has.
    """
    rows = sets.interlock_rows(vane, sectors)
    radial, across = sets.interlock_frame(vane, sectors)[1:]
    origin = np.array([0.0, 0.0, vane.hook.mid_plane])
    edges = np.stack([(rows - origin) @ across, (rows - origin) @ radial], axis=-1)
    along = edges[0, :, 0]  # the same on both
    limits = _nearest(along)
    half = np.interp(limits, along, edges[:, :, 1].mean(axis=0))
    left = []
    for edge, sign in zip(edges, (1.0, -1.0), strict=True):
        for start, end in pairwise(np.column_stack([limits, half])):
            passed = edge[(along > start[0]) & (along < end[0])]
            first, last = ([a, np.interp(a, *edge.T)] for a in (start[0], end[0]))
            area, centre = _polygon(np.vstack([first, passed, last, end, start]))
            upwards = np.array([start[1] - end[1], end[0] - start[0]])
            upwards *= sign / np.linalg.norm(upwards)
            sides = np.array([[-1.0, 0.0, -start[0]], [1.0, 0.0, end[0]]])
            sides = np.vstack([sides, [*upwards, upwards @ start]])
            normals = sides[:, :2] @ np.array([across, radial])
            planes = np.column_stack([normals, sides[:, 2] + normals @ origin])
            left.append(Patch(planes, area, origin + centre @ np.array([across, radial])))
    return left, [patch.turned(turn(sectors)) for patch in left]


def _polygon(corners: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """Area and centroid of a plane polygon with corners (k, 2), either way round."""
    origin = corners[0]
    x, y = (corners - origin).T
    twice = x * np.roll(y, -1) - np.roll(x, -1) * y
    total = twice.sum()
    middle = np.array([(twice * (v + np.roll(v, -1))).sum() for v in (x, y)]) / (3 * total)
    return abs(total) / 2, origin + middle
