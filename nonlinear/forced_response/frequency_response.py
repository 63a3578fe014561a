"""Forced response of a system with friction contacts, and its state at rest.

Jumps: neighbours of a sweep that no curve of solutions joins.

Where a branch of solutions ends in a fold, a sweep goes on with another branch. Two neighbours are
suspected where the solver did not get from the one to the other without turning back, or where
neither lies on the line through the two points on the other's side. They jump unless the path of
solutions that begins at one of them leads to the other and nowhere turns back.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Floats, Integers
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.forced_response.frequency_sweep import (
    PointsDone,
    PointSolver,
    PointStore,
    Progress,
)
from vanelock.nonlinear.forced_response.options import Options, checked_frequencies, checked_range
from vanelock.nonlinear.forced_response.response import Response, assemble_response
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.newton.newton import Solution, scales
from vanelock.rom.system.system import System

_STRAIGHT = 0.1  # of the larger motion, how far a point may lie from a line, or two points apart
_SAME = 1e-4  # of the larger motion, the difference of two states beyond which they are two
_POINTS, _EFFORT = 60, 300  # points of the path between two neighbours, and Newton steps, at most


def _jumps(solver: PointSolver, swept: Sequence[Solution]) -> Integers:
    """(j, 2) places of the points before and after each jump."""
    solved = [i for i, each in enumerate(swept) if each.converged]
    found = []
    for k in range(len(solved) - 1):
        around = [swept[i] for i in solved[max(k - 1, 0) : k + 3]]
        a, b = swept[solved[k]], swept[solved[k + 1]]
        before = around[0] if k > 0 else None
        after = around[-1] if k + 2 < len(solved) else None
        lost = solved[k + 1] > solved[k] + 1
        smooth = b.continued and not lost and _straight(before, a, b, after)
        if not smooth and not joined(solver, a, b):
            found.append((solved[k], solved[k + 1]))
    return np.array(found, np.int64).reshape(-1, 2)


def joined(solver: PointSolver, a: Solution, b: Solution) -> bool:
    """Whether the path of solutions leads from one to the other and nowhere turns back."""
    weight = 1 / scales(solver.family.at(a.omega).linear)
    for start, end in ((a, b), (b, a)):
        arc = follow(
            solver.family, start, end.omega, solver.tolerance, _POINTS, effort=_EFFORT, away=0.0
        )
        if arc.solution is None or arc.folds:
            continue
        apart = np.abs((arc.solution.u - end.u) * weight).max(initial=0.0)
        return bool(apart <= _SAME * _size(weight, arc.solution, end))
    return False


def _straight(before: Solution | None, a: Solution, b: Solution, after: Solution | None) -> bool:
    """Whether two neighbours are close, or one lies on the line through the other's side."""
    one = np.ones(1)
    allowed = _STRAIGHT * _size(one, a, b)
    if np.abs(b.u - a.u)[..., 1:].max(initial=0.0) <= allowed:
        return True
    for first, second, third in ((before, a, b), (after, b, a)):
        if first is None or first.omega == second.omega:
            continue
        share = (third.omega - second.omega) / (second.omega - first.omega)
        line = second.u + share * (second.u - first.u)
        if np.abs(third.u - line)[..., 1:].max(initial=0.0) <= allowed:
            return True
    return False


def _size(weight: Floats, *states: Solution) -> float:
    """The largest vibration of a contact in some states."""
    return max(float(np.abs(each.u * weight)[..., 1:].max(initial=0.0)) for each in states)


@one_thread
def static_response(
    system: System, options: Options = Options(), modes: Mapping[int, StuckModes] | None = None
) -> Response:
    """The assembled state at rest: preload by interference and static load, friction, lift-off.

    Parameters
    ----------
    system : System
    options : Options
        Friction, samples and tolerance; the others make no difference at rest.
    modes : dict of int to StuckModes, optional
        As for `frequency_response`.

    Returns
    -------
    Response
        One point, harmonic 0 alone, at frequency 0.

    Raises
    ------
    InputError
        If a stiffness is negative even with all contacts stuck, or friction is not possible.
    """
    still = replace(options, harmonics=0, coupling="coupled")
    prepared = structure(system, 0, stuck=modes)
    found = from_nothing(prepared.balance(0.0), still.law(system.contacts), still.tolerance)
    response = assemble_response(prepared, [found])
    return replace(response, friction=still.friction, samples=still.samples or 0)


@one_thread
def frequency_response(
    system: System,
    frequencies: ArrayLike | tuple[float, float],
    options: Options = Options(),
    progress: Progress | None = None,
    modes: Mapping[int, StuckModes] | None = None,
    store: PointStore | None = None,
    find_jumps: bool = True,
) -> Response:
    """Steady vibration with friction: the balance of all harmonics at every frequency.

    Parameters
    ----------
    system : System
    frequencies : (p,) array_like or (float, float)
        Hz. An array or list: exactly these. A tuple (low, high): a range, sampled as the curve
        needs it, the largest amplitude located once more by a parabola.
    options : Options
        Harmonics, coupling, friction and the like.
    progress : callable, optional
        Called after each point with (points done, points in all, estimated for a range; Hz;
        largest amplitude of any output, m); and, the amplitude NaN, whenever a frequency is looked
        for by other ways than Newton's iteration from its neighbours, which may take long.
    modes : dict of int to StuckModes, optional
        Stuck modes of the system's nodal diameters that were computed before (`stuck_modes`): they
        do not depend on friction, interference or load, and take half the time of a response.
    store : PointStore, optional
        Where solved points are written down; from those that it holds already the iteration begins.
        It must be of this very computation.
    find_jumps : bool
        Whether jumps between neighbours are looked for, which may take as long as the points; the
        response's `jump` is None otherwise.

    Returns
    -------
    Response
        `converged`, `residual` and `iterations` say for each point whether it is to be trusted.

    Raises
    ------
    InputError
        If a frequency is not positive, a nodal diameter is missing, or a harmonic above H is
        excited.
    """
    is_range = isinstance(frequencies, tuple)
    hertz = (checked_range if is_range else checked_frequencies)(frequencies)
    points = 100 if is_range else len(hertz)
    ready = options.prepare(system, hertz, points, modes, store)
    found, order = swept(ready.solver, frequencies, options.direction, progress)
    jump = order[_jumps(ready.solver, [found[i] for i in order])] if find_jumps else None
    return ready.response(found, direction=options.direction or "up", jump=jump)


def swept(
    solver: PointSolver,
    frequencies: ArrayLike | tuple[float, float],
    direction: str | None,
    progress: Progress | None,
) -> tuple[list[Solution], Integers]:
    """Solutions at frequencies, Hz, or over a range of them, and in which order they were passed.

    Those at given frequencies come as these do, those of a range upwards.
    """
    is_range = isinstance(frequencies, tuple)
    omegas = TURN * (checked_range if is_range else checked_frequencies)(frequencies)
    reporter = PointsDone(progress)
    solver = replace(solver, searching=reporter.searching)
    order = np.argsort(omegas, kind="stable")
    if direction == "down":
        order = order[::-1]
    if is_range:
        begin, end = omegas[order]
        found = list(_report(solver, solver.explore(begin, end), reporter, (begin, end), None))
        found = _from_behind(solver, found)
        found = sorted(_peaked(solver, found), key=lambda point: point.omega)
        return found, np.arange(len(found))[:: -1 if direction == "down" else 1]
    passed = list(_report(solver, solver.sweep(omegas[order]), reporter, None, len(omegas)))
    by_place = dict(zip(order, _from_behind(solver, passed), strict=True))
    return [by_place[i] for i in range(len(omegas))], order


def _from_behind(solver: PointSolver, swept: list[Solution]) -> list[Solution]:
    """The points of a sweep, those that were not found looked for from the other side, too."""
    found = list(swept)
    for i in range(len(found) - 2, -1, -1):
        if found[i].converged or not found[i + 1].converged:
            continue
        beside = [each for each in found[i + 1 : i + 3] if each.converged][::-1]
        if (again := solver.along(found[i].omega, beside)) is not None:
            found[i] = replace(again, iterations=found[i].iterations + again.iterations)
    return found


def _report(
    solver: PointSolver,
    solutions: Iterable[Solution],
    reporter: PointsDone,
    ends: tuple[float, float] | None,
    total: int | None,
) -> Iterator[Solution]:
    """Pass solutions on, reporting each."""
    for done, solution in enumerate(solutions, 1):
        yield solution
        if reporter.progress is None:
            continue
        if ends is not None:
            share = (solution.omega - ends[0]) / (ends[1] - ends[0])
            expected = done if share >= 1 else max(done + 1, round(done / max(share, 0.01)))
        else:
            expected = total or done
        named = solver.family.structure.system.output_names
        amplitude = float(solver.amplitude(solution).max()) if named else 0.0
        reporter(solution.omega, amplitude, expected)


def _peaked(solver: PointSolver, solutions: list[Solution]) -> list[Solution]:
    """One more point, at the vertex of the parabola through the three highest neighbours."""
    if len(solutions) < 3:
        return solutions
    sizes = np.array([solver.amplitude(point).max(initial=0.0) for point in solutions])
    top = int(np.argmax(sizes))
    if not 0 < top < len(solutions) - 1:
        return solutions
    x = np.array([solutions[i].omega for i in (top - 1, top, top + 1)]) - solutions[top].omega
    bend, rise, _ = np.polyfit(x, sizes[top - 1 : top + 2], 2)
    vertex = -rise / (2 * bend) if bend < 0 else 0.0
    if vertex == 0.0 or not min(x) < vertex < max(x):
        return solutions
    beside = solutions[top - 1] if (vertex < 0) == (x[0] < 0) else solutions[top + 1]
    history = [point for point in (beside, solutions[top]) if point.converged]
    added = solver.point(solutions[top].omega + vertex, history)
    return [*solutions, added]
