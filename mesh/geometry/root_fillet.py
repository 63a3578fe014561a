"""Fillets where an aerofoil meets its shrouds: arcs from its lines onto the shrouds, around it.

At a place of the section, the straight line that rules the aerofoil and the shroud's surface stand
at the angle β across the section's curve. The arc of radius r that is tangent to both touches them
at L = r / tan(β/2) from the corner C: at the foot F on the shroud, along the section's normal, and
at the top T on the line. It is the rational parabola of F, C, T with the weights 1, sin(β/2), 1
(L. Piegl, W. Tiller, The NURBS Book, Springer 1997, section 7.3). Where a side meets a rounded
edge, the arc lies on the mitre of the two offsets.

A surface that is tangent to another one cannot be united with it reliably. The shroud at which the
arcs end is therefore thought lower than the real one, by r (1 - cos `_SLANT`): the fillet meets the
shroud at the angle `_SLANT` and covers the arc but for that angle.

Fillets that reach an edge of their shrouds or a quarter of the span are refused. The outermost of
evenly spaced aerofoils stand half a spacing from the segment's ends: fillets that keep off these do
not meet one another. How far a fillet reaches depends on the angle at which the aerofoil stands on
the shroud, so that the largest that fits is searched for.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh.geometry import aerofoil, contact_places
from vanelock.mesh.geometry.dimensions import CLEARANCE, VaneDimensions

_SLANT = np.radians(12.0)  # angle at which fillets meet the shroud, rad
_PLACES = np.linspace(0.0, 1.0, 13)  # along a strip, where its surfaces are interpolated
STRIPS = 4
"""Around a section: convex side, trailing edge, concave side, leading edge."""
_STEP = 1e-5  # of a strip, for directions along it


@dataclass(frozen=True)
class _Strip:
    """A fillet along a side or a rounded edge, in the aerofoil's axes: radial, across, axial."""

    foot: Floats  # (n, 3), Of the arcs at `_PLACES`, m; the axial position counts from mid-plane
    corner: Floats  # (n, 3), Of the arcs at `_PLACES`, m; the axial position counts from mid-plane
    top: Floats  # (n, 3), Of the arcs at `_PLACES`, m; the axial position counts from mid-plane
    weight: Floats  # (n,), Of their corners

    def arc(self, index: int, across: Floats) -> Floats:
        """Points (m, 3) on the arc of a place, at `across` from 0 at the foot to 1 at the top."""
        t = across[:, None]
        shares = ((1 - t) ** 2, 2 * t * (1 - t) * self.weight[index], t**2)
        ends = self.foot[index], self.corner[index], self.top[index]
        total = sum(share * end for share, end in zip(shares, ends, strict=True))
        return np.asarray(total / sum(shares))


@dataclass(frozen=True)
class RationalFace:
    """A face: rational curves across it, each with the control points of one place."""

    rows: Floats  # (d + 1, n, 3), of degree d, at `_PLACES`, m
    weights: Floats  # (d + 1, n)

    def control(self) -> tuple[Floats, Floats, Floats]:
        """Control points (d + 1, n, 3), their weights (d + 1, n) and the cubic spline's knots."""
        spline = self._spline()
        points = np.moveaxis(np.asarray(spline.c), 0, 1)
        return points[..., :3] / points[..., 3:], points[..., 3], np.asarray(spline.t)

    def _spline(self) -> Any:
        from scipy.interpolate import make_interp_spline  # loads much, and few have fillets

        weights = self.weights[..., None]
        homogeneous = np.concatenate([self.rows * weights, weights], axis=-1)
        return make_interp_spline(_PLACES, np.moveaxis(homogeneous, 0, 1), k=3)

    def at(self, along: Floats, across: Floats) -> tuple[Floats, Floats, Floats]:
        """Points (k, m, 3) of the face and their derivatives along and across it."""
        spline, t = self._spline(), across[:, None]
        if len(self.rows) == 2:
            share, slope = np.hstack([1 - t, t]), np.hstack([t * 0 - 1, t * 0 + 1])
        else:
            share = np.hstack([(1 - t) ** 2, 2 * t * (1 - t), t**2])
            slope = np.hstack([2 * t - 2, 2 - 4 * t, 2 * t])
        here, ahead = spline(along), spline(along, 1)
        found = []
        for rows, weights in ((here, share), (ahead, share), (here, slope)):
            found.append(np.einsum("krx,mr->kmx", rows, weights))
        weight = found[0][..., 3:]
        place = found[0][..., :3] / weight
        changes = [(each[..., :3] - each[..., 3:] * place) / weight for each in found[1:]]
        return place, changes[0], changes[1]


def strips(vane: VaneDimensions, outer: bool, radius: float | None = None) -> list[_Strip]:
    """The four strips of a fillet at the inner or the outer shroud."""
    radius = (vane.root_fillet or 0.0) if radius is None else radius
    sunk = radius * (1 - np.cos(_SLANT))
    level = (
        vane.outer_shroud_inner_radius + sunk if outer else vane.inner_shroud_outer_radius - sunk
    )
    corners = [corner(vane, k, _PLACES, level) for k in range(STRIPS)]
    ups = [_unit(places * [1.0, 1.0, 0.0]) for places, _ in corners]  # radial
    normals = []
    for k, up in enumerate(ups):
        ahead, behind = (corner(vane, k, _PLACES + step, level)[0] for step in (_STEP, -_STEP))
        normals.append(_unit(np.cross(ahead - behind, up)))
    made = []
    for k, ((places, lines), up) in enumerate(zip(corners, ups, strict=True)):
        normal, mitre = normals[k].copy(), np.ones(len(_PLACES))
        for end, other in ((0, normals[k - 1][-1]), (-1, normals[(k + 1) % STRIPS][0])):
            normal[end] = _unit((normals[k][end] + other)[None])[0]
            mitre[end] = 1 / (normal[end] @ other)
        made.append(_strip(places, -lines if outer else lines, up, normal, mitre, radius, level))
    return made


def _strip(
    places: Floats,
    lines: Floats,
    up: Floats,
    normal: Floats,
    mitre: Floats,
    radius: float,
    level: float,
) -> _Strip:
    """Arcs between lines (n, 3) and a shroud, which the normals (n, 3) follow from their corner."""
    along = np.cross(normal, up)
    across = lines - np.sum(lines * along, axis=1)[:, None] * along
    length = np.linalg.norm(across, axis=1)
    angle = np.arccos(np.clip(np.sum(across * normal, axis=1) / length, -1, 1))
    reach = radius / np.tan(angle / 2)
    foot = places + normal * (reach * mitre)[:, None]
    foot[:, :2] *= (level / np.hypot(foot[:, 0], foot[:, 1]))[:, None]
    return _Strip(foot, places, places + lines * (reach / length)[:, None], np.sin(angle / 2))


def corner(vane: VaneDimensions, strip: int, places: Floats, level: float) -> tuple[Floats, Floats]:
    """Where the aerofoil's lines meet a cylinder: points (n, 3) and unit directions outwards."""
    ends = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    inner, outer = (_section(vane, strip, places, end) for end in ends)
    radial = np.full(len(places), level)
    for _ in range(40):
        share = (radial - ends[0]) / (ends[1] - ends[0])
        aside = inner + share[:, None] * (outer - inner)
        radial = np.sqrt(level**2 - aside[:, 0] ** 2)
    lines = np.column_stack([np.full(len(places), ends[1] - ends[0]), outer - inner])
    return np.column_stack([radial, aside]), _unit(lines)


def levels(vane: VaneDimensions, strip: int) -> Floats:
    """Points (5, n, 3) on the aerofoil's lines: at the shrouds and at the quarters between them."""
    inner, outer = (
        corner(vane, strip, _PLACES, level)[0]
        for level in (vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius)
    )
    return inner + np.linspace(0, 1, 5)[:, None, None] * (outer - inner)


def faces(vane: VaneDimensions) -> list[list[RationalFace]]:
    """The faces of each strip, from inside the inner to inside the outer shroud.

    A skirt, the fillet, four quarters of the span, the fillet, a skirt; the skirts' ends lie in
    planes across the aerofoil's radial axis.
    """
    start, end = aerofoil.ends(vane)
    found = []
    for k, (low, high) in enumerate(zip(strips(vane, False), strips(vane, True), strict=True)):
        between = [low.top, *levels(vane, k)[1:-1], high.top]
        skirts = []
        for strip, radial in ((low, start), (high, end)):
            skirts.append(np.column_stack([np.full(len(_PLACES), radial), strip.foot[:, 1:]]))
        nets = [
            [skirts[0], low.foot],
            [low.foot, low.corner, low.top],
            *([a, b] for a, b in pairwise(between)),
            [high.top, high.corner, high.foot],
            [high.foot, skirts[1]],
        ]
        weights = [np.ones((len(net), len(_PLACES))) for net in nets]
        weights[1][1], weights[-2][1] = low.weight, high.weight
        found.append([RationalFace(np.array(n), w) for n, w in zip(nets, weights, strict=True)])
    return found


def feet(vane: VaneDimensions, outer: bool) -> Floats:
    """Where the fillet's arcs meet the shroud at the strips' beginnings: (4, 3) m."""
    level = vane.outer_shroud_inner_radius if outer else vane.inner_shroud_outer_radius
    points = []
    for strip in strips(vane, outer):
        low, high = 0.0, 1.0
        for _ in range(50):
            middle = 0.5 * (low + high)
            place = strip.arc(0, np.array([middle]))[0]
            inside = (np.hypot(place[0], place[1]) > level) == outer
            low, high = (middle, high) if inside else (low, middle)
        points.append(strip.arc(0, np.array([low]))[0])
    return np.array(points)


def sweep(vane: VaneDimensions) -> float:
    """The largest angle that an arc turns by outside its shroud, rad."""
    least = min(s.weight.min() for outer in (False, True) for s in strips(vane, outer))
    return float(np.pi - 2 * np.arcsin(least) - _SLANT)


def volume(vane: VaneDimensions) -> float:
    """Volume of an aerofoil with its fillets between the cylinders of the shrouds, m³.

    The flux of the radial field (min(max(ρ, R), S)² - R²) / 2ρ through its skin; the divergence is
    1 between the radii R and S of the shrouds and 0 elsewhere.
    """
    low, high = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    gauss, weight = np.polynomial.legendre.leggauss(4)
    starts, step = _PLACES[:-1], _PLACES[1] - _PLACES[0]
    along = (starts[:, None] + step * (gauss + 1) / 2).ravel()
    by = np.tile(weight * step / 2, len(starts))
    fine, shares = np.polynomial.legendre.leggauss(40)
    across, shares = (fine + 1) / 2, shares / 2
    total = 0.0
    for strip in faces(vane):
        for face in strip:
            place, one, other = face.at(along, across)
            squared = place[..., 0] ** 2 + place[..., 1] ** 2
            field = (np.clip(squared, low**2, high**2) - low**2) / (2 * squared)
            normal = np.cross(one, other)
            flux = field * (place[..., 0] * normal[..., 0] + place[..., 1] * normal[..., 1])
            total += float(by @ flux @ shares)
        rim, along_rim, _ = strip[-1].at(along, np.ones(1))  # of the plane that ends the aerofoil
        swept = (high**2 - low**2) / 2 * np.arctan2(rim[:, 0, 1], rim[:, 0, 0])
        total += float(by @ (swept * along_rim[:, 0, 2]))
    return abs(total)


def _section(vane: VaneDimensions, strip: int, places: Floats, along: float) -> Floats:
    """Points (n, 2) of a strip's section; see `aerofoil.outline`."""
    if strip % 2 == 0:
        station = 2 * places - 1 if strip == 0 else 1 - 2 * places
        return np.asarray(aerofoil.outline(vane, station, along)[strip // 2])
    sides = aerofoil.outline(vane, np.array([-1.0, 1.0]), along)
    leading, trailing = aerofoil.edges(vane, along).control
    start, control, end = (
        (sides[0, 1], trailing, sides[1, 1]) if strip == 1 else (sides[1, 0], leading, sides[0, 0])
    )
    t = places[:, None]
    return np.asarray((1 - t) ** 2 * start + 2 * t * (1 - t) * control + t**2 * end)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


_SHORTEST = 0.25
"""Of its length, what is left of a piece of the hollow side's curve where the fillet ends."""

_Room = tuple[str, float]  # where a fillet lies, and the distance that it leaves there, m


_USUAL, _LEAST = 3e-3, 1.5e-3
"""Radius unless one is given, and the smallest that is then chosen, which coarse meshes follow, m.
"""


@lru_cache(maxsize=256)
def filleted(vane: VaneDimensions, sectors: int) -> VaneDimensions:
    """The vane with the radius of its aerofoils' fillets, chosen where none is given."""
    if vane.root_fillet is not None:
        return vane
    usual = not _too_narrow(vane, sectors, _USUAL)
    radius = _USUAL if usual else _largest(vane, sectors, _USUAL)[0]
    return vane.model_copy(update={"root_fillet": radius if radius >= _LEAST else 0.0})


def check_root_fillet(vane: VaneDimensions, sectors: int) -> None:
    """Refuse a fillet of the aerofoils that does not fit."""
    if not vane.root_fillet or not _too_narrow(vane, sectors, vane.root_fillet):
        return
    largest, where = _largest(vane, sectors, vane.root_fillet)
    least = f"at most {largest:g} m" if largest >= CLEARANCE else "none"
    raise InputError(f"vane.root_fillet = {vane.root_fillet:g} m: {where} {least} fits")


def _largest(vane: VaneDimensions, sectors: int, high: float) -> tuple[float, str]:
    """The largest radius below one that does not fit, and where that meets something."""
    low, where = 0.0, ""
    while high - low > 0.1 * _STEP:
        middle = 0.5 * (low + high)
        if found := _too_narrow(vane, sectors, middle):
            high, where = middle, found
        else:
            low = middle
    return float(_STEP * np.floor(low / _STEP)), where


def _too_narrow(vane: VaneDimensions, sectors: int, radius: float) -> str:
    """Where a fillet does not fit; "" if it does."""
    rooms = _rooms(vane, sectors, radius)
    return next((where for where, room in rooms if room < CLEARANCE), "")


def _rooms(vane: VaneDimensions, sectors: int, radius: float) -> Iterator[_Room]:
    left = contact_places.interlock_frame(vane, sectors)
    planes = (left[0], contact_places.opposite(left, sectors)[0])
    angles = aerofoil.angles(vane, sectors)
    for outer, name in ((False, "inner_shroud"), (True, "outer_shroud")):
        walls = strips(vane, outer, radius)
        level = vane.outer_shroud_inner_radius if outer else vane.inner_shroud_outer_radius
        foot = np.concatenate([strip.foot[:-1] for strip in walls])
        front = vane.hook.mid_plane - float(np.abs(foot[:, 2]).max())
        yield f"behind vane.{name}_front", front - float(getattr(vane, f"{name}_front"))
        if outer:
            half = vane.outer_shroud_extent * np.pi / sectors
            ends = [_unrolled(foot @ rotation(a).T, level)[:, 0] for a in angles[[0, -1]]]
            room = half * level - max(float(np.abs(end).max()) for end in ends)
            yield "beside the ends of the outer shroud (vane.outer_shroud_extent)", room
        else:
            start = foot * [0.0, 1.0, 1.0] + [aerofoil.ends(vane)[0], 0.0, 0.0]
            room = min(
                float(-(points @ rotation(a).T @ plane).max())
                for points in (foot, start)
                for a, plane in zip(angles[[0, -1]], planes, strict=True)
            )
            yield "beside the interlock faces (vane.interlock_slant)", room
        for k, strip in enumerate(walls):
            quarters = levels(vane, k)
            span = np.linalg.norm(quarters[1] - quarters[0], axis=1)
            root = quarters[-1] if outer else quarters[0]
            height = np.linalg.norm(strip.top - root, axis=1)
            yield "within a quarter of the span between the shrouds", float((span - height).min())
        hollow = walls[2]
        at_the_foot, before = np.diff(hollow.foot, axis=0), np.diff(hollow.corner, axis=0)
        left_over = np.sum(at_the_foot * before, axis=1) / np.sum(before**2, axis=1)
        room = np.inf if left_over.min() > _SHORTEST else 0.0
        yield "on the hollow side (vane.camber)", room


def _unrolled(points: Floats, level: float) -> Floats:
    """Points (k, 2) of a cylinder: along its circumference, and axially."""
    return np.column_stack([level * np.arctan2(points[:, 1], points[:, 0]), points[:, 2]])
