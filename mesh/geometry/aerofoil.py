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

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh.cells import solid
from vanelock.mesh.exterior import exterior
from vanelock.mesh.geometry.dimensions import VaneDimensions
from vanelock.mesh.part import Part

Array = NDArray[np.float64]

TOLERANCE = 1e-6  # m
STATIONS = np.linspace(-1.0, 1.0, 9)  # from the leading to the trailing edge; splines join them


@dataclass(frozen=True)
class Edges:
    """The parabolas that round the edges, from one side over the nose to the other.

    Attributes
    ----------
    nose, control : (2, 2) float
        Of the leading and of the trailing edge, as in `outline`: the outermost point, and where the
        tangents at the sides' ends meet.
    """

    nose: Array
    control: Array


def outline(vane: VaneDimensions, station: Array, along: float | None = None) -> Array:
    """Convex and concave side at stations s between the rounded edges."""
    x = _length(vane) * np.asarray(station)
    camber, slope = _camber(vane, x)
    half = _half_thickness(vane, np.asarray(station))
    normal = np.stack([-slope, np.ones_like(slope)]) / np.sqrt(1 + slope**2)
    sides = np.stack([np.stack([x, camber]) + side * half * normal for side in (1.0, -1.0)])
    return _placed(vane, np.moveaxis(sides, 1, -1), along)


def edges(vane: VaneDimensions, along: float | None = None) -> Edges:
    """Rounding of the leading and of the trailing edge; see `outline`."""
    noses, controls = [], []
    for number in (0, 1):
        origin, outwards, half = _rounded_frame(vane, number)
        noses.append(origin + half * outwards)
        controls.append(origin + 2 * half * outwards)
    return Edges(_placed(vane, np.array(noses), along), _placed(vane, np.array(controls), along))


def around(vane: VaneDimensions, along: float | None = None, pieces: int = 8) -> Array:
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


def _rounded(start: Array, control: Array, end: Array) -> Array:
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


def _camber(vane: VaneDimensions, x: Array) -> tuple[Array, Array]:
    """Height of the camber line above the chord, and its slope."""
    s = 2 * x / vane.chord
    return vane.camber * vane.chord * (0.5 - s**2), -4 * vane.camber * s


def _half_thickness(vane: VaneDimensions, station: Array) -> Array:
    return 0.5 * (vane.edge_thickness + (vane.thickness - vane.edge_thickness) * (1 - station**2))


def _placed(vane: VaneDimensions, points: Array, along: float | None) -> Array:
    """From the chord's frame (..., 2) to circumferential and axial position."""
    turn, shift = _section(vane, None if along is None else np.asarray(along))
    return np.asarray(points @ turn + shift)


def _section(vane: VaneDimensions, along: Array | None) -> tuple[Array, Array]:
    """Matrices (..., 2, 2) and shifts (..., 2) of the sections at places along the radial axis."""
    root, tip = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    share = np.asarray(0.5 if along is None else (along - root) / (tip - root))[..., None]
    ends = [_frame(np.radians(vane.stagger + side * 0.5 * vane.twist)) for side in (-1, 1)]
    turn = (1 - share[..., None]) * ends[0] + share[..., None] * ends[1]
    lean = (tip - root) * np.tan(np.radians(vane.lean)) * np.array([1.0, 0.0])
    return turn, (share - 0.5) * lean


def on_rounding(vane: VaneDimensions, points: Array, number: int) -> Array | None:
    """How far round a rounded edge points lie, from -1 on the concave to 1 on the convex side."""
    turn, shift = _section(vane, points[:, 0])
    local = np.linalg.solve(turn.swapaxes(1, 2), (points[:, 1:] - shift)[..., None])[..., 0]
    origin, outwards, half = _rounded_frame(vane, number)
    ahead, aside = ((local - origin) @ np.array([outwards, [-outwards[1], outwards[0]]]).T).T / half
    aside = aside if number else -aside
    off = np.abs(ahead - (1 - aside**2)).max()
    return aside if off < TOLERANCE / half and np.abs(aside).max() < 1 + TOLERANCE / half else None


def rounding(vane: VaneDimensions, along: Array, aside: Array, number: int) -> Array:
    """Points (k, 3) on a rounded edge: the inverse of `on_rounding`."""
    turn, shift = _section(vane, along)
    origin, outwards, half = _rounded_frame(vane, number)
    across = np.array([-outwards[1], outwards[0]]) * (1 if number else -1)
    local = origin + half * ((1 - aside**2)[:, None] * outwards + aside[:, None] * across)
    return np.column_stack([along, np.einsum("ki,kij->kj", local, turn) + shift])


def _rounded_frame(vane: VaneDimensions, number: int) -> tuple[Array, Array, float]:
    """Middle between the sides' ends, direction outwards, and half the edge's thickness."""
    sign = 2 * number - 1
    x = sign * _length(vane)
    (camber,), (slope,) = _camber(vane, np.array([x]))
    outwards = sign * np.array([1.0, slope]) / np.sqrt(1 + slope**2)
    return np.array([x, camber]), outwards, 0.5 * vane.edge_thickness


def _frame(stagger: float) -> Array:
    """Rows: direction of the chord and its normal, circumferential and axial components."""
    c, s = np.cos(stagger), np.sin(stagger)
    return np.array([[s, c], [c, -s]])


def angles(vane: VaneDimensions, sectors: int) -> Array:
    """Angular positions of the aerofoils' radial axes, rad, evenly spaced about zero."""
    pitch = 2 * np.pi / sectors
    return pitch * ((np.arange(vane.aerofoils) + 0.5) / vane.aerofoils - 0.5)


def ends(vane: VaneDimensions) -> tuple[float, float]:
    """Start and end of an aerofoil along its radial axis, m, both inside the shrouds."""
    start = 0.5 * (vane.inner_shroud_inner_radius + vane.inner_shroud_outer_radius)
    return start, 0.5 * (vane.outer_shroud_inner_radius + vane.outer_shroud_outer_radius)


def on_side(vane: VaneDimensions, side: int, station: float, along: float) -> Array:
    """Point (3,) on the convex side, 0, or the concave one, 1, in the frame of `on_rounding`."""
    across, axial = outline(vane, np.array([station]), along)[side, 0]
    return np.array([along, across, axial])


def spanwise(vane: VaneDimensions, side: int, station: float) -> Array:
    """Both ends (2, 3) of a line that rules a side, on the shrouds; see `on_side`."""
    found = []
    for radius in (vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius):
        along = radius
        for _ in range(30):
            along = float(np.sqrt(radius**2 - on_side(vane, side, station, along)[1] ** 2))
        found.append(on_side(vane, side, station, along))
    return np.array(found)


def noses(vane: VaneDimensions, sectors: int) -> Array:
    """Where the rounded edges of all aerofoils meet the shrouds: (4a, 3) m."""
    found = []
    for radius in (vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius):
        at = edges(vane, radius).nose
        points = np.column_stack([[radius, radius], at[:, 0], vane.hook.mid_plane + at[:, 1]])
        found += [points @ rotation(angle).T for angle in angles(vane, sectors)]
    return np.concatenate(found)


def output_points(vane: VaneDimensions, sectors: int) -> Array:
    """Output nodes on the convex side at mid-chord of the middle aerofoil: (3, 3) m.

    They lie at 25, 50 and 75 % of the span, counted from the inner shroud.
    """
    inner, outer = spanwise(vane, 0, 0.0)
    points = inner + np.array([[0.25], [0.5], [0.75]]) * (outer - inner)
    axis = angles(vane, sectors)[(vane.aerofoils - 1) // 2]
    points += np.array([0.0, 0.0, vane.hook.mid_plane])
    return np.asarray(points @ rotation(axis).T)


ON = 1e-5
"""Nodes lie on a shroud's surface within this, m."""


def aerofoil_faces(part: Part, dimensions: VaneDimensions) -> tuple[NDArray[np.int64], ...]:
    """(f, 6) nodes of the faces of each aerofoil, by ascending angle, root fillets included."""
    inner, outer = dimensions.inner_shroud_outer_radius, dimensions.outer_shroud_inner_radius
    faces = exterior(part.cells, solid(part.cell_type))
    radius = np.hypot(*part.points.T[:2])[faces]
    between = ((radius > inner - ON) & (radius < outer + ON)).all(axis=1)
    shroud = (radius < inner + ON).all(axis=1) | (radius > outer - ON).all(axis=1)
    faces = faces[between & ~shroud]
    rows = np.repeat(np.arange(len(faces)), faces.shape[1])
    shape = len(faces), len(part.points)
    touches = csr_array((np.ones(faces.size), (rows, faces.ravel())), shape=shape)
    count, piece = connected_components(touches @ touches.T, directed=False)
    if count != dimensions.aerofoils:
        raise InputError(f"{part.name}: {count} surfaces between the shrouds, not one an aerofoil")
    middle = [part.points[faces[piece == i, :3]].mean(axis=(0, 1)) for i in range(count)]
    order = np.argsort([np.arctan2(y, x) for x, y, _ in middle])
    return tuple(faces[piece == i] for i in order)
