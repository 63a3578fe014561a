"""Forced response of a system with friction contacts, and its state at rest."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.receptance_tables import balances
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import Law, contact_law
from vanelock.nonlinear.contact.sampling import FRICTIONS, checked_samples
from vanelock.nonlinear.continuation.families import Frequencies
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver
from vanelock.nonlinear.forced_response.jumps import jumps
from vanelock.nonlinear.forced_response.linear_response import (
    check_band,
    check_forces,
    check_option,
    checked_frequencies,
    checked_range,
)
from vanelock.nonlinear.forced_response.replay import Journal, replaying
from vanelock.nonlinear.forced_response.response import Response, assemble_response
from vanelock.nonlinear.forced_response.static_mean import COUPLINGS, at_rest, with_static_mean
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN
from vanelock.nonlinear.newton.newton import TOLERANCE, Solution
from vanelock.rom.system import System

Floats = NDArray[np.float64]
Progress: TypeAlias = Callable[[int, int, float, float], None]


@one_thread
def static_response(system: System, friction: str = "orthogonal") -> Response:
    """The assembled state at rest: preload by interference and static load, friction, lift-off.

    Parameters
    ----------
    system : System
    friction : {"orthogonal", "isotropic"}
        As of `frequency_response`.

    Returns
    -------
    Response
        One point, harmonic 0 alone, at frequency 0.

    Raises
    ------
    InputError
        If the structure is not held even with all contacts stuck, or friction is not possible.
    """
    prepared = structure(system, 0)
    found = from_nothing(
        prepared.balance(0.0), lambda h: contact_law(system.contacts, h, friction=friction)
    )
    samples = checked_samples(None, 0, friction) or 0
    return replace(assemble_response(prepared, [found]), friction=friction, samples=samples)


@one_thread
def frequency_response(
    system: System,
    frequencies: ArrayLike | tuple[float, float],
    harmonics: int = 3,
    coupling: str = "coupled",
    friction: str = "orthogonal",
    direction: str = "up",
    harmonic_diameters: str = "wave",
    samples: int | None = None,
    static_beyond: float | None = None,
    tolerance: float = TOLERANCE,
    progress: Progress | None = None,
    modes: Mapping[int, StuckModes] | None = None,
    journal: Journal | None = None,
) -> Response:
    """Steady vibration with friction: the balance of all harmonics at every frequency.

    Parameters
    ----------
    system : System
    frequencies : (p,) array_like or (float, float)
        Hz. An array or list: exactly these. A tuple (low, high): a range, sampled as the curve
        needs it, the largest amplitude located once more by a parabola.
    harmonics : int
        H; harmonic 0 is the mean.
    coupling : {"coupled", "uncoupled", "constant-load"}
        Whether static and dynamic balance are solved together. If not, the static one is solved
        first and harmonic 0 of the response is its solution: normal forces then vary about those
        at rest, or are held there for friction's sake, the normal springs linear for good.
    friction : {"orthogonal", "isotropic"}
        Whether friction in the two tangential directions is independent, |t1| <= μ n and
        |t2| <= μ n, or bounded in their plane, |t| <= μ n.
    direction : {"up", "down"}
        Whether frequencies are passed upwards or downwards, which chooses the branch where
        several solutions exist.
    harmonic_diameters : {"wave", "sector"}
        Nodal diameter of harmonic h: (h·EO) mod N, or that of the first one for all h >= 1.
    samples : int, optional
        Evaluate the contact law on this many samples of the period instead of locating its
        events; isotropic friction always does, on 256 unless told otherwise.
    static_beyond : float, optional
        Let modes whose natural frequency is more than this multiple of a harmonic's count by their
        static part alone; the response's `truncation` says what that left out. All modes count in
        full otherwise.
    tolerance : float
        Relative residual at which a point counts as converged.
    progress : callable, optional
        Called after each point with (points done, points in all, estimated for a range; Hz;
        largest amplitude of any output, m).
    modes : dict of int to StuckModes, optional
        Stuck modes of the system's nodal diameters that were computed before (`stuck_modes`): they
        do not depend on friction, interference or load, and take half the time of a response.
    journal : Journal, optional
        Where solved points are written down; those that it holds already are not solved again. It
        must be of this very computation.

    Returns
    -------
    Response
        `converged`, `residual` and `iterations` say for each point whether it is to be trusted.

    Raises
    ------
    InputError
        If an option is unknown, a frequency is not positive, a nodal diameter is missing, or a
        harmonic above H is excited.
    """
    check_option("coupling", coupling, COUPLINGS)
    check_option("friction", friction, FRICTIONS)
    check_option("direction", direction, ("up", "down"))
    samples = checked_samples(samples, harmonics, friction)
    is_range = isinstance(frequencies, tuple)
    hertz = (checked_range if is_range else checked_frequencies)(frequencies)
    prepared = structure(system, harmonics, harmonic_diameters, modes)
    check_forces(system, harmonics)
    check_band(system, hertz)
    omegas = TURN * hertz
    if static_beyond is not None:
        if not static_beyond > 1:
            raise InputError(f"static_beyond: given {static_beyond}: must be > 1")
        prepared = replace(prepared, cutoff=static_beyond * float(omegas.max()))
    points = 100 if is_range else len(omegas)
    law, rest, replay = _law(system, samples, friction, False), None, replaying(journal)
    if coupling != "coupled":
        rest = replay("rest", (), partial(at_rest, prepared, law, tolerance))
        law = _law(system, samples, friction, coupling == "constant-load")
    source = balances(prepared, omegas.min(), omegas.max(), points)
    mean = None if rest is None else rest.u[:, :, 0]
    solver = PointSolver(Frequencies(source, law(harmonics), mean), law, tolerance, replay)
    order = np.argsort(omegas, kind="stable")
    if direction == "down":
        order = order[::-1]
    if is_range:
        begin, end = omegas[order]
        found = list(_reported(solver, solver.explore(begin, end), progress, (begin, end), None))
        found = sorted(_peaked(solver, found), key=lambda point: point.omega)
        order = np.arange(len(found))[:: -1 if direction == "down" else 1]
    else:
        swept = _reported(solver, solver.sweep(omegas[order]), progress, None, len(omegas))
        by_place = dict(zip(order, swept, strict=True))
        found = [by_place[i] for i in range(len(omegas))]
    jump = order[jumps(solver, [found[i] for i in order])]
    if rest is not None:
        found = [with_static_mean(point, rest) for point in found]
    response = assemble_response(prepared, found)
    return replace(
        response,
        coupling=coupling,
        friction=friction,
        samples=samples or 0,
        direction=direction,
        jump=jump,
    )


def _law(
    system: System, samples: int | None, friction: str, constant_load: bool
) -> Callable[[int], Law]:
    """The contact law by number of harmonics."""
    return lru_cache(lambda h: contact_law(system.contacts, h, samples, friction, constant_load))


def _reported(
    solver: PointSolver,
    solutions: Iterable[Solution],
    progress: Progress | None,
    ends: tuple[float, float] | None,
    total: int | None,
) -> Iterator[Solution]:
    """Pass solutions on, telling `progress` of each."""
    for done, solution in enumerate(solutions, 1):
        yield solution
        if progress is None:
            continue
        if ends is not None:
            share = (solution.omega - ends[0]) / (ends[1] - ends[0])
            expected = done if share >= 1 else max(done + 1, round(done / max(share, 0.01)))
        else:
            expected = total or done
        named = solver.family.structure.system.output_names
        amplitude = float(solver.amplitude(solution).max()) if named else 0.0
        progress(done, expected, solution.omega / TURN, amplitude)


def _peaked(solver: PointSolver, found: list[Solution]) -> list[Solution]:
    """One more point, at the vertex of the parabola through the three highest neighbours."""
    if len(found) < 3:
        return found
    sizes = np.array([solver.amplitude(point).max(initial=0.0) for point in found])
    top = int(np.argmax(sizes))
    if not 0 < top < len(found) - 1:
        return found
    x = np.array([found[i].omega for i in (top - 1, top, top + 1)]) - found[top].omega
    bend, rise, _ = np.polyfit(x, sizes[top - 1 : top + 2], 2)
    vertex = -rise / (2 * bend) if bend < 0 else 0.0
    if vertex == 0.0 or not min(x) < vertex < max(x):
        return found
    beside = found[top - 1] if (vertex < 0) == (x[0] < 0) else found[top + 1]
    history = [point for point in (beside, found[top]) if point.converged]
    added = solver.point(found[top].omega + vertex, history)
    return [*found, added]
