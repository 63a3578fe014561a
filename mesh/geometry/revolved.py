"""Outlines of the revolved bodies: polygons in the plane of radius and z, with fillets."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions

_Place = Floats  # (2,): radius and axial position, m

PIECE = np.pi / 4
"""The largest angle of a piece of an arc: every quarter of a circle has two elements or more."""


class Corner(NamedTuple):
    """A corner of an outline, rounded by an arc that is tangent to both sides."""

    radius: float  # where the sides meet, m
    z: float
    fillet: float = 0.0  # radius of the arc, m; 0 leaves the corner sharp


class _Edge(NamedTuple):
    """A straight edge, or an arc about a centre."""

    start: _Place  # (2,), Radius and axial position, m
    end: _Place  # (2,), Radius and axial position, m
    centre: _Place | None = None  # (2,), Of an arc


def edges(corners: Sequence[Corner]) -> list[_Edge]:
    """Edges around an outline, each starting where the one before it ends."""
    rounded = [
        _arc(before, corner, after)
        for before, corner, after in zip(
            [corners[-1], *corners[:-1]], corners, [*corners[1:], corners[0]], strict=True
        )
    ]
    found = []
    for arc, following in zip(rounded, [*rounded[1:], rounded[0]], strict=True):
        found += arc
        found.append(_Edge(arc[-1].end, following[0].start))
    # The sharp corner's edge has no length.
    return [edge for edge in found if edge.start is not edge.end]


def _arc(before: Corner, corner: Corner, after: Corner) -> list[_Edge]:
    """The pieces of a corner's arc, or for a sharp corner one edge without length."""
    here = np.array(corner[:2], dtype=float)
    if corner.fillet == 0:
        return [_Edge(here, here)]
    to = np.array([before[:2], after[:2]]) - here
    to /= np.linalg.norm(to, axis=1)[:, None]
    half = np.arccos(np.clip(to[0] @ to[1], -1, 1)) / 2  # of the angle between the sides
    inwards = to.sum(axis=0) / np.linalg.norm(to.sum(axis=0))
    centre = here + corner.fillet / np.sin(half) * inwards
    first, last = here + corner.fillet / np.tan(half) * to
    turn = np.pi - 2 * half
    pieces = max(1, int(np.ceil(turn / PIECE - 1e-9)))
    from_middle = turn * (np.arange(1, pieces) / pieces - 0.5)
    along = (last - first) / np.linalg.norm(last - first)
    between = [
        centre + corner.fillet * (np.sin(a) * along - np.cos(a) * inwards) for a in from_middle
    ]
    places = [first, *between, last]
    return [_Edge(*ends, centre) for ends in pairwise(places)]


def casing_outline(casing: CasingDimensions, hook: HookDimensions) -> list[Corner]:
    """Around the section: along the outside, then back along the inside."""
    outside = [
        Corner(casing.flange_radius, 0.0),
        Corner(casing.flange_radius, casing.flange_thickness),
        Corner(casing.outer_radius, casing.flange_thickness),
        Corner(casing.outer_radius, casing.length - casing.flange_thickness),
        Corner(casing.flange_radius, casing.length - casing.flange_thickness),
        Corner(casing.flange_radius, casing.length),
    ]
    front = [
        Corner(casing.inner_radius, casing.rail_front, casing.fillet),
        Corner(casing.rail_inner_radius, casing.rail_front),
        Corner(casing.rail_inner_radius, casing.groove_mouth),
        Corner(hook.lip_radius, casing.groove_mouth),
        Corner(hook.lip_radius, casing.groove_bottom, casing.fillet),
        Corner(hook.roof_radius, casing.groove_bottom, casing.fillet),
        Corner(hook.roof_radius, casing.groove_mouth),
        Corner(casing.inner_radius, casing.groove_mouth, casing.fillet),
    ]
    rear = [corner._replace(z=2 * hook.mid_plane - corner.z) for corner in front]
    ends = [Corner(casing.inner_radius, casing.length), Corner(casing.inner_radius, 0.0)]
    return [*outside, ends[0], *rear, *reversed(front), ends[1]]


def hooks_outline(vane: VaneDimensions) -> list[Corner]:
    """Around the section of the outer shroud with both hooks, beginning at the front hook."""
    hook = vane.hook
    front = [
        Corner(vane.outer_shroud_outer_radius, vane.leg_rear, vane.fillet),
        Corner(hook.roof_radius, vane.leg_rear),
        Corner(hook.roof_radius, vane.foot_front),
        Corner(hook.lip_radius, vane.foot_front),
        Corner(hook.lip_radius, vane.leg_front, vane.fillet),
        Corner(vane.outer_shroud_outer_radius, vane.leg_front, vane.fillet),
        Corner(vane.outer_shroud_outer_radius, vane.outer_shroud_front),
        Corner(vane.outer_shroud_inner_radius, vane.outer_shroud_front),
    ]
    rear = [corner._replace(z=2 * hook.mid_plane - corner.z) for corner in reversed(front)]
    return front + rear


def inner_shroud_outline(vane: VaneDimensions) -> list[Corner]:
    """Around the section of the inner shroud."""
    inner, outer = vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius
    front = vane.inner_shroud_front
    rear = 2 * vane.hook.mid_plane - front
    return [Corner(inner, front), Corner(inner, rear), Corner(outer, rear), Corner(outer, front)]
