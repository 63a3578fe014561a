"""The shape of an aerofoil: a parabolic camber line, parabolic thickness, rounded edges, ruled.

In the chord's frame, with s from -1 to 1 over the length x = ±l between the rounded edges and c the
chord, the camber line stands camber·c·(1/2 - (2x/c)²) off the chord, which centres it; half the
thickness, edge/2 + (thickness - edge)/2·(1 - s²), is measured normal to it. Parabolas round the
edges, half as deep as the edge is thick: one side of a quadratic element follows them exactly,
where semicircles would need several thin ones. The chord counts from nose to nose.

Along its radial axis the aerofoil is ruled, as a milling cutter's flank leaves it: straight lines
join like points of the sections at the two shrouds, which differ by the twist and, leaning, by a
circumferential shift. A section between them is similar to both, at most by 1 - cos(twist/2)
smaller.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh.geometry.dimensions import VaneDimensions

_TOLERANCE = 1e-6  # m
STATIONS = np.linspace(-1.0, 1.0, 9)  # from the leading to the trailing edge; splines join them


@dataclass(frozen=True)
class _Edges:
    """The parabolas that round the edges, from one side over the nose to the other."""

    nose: Floats  # (2, 2)
    control: Floats  # (2, 2)


def outline(vane: VaneDimensions, station: Floats, along: float | None = None) -> Floats:
    """Convex and concave side at stations s between the rounded edges."""
    x = _length(vane) * np.asarray(station)
    camber, slope = _camber(vane, x)
    thinner = (vane.thickness - vane.edge_thickness) * (1 - np.asarray(station) ** 2)
    half = 0.5 * (vane.edge_thickness + thinner)
    normal = np.stack([-slope, np.ones_like(slope)]) / np.sqrt(1 + slope**2)
    sides = np.stack([np.stack([x, camber]) + side * half * normal for side in (1.0, -1.0)])
    return _placed(vane, np.moveaxis(sides, 1, -1), along)


def edges(vane: VaneDimensions, along: float | None = None) -> _Edges:
    """Rounding of the leading and of the trailing edge; see `outline`."""
    noses, controls = [], []
    for number in (0, 1):
        origin, outwards, half = _rounded_frame(vane, number)
        noses.append(origin + half * outwards)
        controls.append(origin + 2 * half * outwards)
    return _Edges(_placed(vane, np.array(noses), along), _placed(vane, np.array(controls), along))


def around(vane: VaneDimensions, along: float | None = None, pieces: int = 8) -> Floats:
    """Points (4·pieces, 2) around the section: each side and, in eighths, the rounded edges."""
    sides = outline(vane, np.linspace(-1.0, 1.0, 2 * pieces - 3), along)
    leading, trailing = edges(vane, along).control
    return np.concatenate(
        [
            sides[0],
            _rounded(sides[0, -1], trailing, sides[1, -1]),
            sides[1, ::-1],
            _rounded(sides[1, 0], leading, sides[0, 0]),
        ]
    )


def _rounded(start: Floats, control: Floats, end: Floats) -> Floats:
    """Points (3, 2) on a parabola between its ends."""
    t = np.array([[0.25], [0.5], [0.75]])
    return np.asarray((1 - t) ** 2 * start + 2 * t * (1 - t) * control + t**2 * end)


@lru_cache(maxsize=64)
def _length(vane: VaneDimensions) -> float:
    """Half the length between the rounded edges, along the chord."""
    end = 0.5 * vane.chord
    for _ in range(20):
        _, slope = _camber(vane, np.array([end]))
        end = 0.5 * (vane.chord - vane.edge_thickness / float(np.sqrt(1 + slope[0] ** 2)))
    return end


def _camber(vane: VaneDimensions, x: Floats) -> tuple[Floats, Floats]:
    """Height of the camber line above the chord, and its slope."""
    s = 2 * x / vane.chord
    return vane.camber * vane.chord * (0.5 - s**2), -4 * vane.camber * s


def _placed(vane: VaneDimensions, points: Floats, along: float | None) -> Floats:
    """From the chord's frame (..., 2) to circumferential and axial position."""
    turn, shift = _section(vane, None if along is None else np.asarray(along))
    return np.asarray(points @ turn + shift)


def _section(vane: VaneDimensions, along: Floats | None) -> tuple[Floats, Floats]:
    """Matrices (..., 2, 2) and shifts (..., 2) of the sections at places along the radial axis."""
    root, tip = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    share = np.asarray(0.5 if along is None else (along - root) / (tip - root))[..., None]
    ends = [_frame(np.radians(vane.stagger + side * 0.5 * vane.twist)) for side in (-1, 1)]
    turn = (1 - share[..., None]) * ends[0] + share[..., None] * ends[1]
    lean = (tip - root) * np.tan(np.radians(vane.lean)) * np.array([1.0, 0.0])
    return turn, (share - 0.5) * lean


def on_rounding(vane: VaneDimensions, points: Floats, number: int) -> Floats | None:
    """How far round a rounded edge points lie, from -1 on the concave to 1 on the convex side."""
    turn, shift = _section(vane, points[:, 0])
    local = np.linalg.solve(turn.swapaxes(1, 2), (points[:, 1:] - shift)[..., None])[..., 0]
    origin, outwards, half = _rounded_frame(vane, number)
    ahead, aside = ((local - origin) @ np.array([outwards, [-outwards[1], outwards[0]]]).T).T / half
    aside = aside if number else -aside
    off = np.abs(ahead - (1 - aside**2)).max()
    return (
        aside if off < _TOLERANCE / half and np.abs(aside).max() < 1 + _TOLERANCE / half else None
    )


def rounding(vane: VaneDimensions, along: Floats, aside: Floats, number: int) -> Floats:
    """Points (k, 3) on a rounded edge: the inverse of `on_rounding`."""
    turn, shift = _section(vane, along)
    origin, outwards, half = _rounded_frame(vane, number)
    across = np.array([-outwards[1], outwards[0]]) * (1 if number else -1)
    local = origin + half * ((1 - aside**2)[:, None] * outwards + aside[:, None] * across)
    return np.column_stack([along, np.einsum("ki,kij->kj", local, turn) + shift])


def _rounded_frame(vane: VaneDimensions, number: int) -> tuple[Floats, Floats, float]:
    """Middle between the sides' ends, direction outwards, and half the edge's thickness."""
    sign = 2 * number - 1
    x = sign * _length(vane)
    (camber,), (slope,) = _camber(vane, np.array([x]))
    outwards = sign * np.array([1.0, slope]) / np.sqrt(1 + slope**2)
    return np.array([x, camber]), outwards, 0.5 * vane.edge_thickness


def _frame(stagger: float) -> Floats:
    """Rows: direction of the chord and its normal, circumferential and axial components."""
    c, s = np.cos(stagger), np.sin(stagger)
    return np.array([[s, c], [c, -s]])


def angles(vane: VaneDimensions, sectors: int) -> Floats:
    """Angular positions of the aerofoils' radial axes, rad, evenly spaced about zero."""
    pitch = 2 * np.pi / sectors
    return pitch * ((np.arange(vane.aerofoils) + 0.5) / vane.aerofoils - 0.5)


def ends(vane: VaneDimensions) -> tuple[float, float]:
    """Start and end of an aerofoil along its radial axis, m, both inside the shrouds."""
    start = 0.5 * (vane.inner_shroud_inner_radius + vane.inner_shroud_outer_radius)
    return start, 0.5 * (vane.outer_shroud_inner_radius + vane.outer_shroud_outer_radius)


def _on_side(vane: VaneDimensions, side: int, station: float, along: float) -> Floats:
    """Point (3,) on the convex side, 0, or the concave one, 1, in the frame of `on_rounding`."""
    across, axial = outline(vane, np.array([station]), along)[side, 0]
    return np.array([along, across, axial])


def _spanwise(vane: VaneDimensions, side: int, station: float) -> Floats:
    """Both ends (2, 3) of a line that rules a side, on the shrouds; see `_on_side`."""
    found = []
    for radius in (vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius):
        along = radius
        for _ in range(30):
            along = float(np.sqrt(radius**2 - _on_side(vane, side, station, along)[1] ** 2))
        found.append(_on_side(vane, side, station, along))
    return np.array(found)


def noses(vane: VaneDimensions, sectors: int) -> Floats:
    """Where the rounded edges of all aerofoils meet the shrouds: (4a, 3) m."""
    found = []
    for radius in (vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius):
        at = edges(vane, radius).nose
        points = np.column_stack([[radius, radius], at[:, 0], vane.hook.mid_plane + at[:, 1]])
        found += [points @ rotation(angle).T for angle in angles(vane, sectors)]
    return np.concatenate(found)


def output_points(vane: VaneDimensions, sectors: int) -> Floats:
    """Output nodes on the convex side at mid-chord of the middle aerofoil: (3, 3) m.

    They lie at 25, 50 and 75 % of the span, counted from the inner shroud.
    """
    inner, outer = _spanwise(vane, 0, 0.0)
    points = inner + np.array([[0.25], [0.5], [0.75]]) * (outer - inner)
    axis = angles(vane, sectors)[(vane.aerofoils - 1) // 2]
    points += np.array([0.0, 0.0, vane.hook.mid_plane])
    return np.asarray(points @ rotation(axis).T)


_STEP = 1e-5  # of the station, for the direction along the profile
_Side = Literal["suction", "pressure"]


@dataclass(frozen=True)
class AerofoilPoint:
    """A place on an aerofoil and a direction in its surface.

    Attributes
    ----------
    position, direction, normal : (3,) float
        Where, m; the unit direction; the unit outward normal.
    """

    position: Floats
    direction: Floats
    normal: Floats


def on_aerofoil(
    vane: VaneDimensions,
    sectors: int,
    aerofoil: int,
    span: float,
    chord: float,
    side: _Side = "suction",
    direction: float | Literal["span", "chord"] = "span",
) -> AerofoilPoint:
    """A place on the surface of an aerofoil of the vane segment.

    Parameters
    ----------
    vane : VaneDimensions
    sectors : int
        Segments in the ring.
    aerofoil : int
        1, 2, ... by ascending angle about the engine axis.
    span : float
        From 0 at the inner shroud to 1 at the outer shroud.
    chord : float
        From 0 where the rounded leading edge ends to 1 where the trailing one begins.
    side : "suction" or "pressure"
        The convex or the concave side.
    direction : "span", "chord" or float
        Along the straight line that rules the surface there, which is radial without lean and
        twist; along the profile towards the trailing edge; or the angle from the former towards
        the latter, degrees.

    Raises
    ------
    InputError
        Naming what is out of range.
    """
    if not 1 <= aerofoil <= vane.aerofoils:
        raise InputError(f"aerofoil = {aerofoil}: allowed are 1 to {vane.aerofoils}")
    for name, value in (("span", span), ("chord", chord)):
        if not 0 <= value <= 1:
            raise InputError(f"{name} = {value:g}: allowed are 0 to 1")
    degrees = {"span": 0.0, "chord": 90.0}[direction] if isinstance(direction, str) else direction

    turn = rotation(angles(vane, sectors)[aerofoil - 1])
    side_number, station = get_args(_Side).index(side), 2 * chord - 1

    # Straight lines rule the surface; the shrouds that end them are cylinders.
    inner, outer = _spanwise(vane, side_number, station)
    along_span = outer - inner
    position = inner + span * along_span
    along_span /= np.linalg.norm(along_span)
    ahead, behind = (
        _on_side(vane, side_number, station + step, position[0]) for step in (_STEP, -_STEP)
    )
    tangent = ahead - behind
    tangent /= np.linalg.norm(tangent)
    normal = np.cross(along_span, tangent) * (-1 if side == "suction" else 1)
    normal /= np.linalg.norm(normal)
    position[2] += vane.hook.mid_plane
    angle = np.radians(degrees)
    if direction == "chord":
        chosen = tangent
    else:
        aside = tangent - (tangent @ along_span) * along_span
        chosen = np.cos(angle) * along_span + np.sin(angle) * aside / np.linalg.norm(aside)
    return AerofoilPoint(turn @ position, turn @ chosen, turn @ normal)
