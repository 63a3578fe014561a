"""Frequency response of a system with friction contacts."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock.nonlinear.arc import follow
from vanelock.nonlinear.balance import structure
from vanelock.nonlinear.families import Frequencies, Interpolated, fixed, frequencies
from vanelock.nonlinear.law import Law, contact_law
from vanelock.nonlinear.newton import TOLERANCE, Solution, solve
from vanelock.nonlinear.rescue import from_nothing
from vanelock.nonlinear.response import Response, assemble_response
from vanelock.nonlinear.trigonometric import TURN
from vanelock.rom.system import System

Floats = NDArray[np.float64]
Progress: TypeAlias = Callable[[int, int, float, float], None]


def static_response(system: System) -> Response:
    """The assembled state at rest: preload by interference and static load, friction, lift-off.

    Returns
    -------
    Response
        One point, harmonic 0 alone, at frequency 0.
    """
    prepared = structure(system, 0)
    found = from_nothing(prepared.balance(0.0), lambda h: contact_law(system.contacts, h))
    return assemble_response(prepared, [found])


def frequency_response(
    system: System,
    frequencies_hz: ArrayLike | tuple[float, float],
    harmonics: int = 3,
    progress: Progress | None = None,
    harmonic_diameters: str = "wave",
    samples: int | None = None,
    tolerance: float = TOLERANCE,
) -> Response:
    """Coupled static and dynamic balance at every frequency, to a relative residual of 1e-10."""
    prepared = structure(system, harmonics, harmonic_diameters)
    omegas = TURN * np.atleast_1d(np.asarray(frequencies_hz, float))
    solver = Solver(
        frequencies(prepared, omegas),
        lru_cache(lambda h: contact_law(system.contacts, h, samples)),
        harmonics,
        tolerance,
    )
    return assemble_response(prepared, list(solver.sweep(omegas)))


@dataclass(frozen=True)
class Solver:
    """What solves one point after another.

    Attributes
    ----------
    family : Frequencies or Interpolated
    law : callable
        The contact law for a number of harmonics.
    harmonics : int
    tolerance : float
    """

    family: Frequencies | Interpolated
    law: Callable[[int], Law]
    harmonics: int
    tolerance: float

    def sweep(self, omegas: Floats) -> Iterator[Solution]:
        """Solve point by point, each from its predecessors."""
        history: list[Solution] = []
        for omega in omegas:
            found = self.point(omega, history)
            yield found
            if found.converged:
                history = [*history, found][-2:]

    def point(self, omega: float, history: list[Solution]) -> Solution:
        """Solve at one frequency, rad/s, given up to two converged neighbours, the last nearest."""
        balance = self.family.at(omega)
        law = self.law(self.harmonics)
        spent, best = 0, None
        for start in _starts(omega, history):
            found = solve(fixed(balance), law, start, 0.0, tolerance=self.tolerance)
            spent += found.iterations
            if best is None or found.residual < best.residual:
                best = found
            if found.converged:
                break
        if history and (best is None or not best.converged):
            arc = follow(self.family, law, history[-1], omega, self.tolerance)
            spent += arc.iterations
            if arc.solution is not None:
                best = arc.solution
        if best is None or not best.converged:
            found = from_nothing(balance, self.law, self.tolerance)
            spent += found.iterations
            if best is None or found.residual < best.residual:
                best = found
        return replace(best, omega=omega, parameter=omega, iterations=spent)


def _starts(omega: float, history: list[Solution]) -> Iterator[Floats]:
    """First guesses: along the secant of the last two solutions, and the last one."""
    if len(history) == 2 and history[0].omega != history[1].omega:
        a, b = history
        yield b.w + (omega - b.omega) / (b.omega - a.omega) * (b.w - a.w)
    if history:
        yield history[-1].w
