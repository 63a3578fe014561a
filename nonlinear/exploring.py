"""A range of frequencies, sampled as its curve needs it.

The range is swept upwards in long steps. Beside a jump, the larger solution may go on: it is
followed to its end, downwards and upwards, and where two exist, the curve takes the larger one.
Neighbours differ by no more than two harmonics. Points are then added where the curve between them
is uncertain, and at its highest place until that is where the curve says; the highest maxima are
then compared with more harmonics.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.estimates import BEYOND
from vanelock.nonlinear.hermite import HIGH, RIVAL, Curve
from vanelock.nonlinear.pointwise import TINY, Point, Pointwise

Floats = NDArray[np.float64]

BEND = 0.4
"""How far, relatively, a step of the sweep may leave the line through the last two points."""
JUMP = 400
"""Parts of the range: how closely a jump of the response is located."""
WIDEST = 48
"""Parts of the range: how far apart points may be where the curve is high."""
CROWD = 200
"""Points of a curve beyond which none is added; of the second half, the high ones come first."""
ROUNDS = 20
PEAK = 0.8
"""Of the largest amplitude, above which a point belongs to the peak."""
OTHER = 0.04
"""Relative distance of an amplitude from the line through a neighbour that tells of a jump."""


class Told(Protocol):
    """Is told about each point and how many there may be in all."""

    def __call__(self, point: Point, expected: int) -> None:
        """Tell."""


@dataclass
class Exploring:
    """Chooses the frequencies of a range.

    Attributes
    ----------
    pointwise : Pointwise
        Solves them.
    low, high : float
        The range, rad/s.
    told : callable
        Told of each point.
    """

    pointwise: Pointwise
    low: float
    high: float
    told: Told

    @property
    def closest(self) -> float:
        """Distance of neighbours below which none is put between them, rad/s."""
        return (self.high - self.low) / JUMP

    def curve(self) -> list[Point]:
        """The points of the curve, ascending; the last ones tried where some did not converge."""
        first = self.pointwise.point(self.low, [])
        points = [first, *self._swept(first, self.high)]
        points = self._graded(self._upper(points))
        for _ in range(ROUNDS):
            curve, share = self._drawn(points), self.pointwise.shares.frequencies
            wanted = curve.wanted(share, self.closest, (self.high - self.low) / WIDEST)
            if len(points) + len(wanted) > CROWD / 2:
                wanted = _highest(curve, wanted, max(CROWD - len(points), 0))
            for omega in wanted:
                points = self._with(points, float(omega))
            if not len(wanted):
                before = points
                points = settled(self.pointwise, points)
                if [p.harmonics for p in points] == [p.harmonics for p in before]:
                    break
            points = self._graded(points)
        return points

    def _drawn(self, points: Sequence[Point]) -> Curve:
        known = [p for p in points if p.estimate is not None]
        numbers = np.array([(p.omega, p.amplitude, p.slope) for p in known]).reshape(-1, 3)
        return Curve(*numbers.T)

    def _swept(self, first: Point, end: float, jumps: bool = True) -> Iterator[Point]:
        """From a point to a frequency in steps over which the amplitude stays near the line.

        Unless it may jump, it ends where the branch does.
        """
        span, sign = self.high - self.low, float(np.sign(end - first.omega))
        system = self.pointwise.ladder.structure(self.pointwise.least).system
        finest = max((system.damping_ratio or 0.0) * self.low / 10, span / 2000)
        history, step = [first], span / 30
        while history[-1].omega != end:
            last = history[-1]
            left = abs(end - last.omega)
            omega = end if step >= 0.999 * left else last.omega + sign * step
            known = [p for p in history if p.solution.converged]
            easy = self.pointwise.easily(omega, known)
            if easy is None and known and step > max(finest, self.closest):
                step = max(self.closest, finest, 0.3 * step)
                continue
            if easy is None and not jumps:
                return
            point = self.pointwise.point(omega, known, easy)
            if not jumps and _jumps(last, point):
                if step <= max(finest, self.closest):
                    return
                step = max(self.closest, finest, 0.3 * step)
                continue
            error = 0.0 if easy is None and known else _bend(history, point)
            if error > BEND and step > finest:
                step = max(finest, step * max(0.3, 0.8 * np.sqrt(BEND / error)))
                continue
            yield point
            self.told(point, round(span / max(abs(omega - first.omega), 1e-9 * span)))
            history = [*history, point][-2:]
            growth = 0.9 * np.sqrt(BEND / max(error, 1e-12))
            step = float(np.clip(step * min(2.0, growth), finest, span / 12))

    def _upper(self, points: list[Point]) -> list[Point]:
        """The larger solutions beside every jump put in place of the smaller ones."""
        for end in (self.low, self.high):
            points = self._followed(points, end)
        return points

    def _followed(self, points: list[Point], end: float) -> list[Point]:
        """Branches that jump down towards one end of the range followed as far as they go."""
        ahead = points if end > points[0].omega else points[::-1]
        i = 0
        while i < len(ahead) - 1:
            here, next_one = ahead[i], ahead[i + 1]
            if _jumps(here, next_one) and here.amplitude > next_one.amplitude:
                beyond, branch = ahead[i + 1 :], []
                curve = self._drawn(sorted(beyond, key=lambda p: p.omega))
                for point in self._swept(here, end, jumps=False):
                    if point.amplitude < (1 + OTHER) * curve.at(np.array([point.omega]))[0]:
                        break
                    branch.append(point)
                if branch:
                    last = abs(branch[-1].omega - here.omega)
                    beyond = [p for p in beyond if abs(p.omega - here.omega) > last]
                    ahead = [*ahead[: i + 1], *branch, *beyond]
                    i += len(branch)
            i += 1
        return sorted(ahead, key=lambda p: p.omega)

    def _graded(self, points: list[Point]) -> list[Point]:
        """Neighbours made to differ by two harmonics at most, by none at the peak and at jumps."""
        if not self.pointwise.chooses_harmonics:
            return points
        points = list(points)
        order = [*range(len(points)), *reversed(range(len(points)))]
        top = max(points, key=lambda p: p.amplitude)
        for i in order:
            beside = [points[j] for j in (i - 1, i + 1) if 0 <= j < len(points)]
            least = max((p.harmonics for p in beside), default=0) - BEYOND
            jumps = [p.harmonics for p in beside if _jumps(points[i], p)]
            least = max([least, *jumps])  # perhaps no jump, but a harmonic too few
            if points[i].amplitude > PEAK * top.amplitude:
                least = max(least, top.harmonics)
            if points[i].harmonics < least and points[i].solution.converged:
                known = [p for p in beside[-1:] if p.solution.converged]
                again = self.pointwise.point(points[i].omega, [*known, points[i]], None, least)
                if again.solution.converged:
                    points[i] = again
        return points

    def _with(self, points: list[Point], omega: float) -> list[Point]:
        """The points with one more, reached from its neighbours, the larger where they differ."""
        place = int(np.searchsorted([p.omega for p in points], omega))
        beside = [p for p in points[max(place - 1, 0) : place + 1] if p.solution.converged]
        beside.sort(key=lambda p: -abs(p.omega - omega))
        point = self.pointwise.point(omega, beside)
        if len(beside) == 2 and any(_jumps(p, point) for p in beside):
            for other in beside:
                if (easy := self.pointwise.easily(omega, [other])) is not None:
                    tried = self.pointwise.point(omega, [other], easy)
                    point = max(point, tried, key=lambda p: p.amplitude)
        self.told(point, len(points) + 2)
        return [*points[:place], point, *points[place:]]


def settled(pointwise: Pointwise, points: Sequence[Point]) -> list[Point]:
    """Points with the errors of the highest maxima measured rather than estimated."""
    found = list(points)
    sizes = np.array([-np.inf, *(point.amplitude for point in points), -np.inf])
    inner = sizes[1:-1]
    maxima = (inner >= sizes[:-2]) & (inner >= sizes[2:]) & (inner >= RIVAL * inner.max())
    for i in np.flatnonzero(maxima):
        found[i] = pointwise.settled(found[i])
    return found


def _highest(curve: Curve, wanted: Floats, most: int) -> Floats:
    """Of some places, those where the curve is high or, where there are none, any; some at most."""
    heights = curve.at(wanted)
    high = heights > HIGH * curve.y.max()
    order = np.argsort(-heights)[: min(most, high.sum() or most)]
    return np.sort(wanted[order])


def _bend(history: Sequence[Point], point: Point) -> float:
    """Relative distance of a new amplitude from the line through the last two."""
    if len(history) < 2:
        return 0.0
    a, b = history
    line = b.amplitude + (b.amplitude - a.amplitude) * (point.omega - b.omega) / (b.omega - a.omega)
    return abs(point.amplitude - line) / max(b.amplitude, TINY)


def _jumps(a: Point, b: Point) -> bool:
    """Whether two neighbours may lie on different branches, by their tangents."""
    if not (np.isfinite(a.slope) and np.isfinite(b.slope)):
        return True
    distance = b.omega - a.omega
    mean = 0.5 * (a.slope + b.slope) * distance
    return abs(b.amplitude - a.amplitude - mean) > OTHER * max(a.amplitude, b.amplitude)
