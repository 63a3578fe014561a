"""What a response may be followed along beside its frequency: force, friction, interference.

None of them changes the stuck modes or their damping, so that a system prepared once serves all
their values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock.common.arrays import as_array
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated
from vanelock.nonlinear.contact.law import Deviation, Law
from vanelock.nonlinear.continuation.families import Frictions, Loads
from vanelock.nonlinear.continuation.path import tangent_at
from vanelock.nonlinear.forced_response.linear_response import closed_contacts
from vanelock.nonlinear.forced_response.options import PreparedSystem, check_option
from vanelock.nonlinear.forced_response.static_mean import static_part
from vanelock.nonlinear.newton.law_jacobian import response_to
from vanelock.nonlinear.newton.newton import Family, Solution
from vanelock.rom.system.system import System

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
Joint: TypeAlias = str | Sequence[str] | NDArray[np.bool_] | None

NAMES = {"force": "1", "mu": "1", "interference": "m"}
"""Parameters and their units."""


@dataclass(frozen=True)
class Parameter:
    """One of a system's quantities, to be varied.

    Attributes
    ----------
    name : str
        "force": factor of the excitation of all harmonics h >= 1; the static load stays. "mu":
        coefficient of friction. "interference": v0, m. "slider": way from one place of the
        sliders, 0, to another, 1. "worn": way from one interference of all contacts to another.
    contacts : (c,) bool
        Contacts whose friction or interference it is.
    logarithmic : bool
        Whether it is moved along by its logarithm.
    sliders : (2, c, 2) float, optional
        The two places, m.
    interferences : (2, c) float, optional
        The two interferences, m.
    """

    name: str
    contacts: NDArray[np.bool_]
    logarithmic: bool
    sliders: Floats | None = None
    interferences: Floats | None = None

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
        contacts = system.contacts
        if self.sliders is not None:
            begin, end = self.sliders
            slider = (1 - value) * begin + value * end
            return replace(system, contacts=replace(contacts, slider=slider))
        if self.interferences is not None:
            begin, end = self.interferences
            v0 = (1 - value) * begin + value * end
            return replace(system, contacts=replace(contacts, v0=v0))
        if self.name == "mu":
            mu = np.where(self.contacts, value, contacts.mu)
            return replace(system, contacts=replace(contacts, mu=mu))
        v0 = np.where(self.contacts, value, contacts.v0)
        return replace(system, contacts=replace(contacts, v0=v0))

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
            found = AboutRest(moving, still, lru_cache(partial(self._rest, ready)))
        return Logarithmic(found) if self.logarithmic else found

    def _family(self, prepared: Structure, law: Law, omega: float) -> Loads | Frictions:
        """Coupled problems by the parameter itself; `law` is that at a value of 1."""
        balance = prepared.balance(omega)
        if self.name == "mu":
            return Frictions(balance, law, self.contacts)
        at_zero = self.structure(prepared, 0.0).linear(omega)
        direction = self.structure(prepared, 1.0).linear(omega) - at_zero
        return Loads(replace(balance, linear=at_zero), direction, law)


def checked_parameter(name: str, system: System, values: Floats, joint: Joint = None) -> Parameter:
    """A parameter by its name, checked against the values that it shall take."""
    check_option("parameter", name, NAMES)
    if name == "force" and joint is not None:
        raise InputError(f"joint: given {joint!r}: the force acts on no joint; leave it out")
    if not len(values) or not np.all(np.isfinite(values)):
        raise InputError("values: given none or not finite: needs a list of finite numbers")
    positive = bool(np.all(values > 0))
    if name != "interference" and not positive:
        raise InputError(f"values: given {values.min():g}: {name} must be > 0")
    contacts = closed_contacts(system.contacts, "all" if joint is None else joint)
    if name != "force" and not contacts.any():
        raise InputError(f"parameter: given {name!r}: the system has no contacts, nothing varies")
    if name == "interference" and not positive:
        return Parameter(name, contacts, False)
    return Parameter(name, contacts, True)


def checked_values(values: ArrayLike) -> Floats:
    """(p,) values of a parameter."""
    given = np.atleast_1d(as_array(values, "values"))
    if given.ndim != 1:
        raise InputError(f"values: given shape {given.shape}: needs a list")
    return given


@dataclass(frozen=True)
class AboutRest:
    """Problems whose mean is held at the state at rest, which may move with the parameter.

    `moving` are those of all harmonics, `still` the static ones, `rest` gives their solution.
    """

    moving: Loads | Frictions
    still: Loads | Frictions
    rest: Callable[[float], Solution]

    def _held(self, parameter: float) -> Loads | Frictions:
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

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Rows) -> Floats:
        """Derivative of W at fixed w, on the given components of w."""
        rates = self._held(parameter).rate(parameter, w, deviation, rows)
        rest = replace(self.rest(parameter), parameter=parameter)
        tangent = tangent_at(self.still, rest)
        if tangent is None:
            return rates
        pushed = self.still.at(parameter + 1).linear - self.still.at(parameter).linear
        moved = np.zeros_like(w)
        moved[:, :, :1] = pushed + self.still.balance.moved(tangent.z)
        return rates + response_to(deviation, rows, moved)


@dataclass(frozen=True)
class Logarithmic:
    """A family by the logarithm of its parameter, > 0, which fits values over several decades."""

    family: Family

    def at(self, parameter: float) -> Balance:
        """The balance at a logarithm."""
        return self.family.at(float(np.exp(parameter)))

    def law(self, parameter: float) -> Law:
        """The law of contact at a logarithm."""
        return self.family.law(float(np.exp(parameter)))

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Rows) -> Floats:
        """Derivative of W to the logarithm at fixed w, on the given components of w."""
        value = float(np.exp(parameter))
        rates: Floats = value * self.family.rate(value, w, deviation, rows)
        return rates
