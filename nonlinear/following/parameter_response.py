"""Response at one frequency against a force, a friction coefficient or an interference."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.balance import Balance, Structure, structure
from vanelock.nonlinear.contact.law import Law, contact_law
from vanelock.nonlinear.contact.sampling import checked_samples
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.following.parameters import (
    Joint,
    Parameter,
    checked_parameter,
    checked_values,
)
from vanelock.nonlinear.forced_response.frequency_sweep import starts
from vanelock.nonlinear.forced_response.linear_response import (
    check_band,
    check_forces,
    checked_frequencies,
)
from vanelock.nonlinear.forced_response.response import CONSTANT, Response, assemble_response
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN
from vanelock.nonlinear.newton.newton import TOLERANCE, Family, Solution, solve
from vanelock.rom.system import System

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


def joined(responses: Sequence[Response]) -> Response:
    """Points of several responses of one system, one after another; `mu` is the first one's."""
    put: dict[str, Any] = {}
    for name in ALONG_POINTS:
        kept = [getattr(each, name) for each in responses]
        if isinstance(kept[0], dict):
            put[name] = {h: np.concatenate([each[h] for each in kept]) for h in kept[0]}
        else:
            put[name] = np.concatenate(kept)
    return replace(responses[0], **put)


def assembled(
    prepared: Structure, varied: Parameter, values: Sequence[float], solutions: Sequence[Solution]
) -> tuple[Response, Floats]:
    """Collect solutions at several values into a response; and (p, c) friction coefficients."""
    each = [
        assemble_response(varied.structure(prepared, value), [solution])
        for value, solution in zip(values, solutions, strict=True)
    ]
    mu = np.array([response.mu for response in each])
    return replace(joined(each), mu=prepared.system.contacts.mu), mu


@one_thread
def parameter_response(
    system: System,
    frequency: float,
    parameter: str,
    values: ArrayLike,
    harmonics: int = 3,
    joint: Joint = None,
    direction: str = "up",
    harmonic_diameters: str = "wave",
    samples: int | None = None,
    tolerance: float = TOLERANCE,
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
    harmonics : int
        H.
    joint : str, sequence of str or (c,) bool, optional
        The joints or contacts whose friction or interference varies; all by default.
    direction : {"up", "down"}
        Whether the values are passed upwards or downwards.
    harmonic_diameters, samples, tolerance
        As of `frequency_response`.
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
        If an option, a joint or a value is not possible.
    """
    if direction not in ("up", "down"):
        raise InputError(f"direction: given {direction!r}: allowed: up, down")
    hertz = checked_frequencies(frequency)
    if len(hertz) != 1:
        raise InputError(f"frequency: given {len(hertz)} of them: needs one")
    given = checked_values(values)
    varied = checked_parameter(parameter, system, given, joint)
    samples = checked_samples(samples, harmonics)
    prepared = structure(system, harmonics, harmonic_diameters)
    check_forces(system, harmonics)
    check_band(system, hertz)
    law = lru_cache(lambda h: contact_law(system.contacts, h, samples))
    balance = prepared.balance(TURN * hertz[0])
    tracer = Tracer(prepared, varied, balance, law, tolerance)
    order = np.argsort(given, kind="stable")
    if direction == "down":
        order = order[::-1]
    history: list[Solution] = []
    found: dict[int, Solution] = {}
    for done, i in enumerate(order, 1):
        solution = tracer.point(float(given[i]), history)
        found[int(i)] = solution
        if solution.converged:
            history = [*history, solution][-2:]
        if progress is not None:
            one = assemble_response(varied.structure(prepared, float(given[i])), [solution])
            progress(done, len(given), float(given[i]), float(one.amplitude.max(initial=0.0)))
    solutions = [found[i] for i in range(len(given))]
    response, mu = assembled(prepared, varied, given.tolist(), solutions)
    response = replace(response, samples=samples or 0)
    return ParameterResponse(parameter, given, response, mu)


@dataclass(frozen=True)
class Tracer:
    """What solves at one value of a parameter after another, at one frequency.

    Attributes
    ----------
    prepared : Structure
    varied : Parameter
    balance : Balance
        Of the system as it is given.
    law_of : callable
        The contact law of the system for a number of harmonics.
    tolerance : float
    family : Family
        By the coordinate of the parameter.
    """

    prepared: Structure
    varied: Parameter
    balance: Balance
    law_of: Callable[[int], Law]
    tolerance: float
    family: Family = field(init=False)

    def __post_init__(self) -> None:
        """Make the family."""
        law = self.law_of(self.prepared.harmonics)
        family = self.varied.family(self.prepared, self.balance, law)
        object.__setattr__(self, "family", family)

    def point(self, value: float, history: Sequence[Solution]) -> Solution:
        """Solve at a value, given up to two converged neighbours, the nearest last."""
        place = self.varied.coordinate(value)
        tried = []
        kept = history[-1].kept if history else None
        for start in starts(place, history):
            tried.append(solve(self.family, start, place, tolerance=self.tolerance, kept=kept))
            if tried[-1].converged:
                return _counted(tried)
        if history:
            arc = follow(self.family, history[-1], place, self.tolerance)
            if arc.solution is not None:
                return _counted([*tried, arc.solution])
        system = self.prepared.system
        found = from_nothing(
            self.family.at(place),
            lambda h: self.varied.law(system, self.law_of(h), value),
            self.tolerance,
        )
        return _counted([*tried, replace(found, parameter=place)])


def _counted(tried: Sequence[Solution]) -> Solution:
    """The best of some attempts, with the iterations of them all."""
    best = min(tried, key=lambda each: (not each.converged, each.residual))
    return replace(best, iterations=sum(each.iterations for each in tried))
