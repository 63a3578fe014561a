"""Hysteresis: both directions of a sweep, and the path of solutions that joins them.

The path is followed by arc length from the lowest frequency to the highest. Where it turns back
real exponents of perturbations pass zero, one by one: the sign of det P, which is that of the
whole Jacobian, since the stuck structure's part of it is positive, decides whether an odd number of
them is positive. Such a state cannot last. Where none has passed nothing is proved: perturbations
may also grow while they oscillate, or in waves of other nodal diameters, and no count of folds
sees that.
"""

import warnings
from dataclasses import dataclass, field, replace
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.continuation.arc_length import APART, land, locate, polished
from vanelock.nonlinear.continuation.path import (
    SHORTEST,
    PathPoint,
    SolutionPath,
    Tangent,
    tangent_at,
)
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver, Progress
from vanelock.nonlinear.forced_response.options import Options, checked_frequencies
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.newton.newton import Solution, scales
from vanelock.rom.system.system import System

_LONGEST = 1 / 40
"""Longest step of a path with one contact, relative to the range; several add up in quadrature."""
_LIMIT = 4000  # points of a path


_BEND = 3.0
"""Longest way between two points of a path by way of a third one, relative to the straight one."""


@dataclass(frozen=True)
class Hysteresis(Product):
    """Responses up and down a range of frequencies, and the path through its f folds.

    Attributes
    ----------
    up, down : Response
        At the same p frequencies, ascending.
    differ : (p,) bool
        Whether up and down took different branches.
    branch : Response
        The b points of the path in its own order, from the lowest frequency on; folds included.
    passed : (b,) int
        Folds passed on the way to each point of the path.
    unstable : (b,) bool
        Whether an odd number of real exponents is positive, by the sign of the determinant: the
        state cannot last. Where it is false, stability is not proved.
    fold : (f,) int
        Points of the path at which it turns back.
    upper : (f,) bool
        Whether the path turns back from rising to falling frequency: an upward sweep jumps there.
    sharp : (f,) bool
        Whether it turns at a change of a contact's state, with a corner.
    several : (r, 2) float
        Ranges of frequency with more than one solution of the path, Hz.
    complete : bool
        Whether the path arrived at the highest frequency.
    ended : str
        Where the path ended and why, in words; empty where it is complete.
    connected : bool
        Whether the first and the last point of the sweep down lie on the path; if not there are
        solutions that it does not show.
    """

    up: Response
    down: Response
    differ: Booleans
    branch: Response
    passed: Integers
    unstable: Booleans
    fold: Integers
    upper: Booleans
    sharp: Booleans
    several: Floats = field(metadata={"unit": "Hz"})
    complete: bool
    ended: str
    connected: bool


@dataclass(frozen=True)
class _Place:
    """A point of the path; `orientation` is the sign of det P, 0 at a fold."""

    solution: Solution
    orientation: float
    fold: bool = False
    sharp: bool = False


@one_thread
def hysteresis(
    system: System,
    frequencies: ArrayLike | tuple[float, float],
    options: Options = Options(),
    progress: Progress | None = None,
) -> Hysteresis:
    """Sweep a range of frequencies up and down, and follow the path through the folds between.

    Parameters
    ----------
    system : System
    frequencies : (p,) array_like or (float, float)
        Hz. An array or list: where up and down are solved, exactly these; the path goes from the
        lowest to the highest. A tuple (low, high): a range; up and down are solved at the
        frequencies of the path's points.
    options : Options
        All but the direction: both are taken.
    progress : callable, optional
        Called after each point of the path with (points done, points in all, estimated; Hz;
        largest amplitude of any output, m).

    Warns
    -----
    RuntimeWarning
        Where the path ended and why, if it did not arrive at the highest frequency.

    Raises
    ------
    InputError
        As of `frequency_response`, or if a direction is given, the range is empty or nothing
        converges at its beginning.
    """
    if options.direction is not None:
        raise InputError(
            f"direction: given {options.direction!r}: hysteresis is of both ways: leave it out"
        )
    hertz = np.unique(checked_frequencies(frequencies))
    is_range = isinstance(frequencies, tuple)
    if len(hertz) < 2 or (is_range and len(hertz) != 2):
        raise InputError(f"frequencies: given {tuple(hertz)}: needs (low, high) or several")
    ready = options.prepare(system, hertz, 1000)
    solver = ready.solver
    low, high = TURN * hertz[[0, -1]]
    begun = solver.point(float(low), [])
    if not begun.converged:
        raise InputError(f"frequencies: no solution was found at {hertz[0]:g} Hz to start from")
    places, reason = _followed(solver, begun, float(high), progress)
    omegas = TURN * hertz
    if is_range:
        between = [p.solution.omega for p in places if low < p.solution.omega < high]
        omegas = np.unique([low, *between, high])
    up = list(solver.sweep(omegas))
    down = list(solver.sweep(omegas[::-1]))[::-1]
    weight = 1 / scales(solver.family.at(float(low)).linear)

    def same(one: Solution, other: Solution) -> bool:
        largest = max(float(np.abs(each.u * weight).max(initial=0.0)) for each in (one, other))
        apart = np.abs((one.u - other.u) * weight)[..., 1:]
        return bool(apart.max(initial=0.0) <= APART * max(largest, 1.0))

    if not places:
        raise InputError("frequencies: the path cannot be followed from the lowest one")
    ended = ""
    if reason:
        reached = f"{places[-1].solution.omega / TURN:g} Hz of {hertz[0]:g} ... {hertz[-1]:g}"
        ended = f"the path ended at {reached}, after {len(places)} points: {reason}"
        warnings.warn(f"hysteresis: {ended}", RuntimeWarning, stacklevel=5)
    ends = same(down[0], places[0].solution) and same(down[-1], places[-1].solution)
    turning = np.array([i for i, place in enumerate(places) if place.fold], np.int64)
    branch = ready.response([place.solution for place in places])
    path_hertz = branch.frequency
    return Hysteresis(
        up=ready.response(up),
        down=ready.response(down),
        differ=np.array([not same(*each) for each in zip(up, down, strict=True)], bool),
        branch=branch,
        passed=np.cumsum([place.fold for place in places]).astype(np.int64),
        unstable=np.array([place.orientation < 0 for place in places], bool),
        fold=turning,
        upper=np.array([path_hertz[i] >= path_hertz[i - 1] for i in turning], bool),
        sharp=np.array([places[i].sharp for i in turning], bool),
        several=_several_ranges(path_hertz),
        complete=not ended,
        ended=ended,
        connected=bool(not ended and ends),
    )


def _several_ranges(frequency: Floats) -> Floats:
    """(r, 2) ranges that a path passes more than once, from the frequencies along it."""
    steps = np.diff(frequency)
    back = np.flatnonzero(steps < 0)
    pieces = sorted((float(frequency[i + 1]), float(frequency[i])) for i in back)
    merged: list[list[float]] = []
    for begin, end in pieces:
        if merged and begin <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            merged.append([begin, end])
    return np.array(merged).reshape(-1, 2)


def _followed(
    solver: PointSolver, begun: Solution, end: float, progress: Progress | None
) -> tuple[list[_Place], str]:
    """Points of the path until it passes `end`, folds among them; and why it did not, if so."""
    family, tolerance = solver.family, solver.tolerance
    span = end - begun.omega
    scale = 1 / scales(family.at(begun.omega).linear)

    def turning(solution: Solution, tangent: Tangent) -> float:
        """dω/ds but for a positive factor, s in the direction of det P > 0."""
        return float(tangent.orientation / np.hypot(np.linalg.norm(tangent.z * scale) * span, 1.0))

    places: list[_Place] = []
    before: PathPoint | None = None
    for step in SolutionPath(family, begun, end, _LONGEST * sqrt(len(begun.w))):
        reached = step.solution
        if before is not None and step.rate * before.rate < 0:
            values = turning(before.solution, before.tangent), turning(reached, step.tangent)
            located = locate(family, before, step, turning, values, tolerance)
            if located is not None:
                fold = _Place(located.solution, 0.0, True, located.left > 1e-3)
            else:  # the further of the two stands for it, not converged
                ends, way = (before.solution, reached), np.sign(before.rate)
                outer = max(ends, key=lambda end: way * end.parameter)
                fold = _Place(replace(outer, converged=False), 0.0, True)
            if (fold.solution.parameter - end) * span >= 0:
                reached = fold.solution  # it turns beyond the end
            else:
                places.append(fold)
        if (reached.parameter - end) * span >= 0 and before is not None:
            landed = land(family, before.solution, reached, end, tolerance, _BEND)
            if not landed.converged:
                return places, "it goes on, but no solution was found at the highest frequency"
            tangent = tangent_at(family, landed)
            return [*places, _Place(landed, tangent.orientation if tangent else 0.0)], ""
        exact = polished(family, step, tolerance)
        total = replace(exact, iterations=exact.iterations + step.solution.iterations)
        places.append(_Place(total, step.tangent.orientation))
        before = step
        if progress is not None:
            share = (exact.omega - begun.omega) / span
            expected = max(len(places) + 1, round(len(places) / max(share, 0.01)))
            size = float(solver.amplitude(exact).max(initial=0.0))
            progress(len(places), expected, exact.omega / TURN, size)
        if len(places) >= _LIMIT:
            return places, f"it goes on, but {_LIMIT} points are the most"
        if (exact.omega - begun.omega) / span < -0.1:
            return places, "it goes back below the lowest frequency by a tenth of the range"
    return places, f"no next point was found, not even {SHORTEST:.1%} of the amplitude further on"
