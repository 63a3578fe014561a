"""A range of frequencies, sampled as its curve needs it.

The range is swept upwards and back downwards in long steps. Beside a jump, a solution may go on: it
is followed to its end, downwards and upwards, and where several exist, the curve takes the largest.
Neighbours differ by no more than two harmonics. Points are then added where the curve between them
is uncertain, and at its highest place until that is where the curve says; the highest maxima are
then compared with more harmonics.

Where the shortest step does not stay on a curve, a change of the number of harmonics may have led
from one branch to another: the branch with more of them may end sooner, or lie further off than
Newton's iteration reaches. Then the range is swept once more both ways, finely and with the same
number all the way. Wherever that comes out above the curve, the highest point is solved as exactly
as asked for, and its branch followed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.nonlinear.adaptive.error_estimates import BEYOND
from vanelock.nonlinear.adaptive.interpolant import HIGH, SIMILAR, Interpolant
from vanelock.nonlinear.adaptive.points import TINY, Point, Pointwise
from vanelock.nonlinear.forced_response.frequency_sweep import PointsDone, StepControl
from vanelock.nonlinear.forced_response.linear_response import check_bound

_OTHER = 0.04
"""Relative distance of an amplitude from the line through a neighbour that suggests a jump."""
_BEND = 0.4
"""How far, relatively, a step of the sweep may leave the line through the last two points."""
_COARSE = 2.0  # how many times longer the steps of the second sweep are where the first met no jump
_JUMP = 400  # parts of the range: how closely a jump of the response is located
_WIDEST = 48  # parts of the range: how far apart points may be where the curve is high
_BANDS = 2  # half-power bandwidths of the structure: how far apart they may be there at most
_CROWD = 200
"""Points of a curve beyond which none is added; of the second half, the high ones come first."""
_ROUNDS = 20
_STEADY = 5  # harmonics of sweeps that take the same number all the way, if all points need no more
_FINE = 0.4  # how many times longer their steps are than those of the first sweep
_PEAK = 0.8  # of the largest amplitude, above which a point belongs to the peak
UNBOUND = "frequencies: no largest amplitude was found in them"
"""What is said of a range whose curve has none."""


def _bend(history: Sequence[Point], point: Point) -> float:
    """Relative distance of a new amplitude from the line through the last two."""
    if len(history) < 2:
        return 0.0
    a, b = history
    line = b.amplitude + (b.amplitude - a.amplitude) * (point.omega - b.omega) / (b.omega - a.omega)
    return abs(point.amplitude - line) / max(b.amplitude, TINY)


def _may_jump(a: Point, b: Point) -> bool:
    """Whether two neighbours may lie on different branches, by their tangents."""
    if not (np.isfinite(a.slope) and np.isfinite(b.slope)):
        return True
    distance = b.omega - a.omega
    mean = 0.5 * (a.slope + b.slope) * distance
    return abs(b.amplitude - a.amplitude - mean) > _OTHER * max(a.amplitude, b.amplitude)


def places_of_jumps(pointwise: Pointwise, points: Sequence[Point]) -> Integers:
    """(j, 2) places of neighbours that no curve joins, among points of ascending frequency."""
    solved = [i for i, p in enumerate(points) if p.solution.converged]
    found = [
        (i, j)
        for i, j in pairwise(solved)
        if _may_jump(points[i], points[j]) and not pointwise.joined(points[i], points[j])
    ]
    return np.array(found, np.int64).reshape(-1, 2)


def with_measured_maxima(pointwise: Pointwise, points: Sequence[Point]) -> list[Point]:
    """Points with the errors of the highest maxima measured rather than estimated."""
    found = list(points)
    sizes = np.array([-np.inf, *(point.amplitude for point in points), -np.inf])
    inner = sizes[1:-1]
    maxima = (inner >= sizes[:-2]) & (inner >= sizes[2:]) & (inner >= SIMILAR * inner.max())
    for i in np.flatnonzero(maxima):
        found[i] = pointwise.with_measured_error(found[i])
    return found


@dataclass
class Exploring:
    """Chooses the frequencies of a range, rad/s, swept one way if `direction` says which.

    `left` are jumps and the ends of the range towards which a branch was followed from there;
    `broken` is whether a sweep came where its shortest step did not stay on a curve.
    """

    pointwise: Pointwise
    low: float
    high: float
    progress: PointsDone
    direction: str | None = None
    left: set[tuple[float, float]] = field(default_factory=set)
    broken: bool = False

    @property
    def closest(self) -> float:
        """Distance of neighbours below which none is put between them, rad/s."""
        return (self.high - self.low) / _JUMP

    @property
    def damping_ratio(self) -> float:
        """Of the structure with all contacts stuck; 0 where it has damping of its own."""
        return self.pointwise.levels.structure(self.pointwise.least).system.damping_ratio or 0.0

    @property
    def widest(self) -> float:
        """Distance of neighbours where the curve is high: a peak may hide in more, rad/s."""
        apart = (self.high - self.low) / _WIDEST
        band = 2 * self.damping_ratio * self.low
        return min(apart, max(_BANDS * band, self.closest)) if band else apart

    def curve(self) -> list[Point]:
        """The points of the curve, ascending; the last ones tried where some did not converge."""
        points = self._graded(self._begun())
        for _ in range(_ROUNDS):
            curve, share = self._drawn(points), self.pointwise.shares.frequencies
            lost = [p.omega for p in points if p.estimate is None]
            missed = np.pad(curve.maxima(share)[1], 1)  # none beyond the ends
            if missed[np.searchsorted(curve.x, lost)].any():
                self._refuse_unbound(curve)
            wanted = curve.wanted(share, self.closest, self.widest)
            wanted = wanted[~np.isin(wanted, lost)]
            if len(points) + len(wanted) > _CROWD / 2:
                wanted = _highest(curve, wanted, max(_CROWD - len(points), 0))
            for omega in wanted:
                points = self._with(points, float(omega))
            if not len(wanted):
                before = points
                points = with_measured_maxima(self.pointwise, points)
                if [p.harmonics for p in points] == [p.harmonics for p in before]:
                    count = len(self.left)
                    points = self._upper(points)
                    if len(self.left) == count:
                        break
            points = self._graded(points)
        else:
            self._refuse_unbound(self._drawn(points))
        return points

    def _refuse_unbound(self, curve: Interpolant) -> None:
        """Say of a curve that no top was found of it, if nothing but friction may bound one."""
        structure = self.pointwise.levels.structure(self.pointwise.least)
        monitored, top = self.pointwise.estimator.monitored, float(curve.x[curve.y.argmax()])
        check_bound(structure, (self.low, self.high), monitored, UNBOUND, top)

    def _begun(self) -> list[Point]:
        """Points of the sweeps."""
        if self.direction is not None:
            ends = (self.low, self.high)[:: -1 if self.direction == "down" else 1]
            first = self.pointwise.point(ends[0], [])
            return sorted([first, *self._swept(first, ends[1])], key=lambda p: p.omega)
        first = self.pointwise.point(self.low, [])
        points = [first, *self._swept(first, self.high)]
        coarse = 1.0 if self.broken else _COARSE
        back = self._swept(points[-1], self.low, coarse=coarse)
        points = self._merged(points, [points[-1], *back][::-1])
        points = self._upper(points)
        if self.broken and self.pointwise.chooses_harmonics:
            points = self._steadily(points)
        return points

    def _drawn(self, points: Sequence[Point]) -> Interpolant:
        known = [p for p in points if p.estimate is not None]
        numbers = np.array([(p.omega, p.amplitude, p.slope) for p in known]).reshape(-1, 3)
        return Interpolant(*numbers.T)

    def _swept(
        self, begin: Point, end: float, jumps: bool = True, coarse: float = 1.0
    ) -> Iterator[Point]:
        """From a point to a frequency in steps over which the amplitude stays near the line.

        Unless it may jump, it ends where the branch does. Coarse ones are so many times longer.
        """
        allowed, span = _BEND * coarse**2, self.high - self.low
        finest = coarse * max(self.damping_ratio * self.low / 10, span / 2000)
        longest = coarse * span / 12
        steps = StepControl(begin.omega, end, coarse * span / 30, finest, longest, (0.3, 2.0))
        history, closest = [begin], max(finest, self.closest)
        while steps.here != end:
            last, omega = history[-1], steps.ahead
            known = [p for p in history if p.solution.converged]
            easy = self.pointwise.easily(omega, known)
            if easy is None and known and steps.shortened(closest, closest):
                continue
            if easy is None and not jumps:
                return
            point = self.pointwise.point(omega, known, easy)
            if not jumps and _may_jump(last, point):
                if not steps.shortened(closest, closest):
                    return
                continue
            error = 0.0 if easy is None and known else _bend(history, point) / allowed
            if not steps.taken(omega, error):
                continue
            self.broken |= error > 1.0 or (easy is None and bool(known))
            yield point
            expected = round(span / max(abs(omega - begin.omega), 1e-9 * span))
            self.progress(point.omega, point.amplitude, expected)
            history = [*history, point][-2:]

    def _merged(self, one: list[Point], other: list[Point]) -> list[Point]:
        """The larger solutions of two sweeps, both ascending; of equal ones, one at a place."""
        kept = [p for p in one if not self._below(p, other)]
        for p in other:
            apart = min((abs(p.omega - each.omega) for each in kept), default=np.inf)
            if (apart > self.closest or self._above([p], one)[0]) and not self._below(p, one):
                kept.append(p)
        return sorted(kept, key=lambda p: p.omega)

    def _below(self, point: Point, others: list[Point]) -> bool:
        """Whether other points surely go above one: on either side, and no jump between them."""
        place = int(np.searchsorted([p.omega for p in others], point.omega, side="right"))
        if not 0 < place < len(others):
            return False
        beside = others[place - 1 : place + 1]
        if not all(p.solution.converged for p in beside) or _may_jump(beside[0], beside[-1]):
            return False
        height = self._drawn(beside).at(np.array([point.omega]))[0]
        return bool(height > (1 + _OTHER) * point.amplitude)

    def _steadily(self, points: list[Point]) -> list[Point]:
        """Larger solutions that sweeps with the same number of harmonics all the way lead to."""
        steady = replace(self, pointwise=self.pointwise.with_harmonics(_STEADY), left=set())
        first = steady.pointwise.point(self.low, [])
        up = [first, *steady._swept(first, self.high, coarse=_FINE)]
        down = [up[-1], *steady._swept(up[-1], self.low, coarse=_FINE)]
        for sweep in (up, down[::-1]):
            for top in self._tops(sweep, points):
                begun = self.pointwise.point(top.omega, [top])
                if self._above([begun], points)[0]:
                    branch = [*self._swept(begun, self.low, jumps=False)][::-1]
                    branch += [begun, *self._swept(begun, self.high, jumps=False)]
                    points = self._merged(points, branch)
        return points

    def _above(self, ones: Sequence[Point], points: Sequence[Point]) -> Booleans:
        """Which of some points lie surely above the curve through others."""
        heights = self._drawn(points).at(np.array([p.omega for p in ones]))
        return np.array([p.amplitude for p in ones]) > (1 + _OTHER) * heights

    def _tops(self, sweep: Sequence[Point], points: Sequence[Point]) -> list[Point]:
        """The highest point of each stretch of a sweep that lies above the curve."""
        places = np.flatnonzero(self._above(sweep, points))
        stretches = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
        each = ([sweep[i] for i in stretch] for stretch in stretches if len(stretch))
        return [max(stretch, key=lambda p: p.amplitude) for stretch in each]

    def _upper(self, points: list[Point]) -> list[Point]:
        """The larger solutions beside every jump put in place of the smaller ones."""
        if self.direction is not None:
            return points
        for end in (self.low, self.high):
            points = self._followed(points, end)
        return points

    def _followed(self, points: list[Point], end: float) -> list[Point]:
        """Branches that jump towards one end of the range followed as far as they go.

        One below the curve may come out above it later. One that meets the curve is the curve.
        """
        ahead = points if end > points[0].omega else points[::-1]
        i = 0
        while i < len(ahead) - 1:
            here, next_one = ahead[i], ahead[i + 1]
            i += 1
            if not _may_jump(here, next_one) or (here.omega, end) in self.left:
                continue
            self.left.add((here.omega, end))
            beyond = ahead[i:]
            curve = self._drawn(sorted(beyond, key=lambda p: p.omega))
            branch: list[Point] = []
            for point in self._swept(here, end, jumps=False):
                height = curve.at(np.array([point.omega]))[0]
                if abs(point.amplitude - height) <= _OTHER * height:
                    break
                if point.amplitude > height:
                    branch.append(point)
                elif branch:
                    break
            if branch:
                first, last = (abs(branch[k].omega - here.omega) for k in (0, -1))
                before = [p for p in beyond if abs(p.omega - here.omega) < first]
                beyond = [p for p in beyond if abs(p.omega - here.omega) > last]
                ahead = [*ahead[:i], *before, *branch, *beyond]
                i += len(before) + len(branch) - 1
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
            jumps = [p.harmonics for p in beside if _may_jump(points[i], p)]
            least = max([least, *jumps])  # perhaps no jump, but a harmonic too few
            if points[i].amplitude > _PEAK * top.amplitude:
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
        before, after = (1, 1) if self.direction is None else (2, 0)
        if self.direction == "down":
            before, after = after, before
        beside = points[max(place - before, 0) : place + after]
        beside = sorted(
            (p for p in beside if p.solution.converged), key=lambda p: -abs(p.omega - omega)
        )
        point = self.pointwise.point(omega, beside)
        if self.direction is None and len(beside) == 2 and any(_may_jump(p, point) for p in beside):
            for other in beside:
                if (easy := self.pointwise.easily(omega, [other])) is not None:
                    tried = self.pointwise.point(omega, [other], easy)
                    point = max(point, tried, key=lambda p: p.amplitude)
        self.progress(point.omega, point.amplitude, len(points) + 2)
        return [*points[:place], point, *points[place:]]


def _highest(curve: Interpolant, omegas: Floats, most: int) -> Floats:
    """Of some places, those where the curve is high or, where there are none, any; some at most."""
    heights = curve.at(omegas)
    high = heights > HIGH * curve.y.max()
    order = np.argsort(-heights)[: min(most, high.sum() or most)]
    return np.sort(omegas[order])
