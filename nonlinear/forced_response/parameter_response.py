"""Response at one frequency against a force, a friction coefficient or an interference.

None of them changes the stuck modes or their damping, so that a system prepared once serves all
their values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache, partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Booleans, Floats, Integers, as_array
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated
from vanelock.nonlinear.contact.law import Deviation, Law
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import Laws, Loads
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.continuation.path import tangent_at
from vanelock.nonlinear.forced_response.frequency_sweep import Progress, counted, starts
from vanelock.nonlinear.forced_response.linear_response import closed_contacts
from vanelock.nonlinear.forced_response.options import (
    Options,
    PreparedSystem,
    check_option,
    checked_frequencies,
    static_part,
)
from vanelock.nonlinear.forced_response.response import CONSTANT, Response
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.newton.newton import Family, Solution, solve
from vanelock.nonlinear.newton.preconditioner import response_to
from vanelock.rom.system.system import System

Joint: TypeAlias = str | Sequence[str] | Booleans | None

_NAMES = ("force", "mu", "interference")
_VARIED = {"mu": "mu", "interference": "v0", "slider": "slider", "worn": "v0"}
"""What of the contacts a parameter is."""


@dataclass(frozen=True)
class _Frictions(Laws):
    """Problems at one frequency whose coefficients of friction are scaled by the parameter, > 0.

    Of the contacts `scaled`, (c,) bool, or of all where that is not given.
    """

    scaled: Booleans | None = None

    def law(self, parameter: float) -> Law:
        """The law with the coefficients scaled."""
        alpha = parameter * self.friction.alpha
        if self.scaled is not None:
            alpha = np.where(self.scaled[:, None], alpha, self.friction.alpha)
        return replace(self.friction, alpha=alpha)

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """dW/dp at fixed w, on the given components of w.

        A slider's place depends on friction through μ v alone, so that μ dw/dμ = (dw/dv) v.
        """
        u = self.balance.displacement(w).copy()
        u[:, 1:] = 0.0
        if self.scaled is not None:
            u[~self.scaled] = 0.0
        u[list(self.friction.elements)] = 0.0
        m = w.shape[2]
        rates = response_to(deviation, rows, u) / parameter
        return np.where(rows // m % 3 == 0, 0.0, rates)


@dataclass(frozen=True)
class Parameter:
    """One of a system's quantities, to be varied.

    `name`: "force": factor of the excitation of all harmonics h >= 1; the static load stays. "mu":
    coefficient of friction. "interference": v0, m. "slider", "worn": way from one place of the
    sliders, or one interference of all contacts, 0, to another, 1, `ends` (2, c, ...), m;
    `contacts` (c,): contacts whose friction or interference it is; `logarithmic`: whether it is
    moved along by its logarithm.
    """

    name: str
    contacts: Booleans
    logarithmic: bool
    ends: Floats | None = None

    def coordinate(self, value: float) -> float:
        """The value itself, or its logarithm."""
        return float(np.log(value)) if self.logarithmic else value

    def system(self, system: System, value: float) -> System:
        """The system with the parameter at a value."""
        if self.name == "force":
            force = {
                h: replace(each, vector=value * each.vector) if h else each
                for h, each in system.force.items()
            }
            return replace(system, force=force)
        contacts, kind = system.contacts, _VARIED[self.name]
        if self.ends is not None:
            begin, end = self.ends
            moved = (1 - value) * begin + value * end
        else:
            moved = np.where(self.contacts, value, getattr(contacts, kind))
        return replace(system, contacts=replace(contacts, **{kind: moved}))

    def structure(self, prepared: Structure, value: float) -> Structure:
        """The prepared system with the parameter at a value."""
        moved = replace(prepared, system=self.system(prepared.system, value))
        vars(moved)["output_rows"] = prepared.output_rows  # the modes', whatever the value
        return moved

    def at(self, ready: PreparedSystem, value: float) -> PreparedSystem:
        """The system ready to be solved with the parameter at a value."""
        moved = replace(ready, source=self._source(ready.source, value))
        if self.name == "force":  # the static load stays
            vars(moved)["rest"] = ready.rest
        return moved

    def _source(self, source: Structure | Tabulated, value: float) -> Structure | Tabulated:
        """What gives the balances by frequency, with the parameter at a value."""
        if not isinstance(source, Tabulated):
            return self.structure(source, value)
        tables = source.tables
        if self.name == "force":  # interference and friction leave all that vibrates as it is
            tables = tuple(
                replace(each, linear=None if each.linear is None else value * each.linear)
                for each in tables
            )
        return replace(source, structure=self.structure(source.structure, value), tables=tables)

    def _rest(self, ready: PreparedSystem, value: float) -> Solution:
        """The state at rest with the parameter at a value."""
        found = self.at(ready, value).rest
        assert found is not None
        return found

    def family(self, ready: PreparedSystem, omega: float) -> Family:
        """Problems at one frequency, rad/s, by the coordinate of the parameter."""
        one = self.at(ready, 1.0)
        moving = self._family(ready.structure, one.law(ready.structure.harmonics), omega)
        found: Family = moving
        if ready.rest is not None:
            still = self._family(static_part(ready.structure), one.law_at_rest(0), 0.0)
            found = _AboutRest(moving, still, lru_cache(partial(self._rest, ready)))
        return _Logarithmic(found) if self.logarithmic else found

    def _family(self, prepared: Structure, law: Law, omega: float) -> Loads | _Frictions:
        """Coupled problems by the parameter itself; `law` is that at a value of 1."""
        balance = prepared.balance(omega)
        if self.name == "mu":
            return _Frictions(balance, law, self.contacts)
        at_zero = self.structure(prepared, 0.0).balance(omega).linear
        direction = self.structure(prepared, 1.0).balance(omega).linear - at_zero
        return Loads(replace(balance, linear=at_zero), direction, law)


def checked_parameter(
    name: str, system: System, values: ArrayLike, joint: Joint = None
) -> tuple[Parameter, Floats]:
    """A parameter by its name, and the (p,) values that it shall take."""
    taken = np.atleast_1d(as_array(values, "values"))
    if taken.ndim != 1:
        raise InputError(f"values: given shape {taken.shape}: needs a list")
    check_option("parameter", name, _NAMES)
    if name == "force" and joint is not None:
        raise InputError(f"joint: given {joint!r}: the force acts on no joint; leave it out")
    if not len(taken) or not np.all(np.isfinite(taken)):
        raise InputError("values: given none or not finite: needs a list of finite numbers")
    positive = bool(np.all(taken > 0))
    if name != "interference" and not positive:
        raise InputError(f"values: given {taken.min():g}: {name} must be > 0")
    contacts = closed_contacts(system.contacts, "all" if joint is None else joint)
    if name != "force" and not contacts.any():
        raise InputError(f"parameter: given {name!r}: the system has no contacts, nothing varies")
    return Parameter(name, contacts, logarithmic=positive), taken


@dataclass(frozen=True)
class _AboutRest:
    """Problems whose mean is held at the state at rest, which may move with the parameter.

    `moving` are those of all harmonics, `static` those of rest, `rest` gives their solution.
    """

    moving: Loads | _Frictions
    static: Loads | _Frictions
    rest: Callable[[float], Solution]

    def _held(self, parameter: float) -> Loads | _Frictions:
        """Problems about the state at rest at a value."""
        mean = self.rest(parameter).u[:, :, 0]
        found = replace(self.moving, balance=self.moving.balance.with_mean(mean))
        if isinstance(found, Loads):  # what it does to the mean, it does to the state at rest
            direction = found.direction.copy()
            direction[:, :, 0] = 0.0
            found = replace(found, direction=direction)
        return found

    def at(self, parameter: float) -> Balance:
        """The balance at a value."""
        return self._held(parameter).at(parameter)

    def law(self, parameter: float) -> Law:
        """The law of contact at a value."""
        return self.moving.law(parameter)

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """Derivative of W at fixed w, on the given components of w."""
        rates = self._held(parameter).rate(parameter, w, deviation, rows)
        rest = replace(self.rest(parameter), parameter=parameter)
        tangent = tangent_at(self.static, rest)
        if tangent is None:
            return rates
        pushed = self.static.at(parameter + 1).linear - self.static.at(parameter).linear
        moved = np.zeros_like(w)
        moved[:, :, :1] = pushed + self.static.balance.moved(tangent.z)
        return rates + response_to(deviation, rows, moved)


@dataclass(frozen=True)
class _Logarithmic:
    """A family by the logarithm of its parameter, > 0, which fits values over several decades."""

    family: Family

    def at(self, parameter: float) -> Balance:
        """The balance at a logarithm."""
        return self.family.at(float(np.exp(parameter)))

    def law(self, parameter: float) -> Law:
        """The law of contact at a logarithm."""
        return self.family.law(float(np.exp(parameter)))

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """Derivative of W to the logarithm at fixed w, on the given components of w."""
        value = float(np.exp(parameter))
        return np.asarray(value * self.family.rate(value, w, deviation, rows))


_ALONG_POINTS = {field.name for field in fields(Response)} - {*CONSTANT, "jump"}


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
    for name in _ALONG_POINTS:
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
    varied, given = checked_parameter(parameter, system, values, joint)
    ready = options.prepare(system, hertz, 1)
    at = lru_cache(4)(partial(varied.at, ready))
    family = varied.family(ready, TURN * hertz[0])
    order = np.argsort(given, kind="stable")
    if options.direction == "down":
        order = order[::-1]
    history: list[Solution] = []
    found: dict[int, Response] = {}
    for done, i in enumerate(order, 1):
        value = float(given[i])
        place, tolerance = varied.coordinate(value), ready.options.tolerance
        solution = traced(family, place, history, partial(at, value), tolerance)
        found[int(i)] = at(value).response([solution])
        if solution.converged:
            history = [*history, solution][-2:]
        if progress is not None:
            progress(done, len(given), value, float(found[int(i)].amplitude.max(initial=0.0)))
    response, mu = joined([found[i] for i in range(len(given))], system.contacts.mu)
    return ParameterResponse(parameter, given, response, mu)


def traced(
    family: Family,
    position: float,
    history: Sequence[Solution],
    ready: Callable[[], PreparedSystem],
    tolerance: float,
) -> Solution:
    """Solve at a value of a parameter, given up to two converged neighbours, the nearest last.

    `family`: by the coordinate of the parameter; `ready`: gives the system there.
    """
    tried = []
    reuse = history[-1].reuse if history else None
    for start in starts(position, history):
        tried.append(solve(family, start, position, tolerance=tolerance, reuse=reuse))
        if tried[-1].converged:
            return counted(tried, position)
    if history:
        arc = follow(family, history[-1], position, tolerance)
        if arc.solution is not None:
            return counted([*tried, arc.solution], position)
    found = from_nothing(family.at(position), ready().law, tolerance)
    return counted([*tried, replace(found, parameter=position)], position)
