"""An aerofoil's section cut into quadrilaterals, some of whose sides lie at given axial positions.

The legs of the hooks end in lines across the aerofoils, so that a mesh of hexahedra must follow
both. Between such lines a section is a strip. What is left at each rounded edge is a quadrilateral
with wide angles where the edge meets the sides, at which one element would be almost flat; so a
ring of four blocks around a fifth fills it, and two of them share each angle.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from benchmarks.mesh.blocks import Curve, Floats, between, straight
from vanelock.common.errors import InputError
from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry import aerofoil

TABLE = 400  # points of each piece of the outline at which its length is summed up
APART = np.radians(55)  # of a rounded edge's corners, to either side of its middle
NEAR = np.radians(15)
CORE = 0.45  # size of the inner block of a rounded edge, in its quadrilateral's


@dataclass(frozen=True)
class Outline:
    """The closed outline of a section.

    Its places are numbers from 0 to 4: along the convex side from the leading edge, around the
    trailing edge, back along the concave side, around the leading edge.
    """

    vane: VaneDimensions

    def at(self, places: Floats) -> Floats:
        """Points (n, 2): circumferential and axial position, m, from the aerofoil's axis."""
        places = np.mod(places, 4)
        piece = np.minimum(places.astype(int), 3)
        along = places - piece
        found = np.empty((len(places), 2))
        for side, station in ((0, 2 * along - 1), (2, 1 - 2 * along)):
            on = piece == side
            found[on] = aerofoil.outline(self.vane, station[on])[side // 2]
        sides = aerofoil.outline(self.vane, np.array([-1.0, 1.0]))
        leading, trailing = aerofoil.edges(self.vane).control
        corners = (sides[0, 1], trailing, sides[1, 1]), (sides[1, 0], leading, sides[0, 0])
        for side, (start, control, end) in zip((1, 3), corners, strict=True):
            on = piece == side
            t = along[on, None]
            found[on] = (1 - t) ** 2 * start + 2 * t * (1 - t) * control + t**2 * end
        return found

    def crossings(self, axial: float) -> tuple[float, float]:
        """Places on the concave and on the convex side at an axial position.

        Raises
        ------
        InputError
            If the outline does not cross it.
        """
        places, _ = self._table
        above = self.at(places)[:, 1] > axial
        found = [
            float(brentq(lambda w: self.at(np.array([w]))[0, 1] - axial, *places[k : k + 2]))
            for k in np.flatnonzero(above[1:] != above[:-1])
        ]
        if len(found) != 2:
            raise InputError(
                f"vane: the blocks need aerofoils that reach over the legs; this one has "
                f"{len(found)} points at {axial:g} m from mid-plane"
            )
        first, second = sorted(found, key=lambda w: self.at(np.array([w]))[0, 0])
        return first, second

    def piece(self, start: float, end: float, steps: Floats | None = None) -> Curve:
        """The shorter way from one place to another, by arc length.

        Where a side meets a rounded edge on the way, at an angle, the nearest of the elements'
        corners at the `steps`, `blocks.shares`, is drawn there.
        """
        places, length = self._table
        total = length[-1]
        first, last = np.interp(np.mod([start, end], 4), places, length)
        way = np.mod(last - first + 0.5 * total, total) - 0.5 * total
        given, drawn = [0.0, 1.0], [0.0, 1.0]
        for corner in length[:-1:TABLE] if steps is not None and len(steps) > 3 else []:
            at = (np.mod(corner - first + 0.5 * total, total) - 0.5 * total) / way
            if 1e-6 < at < 1 - 1e-6:
                inner = steps[2:-1:2]
                given.insert(1, float(inner[np.argmin(abs(inner - at))]))
                drawn.insert(1, at)

        def curve(t: Floats) -> Floats:
            share = np.interp(t, given, drawn)
            along = np.interp(np.mod(first + way * share, total), length, places)
            along[t == 0], along[t == 1] = start, end
            return self.at(along)

        return curve

    def length(self, start: float, end: float) -> float:
        """Of the shorter way from one place to another, m."""
        points = self.piece(start, end)(np.linspace(0, 1, 50))
        return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())

    @cached_property
    def _table(self) -> tuple[Floats, Floats]:
        places = np.linspace(0, 4, 4 * TABLE + 1)
        points = self.at(places)
        step = np.linalg.norm(np.diff(points, axis=0), axis=1)
        return places, np.append(0.0, np.cumsum(step))


@dataclass(frozen=True)
class Section:
    """Stations from the leading to the trailing edge, and the blocks between them.

    Attributes
    ----------
    outline : Outline
    concave, convex : tuple of float
        Places of the stations: the corners of the leading edge, where the lines at `axial` cross,
        and the corners of the trailing edge.
    """

    outline: Outline
    concave: tuple[float, ...]
    convex: tuple[float, ...]

    @classmethod
    def of(cls, vane: VaneDimensions, axial: Floats) -> "Section":
        """Section of a vane's aerofoils with stations at axial positions from mid-plane."""
        outline = Outline(vane)
        lines = [outline.crossings(z) for z in axial]
        ends = [_corners(outline, edge) for edge in (0, 1)]
        concave, convex = zip(ends[0], *lines, ends[1], strict=True)
        if not np.all(np.diff(concave) < 0) or not np.all(np.diff(convex) > 0):
            raise InputError("vane: the blocks need legs that stay clear of the aerofoils' noses")
        return cls(outline, concave, convex)

    def side(self, which: str, interval: int, steps: Floats) -> Curve:
        """The "concave" or the "convex" side between a station and the next, see `piece`."""
        places = getattr(self, which)
        return self.outline.piece(places[interval], places[interval + 1], steps)

    def across(self, station: int) -> Curve:
        """From the concave to the convex side at a station."""
        ends = self.concave[station], self.convex[station]
        if station in (0, len(self.concave) - 1):
            return self.outline.piece(*ends)
        return straight(*self.outline.at(np.array(ends)))

    def lengths(self) -> Floats:
        """(intervals,) length of the longer side between each station and the next, m."""
        return np.array(
            [
                max(self.outline.length(*places[k : k + 2]) for places in self.sides())
                for k in range(len(self.concave) - 1)
            ]
        )

    def sides(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Places of the stations on both sides."""
        return self.concave, self.convex

    def blocks(self, steps: list[Floats], across: Floats) -> list[Floats]:
        """Lattices (a, b, 2) that fill the section.

        Parameters
        ----------
        steps : list of (a,) float
            `blocks.shares` between a station and the next.
        across : (b,) float
            Those from the concave to the convex side.
        """
        last = len(steps) - 1
        found: list[Floats] = []
        for k, step in enumerate(steps):
            sides = (
                self.side("concave", k, step),
                self.side("convex", k, step),
                self.across(k),
                self.across(k + 1),
            )
            if k in (0, last):
                found += _ring(sides, step, across)
            else:
                found.append(between(*sides, step, across))
        return found


def _corners(outline: Outline, edge: int) -> tuple[float, float]:
    """Places of a rounded edge's corners on the concave and on the convex side.

    They lie to both sides of the middle between the nose and the axial direction, which the blocks
    before and behind the aerofoils face; where a side begins, if that is near.
    """
    ends = np.array([3.0, 4.0]) if edge == 0 else np.array([2.0, 1.0])
    places = ends[0] + np.linspace(0, 1, 201) * (ends[1] - ends[0])
    tangent = np.gradient(outline.at(np.clip(places, 0, 4 - 1e-9)), axis=0)
    angle = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
    # Where the edge faces along the axis, its tangent from concave to convex has no axial part.
    axial = angle[100] + np.mod(np.pi - angle[100], 2 * np.pi) - np.pi
    middle = 0.5 * (angle[100] + axial)
    found = []
    for end, side in ((0, -1.0), (-1, 1.0)):
        wanted = middle + side * np.sign(angle[-1] - angle[0]) * APART
        near = int(np.argmin(abs(angle - wanted)))
        start = abs(angle[near] - angle[end]) < NEAR
        found.append(float(places[end] if start else places[near]))
    return found[0], found[1] % 4


def _ring(sides: tuple[Curve, Curve, Curve, Curve], u: Floats, v: Floats) -> list[Floats]:
    """Five blocks in a quadrilateral between four curves, as of `between`."""
    low, high, first, last = sides
    ends = np.array([0.0, 1.0])
    corner = np.array([low(ends), high(ends)])  # by the second direction, then the first
    middle = corner.mean(axis=(0, 1))
    core = middle + CORE * (corner - middle)
    inner = (
        straight(core[0, 0], core[0, 1]),
        straight(core[1, 0], core[1, 1]),
        straight(core[0, 0], core[1, 0]),
        straight(core[0, 1], core[1, 1]),
    )
    spoke = [[straight(corner[j, i], core[j, i]) for i in (0, 1)] for j in (0, 1)]
    one = np.array([0.0, 0.5, 1.0])
    return [
        between(*inner, u, v),
        between(low, inner[0], spoke[0][0], spoke[0][1], u, one),
        between(high, inner[1], spoke[1][0], spoke[1][1], u, one),
        between(first, inner[2], spoke[0][0], spoke[1][0], v, one),
        between(last, inner[3], spoke[0][1], spoke[1][1], v, one),
    ]
