"""Places of a part in words, and sharp re-entrant corners, where stress does not converge.

Sharp re-entrant corners of a part: where linear elasticity has no stress to converge to.

At a re-entrant edge without a fillet the stress grows as r^(λ-1), λ < 1, towards the edge (M. L.
Williams, Stress singularities resulting from various boundary conditions in angular corners of
plates in extension, J. Appl. Mech. 19 (1952) 526-528), so that the value at its nodes only reflects
the mesh; so does that at a node which carries a contact's force. Such places need a fillet in the
model, or the stress some way off, as hot-spot rules for welds take it at 0.4 of the wall's
thickness and beyond (A. F. Hobbacher, Recommendations for Fatigue Design of Welded Joints and
Components, IIW, Springer 2016, section 2.2.3).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.cyclic import rotation
from vanelock.input.schema.study import Study
from vanelock.mesh import CasingDimensions, HookDimensions, Part, VaneDimensions
from vanelock.mesh.geometry.aerofoil import angles, around, ends, outline
from vanelock.render.scenes.surface import BEND, skin_edges, surface

_READ_OUT = 0.4
"""Of the wall's thickness, the least distance from a corner at which a stress is read."""


def _reentrant_edges(part: Part) -> Floats:
    """Ends (k, 2, 3) of the skin's edges that are sharp and re-entrant, m.

    An edge is sharp where the skin turns by more than a meshed fillet does in one step. Edges of
    the sector's left and right faces are none: the part goes on there.
    """
    skin = surface(part)
    points, triangles = part.points[skin.nodes], skin.triangles[~skin.cyclic]
    edges, mates, cosine = skin_edges(points, triangles)
    sharp = (mates[:, 0] >= 0) & (cosine < np.cos(np.radians(BEND)))
    edges, (one, other) = edges[sharp], mates[sharp].T
    a, b, c = (points[triangles[one, i]] for i in range(3))
    towards = points[triangles[other]].mean(axis=1) - points[edges[:, 0]]
    inwards = np.einsum("ij,ij->i", towards, np.cross(b - a, c - a)) > 0
    return np.asarray(points[edges[inwards]])


def _within(points: Floats, edges: Floats, distance: float) -> Booleans:
    """(n,) points that lie within a distance of line segments (k, 2, 3), m."""
    if not len(edges):
        return np.zeros(len(points), bool)
    a, along = edges[:, 0], edges[:, 1] - edges[:, 0]
    longest = float(np.linalg.norm(along, axis=1).max())
    reach = distance + longest / 2
    near = cKDTree(edges.mean(axis=1)).query_ball_point(points, reach)
    found = np.zeros(len(points), bool)
    squared = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    for i, chosen in enumerate(near):
        if not chosen:
            continue
        to = points[i] - a[chosen]
        t = (np.einsum("ij,ij->i", to, along[chosen]) / squared[chosen]).clip(0, 1)
        gap = np.linalg.norm(to - t[:, None] * along[chosen], axis=1).min()
        found[i] = gap <= distance
    return found


_CONTACTS = ("hook_front", "hook_rear", "interlock_left", "interlock_right", "key", "force")
_ON = 1e-5
"""Nodes lie on a cylinder within this, m."""


@dataclass(frozen=True)
class SurfaceLocations:
    """What is known of the places of a part's nodes.

    Attributes
    ----------
    part : Part
    dimensions : VaneDimensions, CasingDimensions or None
        None for a user's own mesh.
    hook : HookDimensions
        What vane and casing share.
    feature : (n,) str
        "aerofoil 2", "inner shroud", ...; "vane" or "casing" where no dimensions say.
    corner : (n,) bool
        On or beside a sharp re-entrant corner.
    loaded : (n,) bool
        On or beside a node that carries the force of a contact, a tie or the excitation.
    distance : float
        How far "beside" reaches, m.
    """

    part: Part
    dimensions: VaneDimensions | CasingDimensions | None
    hook: HookDimensions
    feature: NDArray[np.str_]
    corner: Booleans
    loaded: Booleans
    distance: float

    @property
    def clear(self) -> Booleans:
        """(n,) nodes whose stress means something."""
        return ~(self.corner | self.loaded)

    def coordinates(self, node: int) -> tuple[float, float, float]:
        """Radius, m, angle from the sector's middle, degrees, and axial position, m."""
        x, y, z = self.part.points[node]
        return float(np.hypot(x, y)), float(np.degrees(np.arctan2(y, x))), float(z)

    def words(self, node: int) -> str:
        """Where a node is: feature and place on it."""
        feature = str(self.feature[node])
        if isinstance(self.dimensions, VaneDimensions):
            if feature.startswith("aerofoil"):
                return _on_the_aerofoil(self.dimensions, self.part, node, feature)
            if feature.endswith("leg"):
                return feature + self._on_the_leg(self.dimensions, node)
        return feature

    def _on_the_leg(self, vane: VaneDimensions, node: int) -> str:
        radius = self.coordinates(node)[0]
        near = 0.5 * (vane.leg_rear - vane.leg_front)
        if radius - vane.outer_shroud_outer_radius < near:
            return ", at the outer shroud"
        return ", at the foot" if vane.hook.lip_radius - radius < near else ""

    def doubt(self, node: int) -> str:
        """Why the stress of a node has no limit as the mesh is refined; "" where it has one."""
        if self.corner[node]:
            return "at a sharp re-entrant corner"
        return "beside a node that carries a point force" if self.loaded[node] else ""


def locations_of(study: Study, part: Part) -> SurfaceLocations:
    """Places of the nodes of a study's vane or casing."""
    dimensions = getattr(study, part.name)
    if not isinstance(dimensions, VaneDimensions | CasingDimensions):
        dimensions = None
    edges = _reentrant_edges(part)
    if isinstance(dimensions, VaneDimensions):
        feature = _of_vane(dimensions, part, _within(part.points, edges, _ON))
        wall = min(dimensions.thickness, dimensions.leg_rear - dimensions.leg_front)
    elif isinstance(dimensions, CasingDimensions):
        feature = _of_casing(dimensions, study.vane.hook, part)
        wall = dimensions.outer_radius - dimensions.inner_radius
    else:
        feature = np.full(len(part.points), part.name)
        corners = part.points[part.cells[:, :4]]
        wall = float(np.median(np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1)))
    distance = _READ_OUT * wall
    corner = _within(part.points, edges, distance)
    held = [part.node_sets[name] for name in _CONTACTS if name in part.node_sets]
    chosen = part.points[np.unique(np.concatenate([np.empty(0, np.int64), *held]))]
    loaded = np.zeros(len(part.points), bool)
    if len(chosen):
        loaded = cKDTree(chosen).query(part.points)[0] <= distance
    return SurfaceLocations(part, dimensions, study.vane.hook, feature, corner, loaded, distance)


def _of_vane(vane: VaneDimensions, part: Part, sharp: Booleans) -> NDArray[np.str_]:
    """Features of the vane's nodes; those on a re-entrant edge belong to what stands on it."""
    x, y, z = part.points.T
    radius, front = np.hypot(x, y), z < vane.hook.mid_plane
    inner, outer = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    names = np.full(len(z), "outer shroud", dtype="U32")
    names[radius <= inner + _ON] = "inner shroud"
    base = vane.outer_shroud_outer_radius
    leg = (radius > base + _ON) | sharp & (radius > base - _ON)
    foot = radius >= vane.hook.lip_radius - _ON
    names[leg & front], names[leg & ~front] = "front hook, leg", "rear hook, leg"
    names[foot & front], names[foot & ~front] = "front hook, foot", "rear hook, foot"
    on = (radius > inner + _ON) & (radius < outer - _ON)
    on |= sharp & (radius > inner - _ON) & (radius < outer + _ON)
    samples, number = _aerofoils(vane, part.sectors)
    nearest = cKDTree(samples).query(part.points[on])[1]
    names[on] = [f"aerofoil {k + 1}" for k in number[nearest]]
    return names


def _aerofoils(vane: VaneDimensions, sectors: int) -> tuple[Floats, Integers]:
    """Points on the aerofoils' outlines at many radii, m, and the number of each point's."""
    found, number = [], []
    low, high = ends(vane)
    for k, angle in enumerate(angles(vane, sectors)):
        turn = rotation(angle)
        for along in np.linspace(low, high, 33):
            outline = np.asarray(around(vane, along))
            section = np.column_stack([np.full(len(outline), along), outline])
            section[:, 2] += vane.hook.mid_plane
            found.append(section @ turn.T)
            number += [k] * len(outline)
    return np.concatenate(found), np.array(number)


def _of_casing(casing: CasingDimensions, hook: HookDimensions, part: Part) -> NDArray[np.str_]:
    x, y, z = part.points.T
    radius, front = np.hypot(x, y), z < hook.mid_plane
    names = np.full(len(z), "shell", dtype="U32")
    rail = radius < casing.inner_radius - _ON
    names[rail & front], names[rail & ~front] = "front rail", "rear rail"
    flange = (z <= casing.flange_thickness + _ON) | (
        z >= casing.length - casing.flange_thickness - _ON
    )
    names[flange & ~rail] = "end flange"
    boss = (radius > casing.outer_radius + _ON) & ~flange
    names[boss] = "strut boss"
    return names


def _on_the_aerofoil(vane: VaneDimensions, part: Part, node: int, name: str) -> str:
    """Side, chord and span of a node of an aerofoil, in words."""
    axis = angles(vane, part.sectors)[int(name.split()[1]) - 1]
    local = part.points[node] @ rotation(axis)  # in the frame of the aerofoil's sections
    radius = float(np.hypot(*part.points[node][:2]))
    inner, outer = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    span = float(np.clip((radius - inner) / (outer - inner), 0, 1))
    station = np.linspace(-1, 1, 201)
    sides = outline(vane, station, float(local[0]))
    gap = np.linalg.norm(sides - (local[1:] - [0.0, vane.hook.mid_plane]), axis=2)
    number, place = np.unravel_index(int(gap.argmin()), gap.shape)
    side, chord = ("suction", "pressure")[int(number)], float(station[place] + 1) / 2
    if chord <= 0.02:
        along = "leading edge"
    elif chord >= 0.98:
        along = "trailing edge"
    else:
        along = f"{side} side, {100 * chord:.0f} % of the chord"
    if min(radius - inner, outer - radius) < 0.5 * vane.thickness:
        end = "inner" if radius - inner < outer - radius else "outer"
        return f"{name}, root at the {end} shroud, {along}"
    return f"{name}, {100 * span:.0f} % of the span, {along}"
