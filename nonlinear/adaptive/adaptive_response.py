"""The forced response to an accuracy: harmonics chosen point by point, frequencies by the curve.

Every point starts from one harmonic or from what its neighbour needed, is judged
(`error_estimates`), and is solved again with more until the estimated error is within its share
(`points`). Frequencies of a range are chosen by the curve itself (`sampling`).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.nonlinear.adaptive.error_estimates import SOURCES, Estimator
from vanelock.nonlinear.adaptive.harmonic_levels import HarmonicLevels
from vanelock.nonlinear.adaptive.points import Point, Pointwise, Shares
from vanelock.nonlinear.adaptive.sampling import (
    UNBOUND,
    Exploring,
    places_of_jumps,
    with_measured_maxima,
)
from vanelock.nonlinear.forced_response.frequency_sweep import PointsDone, PointStore, Progress
from vanelock.nonlinear.forced_response.linear_response import check_bound, check_top
from vanelock.nonlinear.forced_response.options import (
    Options,
    check_band,
    check_forces,
    checked_frequencies,
    checked_range,
    excited,
)
from vanelock.nonlinear.forced_response.response import ErrorEstimates, Response
from vanelock.nonlinear.fourier import TURN, one_thread, resized
from vanelock.rom.errors import Neglected
from vanelock.rom.system.system import System

_FEWEST = 128  # samples of a period to begin with, where the law is sampled


@one_thread
def adaptive_response(
    systems: Callable[[int], System],
    frequencies: ArrayLike | tuple[float, float],
    shares: Shares,
    options: Options = Options(),
    monitor: tuple[int, int] | None = None,
    neglected: Callable[[int], Neglected] | None = None,
    mesh_error: Callable[[int, Floats], Floats] | None = None,
    progress: Progress | None = None,
    store: PointStore | None = None,
) -> Response:
    """Steady vibration with friction, as exact as asked for at one output.

    Parameters
    ----------
    systems : callable
        From H to a system that has the nodal diameters of the harmonics 0 to H and of all forces;
        called with growing H, when a point needs them. Diameters that it had before stay as they
        were.
    frequencies : (p,) array_like or (float, float)
        Hz. An array or list: exactly these. A tuple (low, high): a range, sampled as the curve
        needs it.
    shares : Shares
        What the errors may be.
    options : Options
        Harmonics that are given are those of every point, instead of being chosen. Frequencies are
        passed both ways, and the largest solution counts, unless a direction is given. All modes
        count in full: what `static_beyond` leaves out is not among the errors that are estimated.
    monitor : (int, int), optional
        Output node and direction, by their places in the system; by default those of the largest
        linear response with all contacts stuck.
    neglected, mesh_error : callable, optional
        What else is estimated, see `nonlinear.estimates`: `rom.neglected_forms` by nodal diameter;
        relative errors (n,) of natural frequencies (n,) in Hz by a nodal diameter and these.
    progress, store : optional
        As of `frequency_response`.

    Returns
    -------
    Response
        With as many harmonics as the most demanding point, `estimates` included. Estimates that
        stay above their shares say so there.

    Raises
    ------
    InputError
        If a share or a frequency is not positive, `static_beyond` is given, there is no output, or
        no largest amplitude is found in a range and nothing but friction damps.
    """
    if options.static_beyond is not None:
        raise InputError(
            f"static_beyond: given {options.static_beyond}: adaptive_response does not estimate "
            "what that leaves out: leave it out"
        )
    harmonics = options.harmonics
    for name in ("harmonics", "frequencies"):
        share = getattr(shares, name)
        if not 0 < share < 1:
            raise InputError(f"shares.{name}: given {share}: allowed are numbers between 0 and 1")
    is_range = isinstance(frequencies, tuple)
    hertz = (checked_range if is_range else checked_frequencies)(frequencies)
    omegas = TURN * hertz
    limits = float(omegas.min()), float(omegas.max())
    reporter = PointsDone(progress)
    levels = HarmonicLevels(systems, limits, options, reporter.searching, store)
    first = levels.structure(harmonics or 1)
    if harmonics is None:
        first = levels.structure(max([1, *excited(first.system)]))
    else:
        check_forces(first.system, harmonics)
    check_band(first.system, hertz)
    if not first.system.output_names:
        raise InputError("system: has no output nodes: their amplitude is what an error is of")
    monitored = _loudest(levels, first.harmonics, omegas) if monitor is None else monitor
    left_out = None if neglected is None else lru_cache(None)(neglected)
    estimator = Estimator(levels, monitored, left_out, mesh_error)
    pointwise = Pointwise(estimator, shares, first.harmonics, chooses_harmonics=harmonics is None)
    if is_range:
        check_bound(first, limits, monitored, UNBOUND)
        found = Exploring(pointwise, omegas[0], omegas[1], reporter, options.direction).curve()
        order = np.arange(len(found))[:: -1 if options.direction == "down" else 1]
        jumps = order[places_of_jumps(pointwise, [found[i] for i in order])]
        direction = options.direction or "both"
    else:
        found, jumps, direction = _swept(pointwise, omegas, reporter, options.direction)
    response = _assembled(levels, found, monitored, direction=direction, jump=jumps)
    if is_range and options.direction is None:
        check_top(first, response, monitored, UNBOUND)
    return response


def _swept(
    pointwise: Pointwise, omegas: Floats, reporter: PointsDone, direction: str | None
) -> tuple[list[Point], Integers, str]:
    """Exactly these frequencies, in the order given; their jumps; and how they were swept.

    Without a direction they are swept upwards and, where that jumps or loses a point, back
    downwards; of two solutions at a frequency, the larger counts.
    """
    order = np.argsort(omegas, kind="stable")
    if direction == "down":
        order = order[::-1]
    taken = direction or "up"
    found = _passed(pointwise, omegas[order], reporter)
    jumps = places_of_jumps(pointwise, found)
    lost = not all(point.solution.converged for point in found)
    if direction is None and (len(jumps) or lost):
        down = _passed(pointwise, omegas[order[::-1]], reporter, found[-1:])[::-1]
        pairs = zip(found, down, strict=True)
        found = [max(pair, key=lambda point: point.amplitude) for pair in pairs]
        jumps, taken = places_of_jumps(pointwise, found), "both"
    found = with_measured_maxima(pointwise, found)
    return [found[i] for i in np.argsort(order)], order[jumps], taken


def _passed(
    pointwise: Pointwise, omegas: Floats, progress: PointsDone, before: Sequence[Point] = ()
) -> list[Point]:
    """Points at these frequencies, one after another; the first from what is known before."""
    found: list[Point] = []
    history = [point for point in before if point.solution.converged]
    for omega in omegas:
        point = pointwise.point(float(omega), history)
        found.append(point)
        progress(point.omega, point.amplitude, len(omegas))
        if point.solution.converged:
            history = [*history, point][-2:]
    return found


def _loudest(levels: HarmonicLevels, harmonics: int, omegas: Floats) -> tuple[int, int]:
    """Node and direction of the largest linear response, all contacts stuck."""
    prepared = levels.structure(harmonics)
    still = np.zeros_like(prepared.balance(float(omegas[0])).linear)
    sizes = [
        np.abs(prepared.output(prepared.amplitudes(omega, still))[1:]).max(axis=0)
        for omega in np.linspace(omegas.min(), omegas.max(), 41)
    ]
    node, direction = np.unravel_index(np.argmax(np.max(sizes, axis=0)), sizes[0].shape)
    return int(node), int(direction)


def _assembled(
    levels: HarmonicLevels, points: Sequence[Point], monitored: tuple[int, int], **more: Any
) -> Response:
    """All points as one response with the largest number of harmonics among them."""
    H = max(point.harmonics for point in points)
    found = (point.solution for point in points)
    solutions = [replace(each, w=resized(each.w, H), u=resized(each.u, H)) for each in found]
    lost = np.full(len(SOURCES), np.nan)
    estimates = ErrorEstimates(
        sources=SOURCES,
        change=np.array([point.estimate.change if point.estimate else lost for point in points]),
        slope=np.array([point.slope for point in points]) * TURN,
        amplitude=np.array([point.amplitude for point in points]),
        harmonics=np.array([point.harmonics for point in points]),
        monitored=np.array(monitored),
        tried=levels.reached,
    )
    return levels.ready(H).response(solutions, estimates=estimates, **more)
