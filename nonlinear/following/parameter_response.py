"""Response at one frequency against a force, a friction coefficient or an interference."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache, partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.following.parameters import (
    Joint,
    Parameter,
    checked_parameter,
    checked_values,
)
from vanelock.nonlinear.forced_response.frequencies import checked_frequencies
from vanelock.nonlinear.forced_response.frequency_sweep import counted, starts
from vanelock.nonlinear.forced_response.options import Options, PreparedSystem
from vanelock.nonlinear.forced_response.response import CONSTANT, Response
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN
from vanelock.nonlinear.newton.newton import Family, Solution, solve
from vanelock.rom.system.system import System

Floats = NDArray[np.float64]
Progress: TypeAlias = Callable[[int, int, float, float], None]

ALONG_POINTS = {field.name for field in fields(Response)} - {*CONSTANT, "jump"}


@dataclass(frozen=True)
class ParameterResponse(Product):
    """Periodic response at one frequency and p values of a parameter.

    Attributes
    ----------
    name : str
        "force", "mu" or "interference".
    parameter : (p,) float
        Factor of the excitation, coefficient of friction, or interference in m.
    response : Response
        One point for each value; its `mu` is that of the system as it was given.
    mu : (p, c) float
        Friction coefficients of each point.
    """

    name: str
    parameter: Floats
    response: Response
    mu: Floats

    def at(self, point: int) -> Response:
        """One point as a response of its own, with its own friction coefficients."""
        return replace(self.response.at([point]), mu=self.mu[point])


def joined(responses: Sequence[Response], mu: Floats) -> tuple[Response, Floats]:
    """Points of one system's responses, one after another; and (p, c) their friction coefficients.

    Those of the system as it is given, `mu`, are those of the response.
    """
    put: dict[str, Any] = {}
    for name in ALONG_POINTS:
        kept = [getattr(each, name) for each in responses]
        if isinstance(kept[0], dict):
            put[name] = {h: np.concatenate([each[h] for each in kept]) for h in kept[0]}
        else:
            put[name] = np.concatenate(kept)
    own = np.array([each.mu for each in responses])
    return replace(responses[0], mu=mu, **put), own


@one_thread
def parameter_response(
    system: System,
    frequency: float,
    parameter: str,
    values: ArrayLike,
    options: Options = Options(),
    joint: Joint = None,
    progress: Progress | None = None,
) -> ParameterResponse:
    """Steady vibration at one frequency while a parameter varies.

    Where the path of solutions folds it is followed through by arc length.

    Parameters
    ----------
    system : System
    frequency : float
        Hz.
    parameter : {"force", "mu", "interference"}
        "force": factor of the excitation of all harmonics h >= 1, the static load stays; "mu":
        coefficient of friction; "interference": v0, m.
    values : (p,) array_like
        Values of the parameter; those of force and mu are positive.
    options : Options
        Their direction is that in which the values are passed.
    joint : str, sequence of str or (c,) bool, optional
        The joints or contacts whose friction or interference varies; all by default.
    progress : callable, optional
        Called after each point with (points done, points in all, value, largest amplitude of any
        output, m).

    Returns
    -------
    ParameterResponse
        `response.converged` and `residual` say for each point whether it is to be trusted.

    Raises
    ------
    InputError
        As of `frequency_response`, or if a joint or a value is not possible.
    """
    hertz = checked_frequencies(frequency)
    if len(hertz) != 1:
        raise InputError(f"frequency: given {len(hertz)} of them: needs one")
    given = checked_values(values)
    varied = checked_parameter(parameter, system, given, joint)
    ready = options.prepare(system, hertz, 1)
    at = lru_cache(4)(partial(varied.at, ready))
    tracer = Tracer(at, varied, varied.family(ready, TURN * hertz[0]), ready.options.tolerance)
    order = np.argsort(given, kind="stable")
    if options.direction == "down":
        order = order[::-1]
    history: list[Solution] = []
    found: dict[int, Response] = {}
    for done, i in enumerate(order, 1):
        value = float(given[i])
        solution = tracer.point(value, history)
        found[int(i)] = at(value).response([solution])
        if solution.converged:
            history = [*history, solution][-2:]
        if progress is not None:
            progress(done, len(given), value, float(found[int(i)].amplitude.max(initial=0.0)))
    response, mu = joined([found[i] for i in range(len(given))], system.contacts.mu)
    return ParameterResponse(parameter, given, response, mu)


@dataclass(frozen=True)
class Tracer:
    """What solves at one value of a parameter after another, at one frequency.

    Attributes
    ----------
    at : callable
        The system by value, ready to be solved.
    varied : Parameter
    family : Family
        By the coordinate of the parameter.
    tolerance : float
        Relative residual that counts as converged.
    """

    at: Callable[[float], PreparedSystem]
    varied: Parameter
    family: Family
    tolerance: float

    def point(self, value: float, history: Sequence[Solution]) -> Solution:
        """Solve at a value, given up to two converged neighbours, the nearest last."""
        place = self.varied.coordinate(value)
        tried = []
        kept = history[-1].kept if history else None
        for start in starts(place, history):
            tried.append(solve(self.family, start, place, tolerance=self.tolerance, kept=kept))
            if tried[-1].converged:
                return counted(tried, place)
        if history:
            arc = follow(self.family, history[-1], place, self.tolerance)
            if arc.solution is not None:
                return counted([*tried, arc.solution], place)
        found = from_nothing(self.family.at(place), self.at(value).law, self.tolerance)
        return counted([*tried, replace(found, parameter=place)], place)
