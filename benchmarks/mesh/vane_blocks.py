"""The vane segment as a mesh of hexahedra: quadrilaterals of both shrouds, swept radially.

Seen from the engine's axis both shrouds are rows of quadrilaterals between axial stations: the
shroud's ends, the corners of the aerofoils' rounded edges, the legs' faces and the feet's. Both
share the aerofoils' sections, which sweep from one shroud to the other. Every curved wall passes
through the nodes that lie on it.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from benchmarks.mesh.blocks import Curve, Floats, Sizes, between, glued, straight, swept
from benchmarks.mesh.section import Section
from vanelock.common.errors import InputError
from vanelock.mesh import Part, VaneDimensions
from vanelock.mesh.geometry import aerofoil

EDGE = 0.5  # size along an aerofoil's rounded edges, over that elsewhere
ENDS = np.array([0.0, 1.0])


@dataclass(frozen=True)
class Shroud:
    """What is seen of a shroud from the axis, unrolled: angle and axial position from mid-plane.

    Attributes
    ----------
    radius : float
        At which the aerofoils' sections are imprinted, m.
    ends : tuple of float
        Stations before the aerofoils, from the front, m; those behind mirror them.
    half : float
        Half of its angle, rad.
    slant : float
        Tangent of the angle between its side faces and the axis.
    widening : float
        Slope of the strips' sides before and behind the aerofoils, against the side faces.
    """

    radius: float
    ends: tuple[float, ...]
    half: float
    slant: float
    widening: float

    def edge(self, axial: Floats, radius: float | None = None) -> Floats:
        """Angle of a side face, less that of its middle, at a radius, m."""
        return np.arcsin(np.asarray(axial) * self.slant / (radius or self.radius))


@dataclass(frozen=True)
class Layout:
    """What both shrouds share.

    Attributes
    ----------
    section : Section
        Of the aerofoils.
    angles : (b,) float
        Of their axes, rad.
    steps : list of (a,) float
        `shares` from one of the section's stations to the next.
    across : (c,) float
        `shares` from the concave to the convex side.
    leaves : list of (a, c, 2) float
        Lattices that fill the section.
    sizes : Sizes
    """

    section: Section
    angles: Floats
    steps: list[Floats]
    across: Floats
    leaves: list[Floats]
    sizes: Sizes


def vane_hexahedra(
    sizes: Sizes,
    vane: VaneDimensions | None = None,
    sectors: int = 16,
    cell_type: str = "hexahedron20",
) -> Part:
    """Mesh a vane segment with hexahedra.

    Parameters
    ----------
    sizes : Sizes
    vane : VaneDimensions, optional
        The scene's by default; without lean, twist and fillets.
    sectors : int
    cell_type : {"hexahedron", "hexahedron20", "hexahedron27"}

    Raises
    ------
    InputError
        If the aerofoils are not prisms, or do not reach over the legs.
    """
    vane = vane or VaneDimensions()
    mid = vane.hook.mid_plane
    layout = _layout(vane, sectors, sizes)
    outer = Shroud(
        vane.outer_shroud_inner_radius,
        (vane.outer_shroud_front - mid, vane.foot_front - mid),
        vane.outer_shroud_extent * np.pi / sectors,
        slant=0.0,
        widening=0.1,
    )
    inner = Shroud(
        vane.inner_shroud_outer_radius,
        (vane.inner_shroud_front - mid,),
        np.pi / sectors,
        slant=float(np.tan(np.radians(vane.interlock_slant))),
        widening=0.35,
    )
    blocks = [
        *_aerofoils(vane, layout),
        *_inner(vane, inner, _sheets(inner, layout), sizes),
        *_outer(vane, outer, _sheets(outer, layout), sizes),
    ]
    moved = [block + np.array([0.0, 0.0, mid]) for block in blocks]
    return glued("vane", moved, cell_type, sectors)


def _layout(vane: VaneDimensions, sectors: int, sizes: Sizes) -> Layout:
    if vane.lean or vane.twist:
        raise InputError("vane: the blocks need aerofoils without lean and twist")
    lines = np.array([vane.leg_front, vane.leg_rear]) - vane.hook.mid_plane
    section = Section.of(vane, np.concatenate([lines, -lines[::-1]]))
    lengths = section.lengths()
    lengths[[0, -1]] /= EDGE
    steps = [sizes.along(length) for length in lengths]
    across = sizes.across(vane.thickness)
    leaves = section.blocks(steps, across)
    return Layout(section, aerofoil.angles(vane, sectors), steps, across, leaves, sizes)


def _aerofoils(vane: VaneDimensions, layout: Layout) -> list[Floats]:
    low, high = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    steps = layout.sizes.along(high - low)
    return [
        swept(*(_solid(_around(leaf, angle, r), r) for r in (low, high)), steps)
        for leaf in layout.leaves
        for angle in layout.angles
    ]


def _inner(
    vane: VaneDimensions, shroud: Shroud, sheets: list[Floats], sizes: Sizes
) -> list[Floats]:
    radius = vane.inner_shroud_inner_radius
    steps = sizes.along(shroud.radius - radius, start=False)
    blocks = []
    for sheet in sheets:
        axial = sheet[..., 1]
        below = sheet.copy()
        below[..., 0] += shroud.edge(axial, radius) - shroud.edge(axial)
        blocks.append(swept(_solid(below, radius), _solid(sheet, shroud.radius), steps))
    return blocks


def _outer(
    vane: VaneDimensions, shroud: Shroud, sheets: list[Floats], sizes: Sizes
) -> list[Floats]:
    """The shroud, the legs on it, and the feet on these and before them."""
    hook, mid = vane.hook, vane.hook.mid_plane
    leg = mid - vane.leg_rear, mid - vane.leg_front
    layers = (
        (shroud.radius, vane.outer_shroud_outer_radius, (0.0, np.inf), True),
        (vane.outer_shroud_outer_radius, hook.lip_radius, leg, True),
        (hook.lip_radius, hook.roof_radius, (leg[0], mid - vane.foot_front), False),
    )
    return [
        swept(_solid(sheet, low), _solid(sheet, high), sizes.along(high - low, end=end))
        for low, high, (near, far), end in layers
        for sheet in sheets
        if near < abs(sheet[..., 1].mean()) < far
    ]


def _sheets(shroud: Shroud, layout: Layout) -> list[Floats]:
    """Lattices (a, b, 2) of angle and axial position that fill a shroud."""
    sizes, first = layout.sizes, len(shroud.ends)
    last = first + len(layout.steps)
    found = [
        _around(leaf, angle, shroud.radius) for leaf in layout.leaves for angle in layout.angles
    ]
    lines = _lines(shroud, layout)
    steps = [
        sizes.along(float(np.ptp(curve(ENDS)[:, 1])), start=i == last, end=i == first - 1)
        for i, curve in enumerate(lines[1])
    ]
    steps[first:last] = layout.steps
    for k, pair in enumerate(pairwise(lines)):
        stations = [_crossing(shroud, layout, pair, k, i) for i in range(len(steps) + 1)]
        width = shroud.radius * float(np.mean([np.ptp(curve(ENDS)[:, 0]) for curve in stations]))
        passage = sizes.along(width, start=k > 0, end=k < len(lines) - 2)
        for i, sides in enumerate(zip(*pair, strict=True)):
            if k % 2 and first <= i < last:
                continue  # an aerofoil
            across = layout.across if k % 2 else passage
            found.append(between(*sides, *stations[i : i + 2], steps[i], across))
    return found


def _lines(shroud: Shroud, layout: Layout) -> list[list[Curve]]:
    """Curves from station to station, along the left side, both sides of each aerofoil, the right.

    On a side face the stations lie as far back as those of the aerofoil next to it.
    """
    rows = [
        _flank(shroud, layout, angle, which)
        for angle in layout.angles
        for which in ("concave", "convex")
    ]
    sides = [
        [_side(shroud, sign, curve(ENDS)[:, 1]) for curve in row]
        for row, sign in ((rows[0], -1.0), (rows[-1], 1.0))
    ]
    return [sides[0], *rows, sides[1]]


def _side(shroud: Shroud, sign: float, axial: Floats) -> Curve:
    """A side face between two axial positions."""

    def curve(t: Floats) -> Floats:
        at = (1 - t) * axial[0] + t * axial[1]
        return np.stack([sign * shroud.half + shroud.edge(at), at], axis=-1)

    return curve


def _flank(shroud: Shroud, layout: Layout, angle: float, which: str) -> list[Curve]:
    """From the shroud's front along one side of an aerofoil to its rear."""
    curves: list[Curve] = [
        _unrolled(layout.section.side(which, k, steps), angle, shroud.radius)
        for k, steps in enumerate(layout.steps)
    ]
    aside = 1.0 if which == "convex" else -1.0
    nose, tail = curves[0](ENDS)[0], curves[-1](ENDS)[-1]
    front = _ahead(shroud, nose, np.array(shroud.ends), aside)
    rear = _ahead(shroud, tail, -np.array(shroud.ends[::-1]), aside)
    before = [straight(*pair) for pair in zip(front, [*front[1:], nose], strict=True)]
    behind = [straight(*pair) for pair in zip([tail, *rear[:-1]], rear, strict=True)]
    return [*before, *curves, *behind]


def _ahead(shroud: Shroud, point: Floats, axial: Floats, aside: float) -> list[Floats]:
    """Where the line that goes on from an aerofoil's edge, along the side faces, meets stations."""
    far = axial[np.argmax(abs(axial))]
    way = far - point[1]
    turn = float(shroud.edge(far) - shroud.edge(point[1]))
    turn += aside * shroud.widening * abs(way) / shroud.radius
    return [np.array([point[0] + turn * (z - point[1]) / way, z]) for z in axial]


def _crossing(
    shroud: Shroud, layout: Layout, lines: tuple[list[Curve], list[Curve]], k: int, station: int
) -> Curve:
    """From line k to the next at a station: straight, but around an aerofoil's edges."""
    inside = station - len(shroud.ends)
    if k % 2 and 0 <= inside <= len(layout.steps):
        across = layout.section.across(inside)
        return _unrolled(across, layout.angles[k // 2], shroud.radius)
    start, end = (
        line[-1](ENDS)[1] if station == len(line) else line[station](ENDS)[0] for line in lines
    )
    return straight(start, end)


def _unrolled(curve: Curve, angle: float, radius: float) -> Curve:
    return lambda t: _around(curve(t), angle, radius)


def _around(points: Floats, angle: float, radius: float) -> Floats:
    """Angle and axial position at a radius from positions (..., 2) beside an aerofoil's axis."""
    return np.stack([angle + np.arcsin(points[..., 0] / radius), points[..., 1]], axis=-1)


def _solid(sheet: Floats, radius: float) -> Floats:
    """Points (a, b, 3) of angles and axial positions on a cylinder."""
    angle = sheet[..., 0]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), sheet[..., 1]], axis=-1)
