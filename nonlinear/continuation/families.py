"""Families of problems to move along: in frequency, in loads, in friction.

A problem is u = ũ + R̂ w with w = W(u), a balance and a law of contact; a family has one for every
value of its parameter.
"""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.contact.law import Deviation, Law
from vanelock.nonlinear.newton.preconditioner import response_to


class _BalanceSource(Protocol):
    """Gives the balances: a structure, its tables, a ring of them."""

    @property
    def structure(self) -> Structure:
        """The structure behind the balances, or what gives motions and their slopes as it does."""

    def balance(self, omega: float) -> Balance:
        """The balance at a circular frequency, rad/s."""


@dataclass(frozen=True)
class Frequencies:
    """Problems by circular frequency, rad/s; a `mean` (c, 3), m, is held whatever contacts do."""

    source: _BalanceSource
    friction: Law
    mean: Floats | None = None

    @property
    def structure(self) -> Structure:
        """The structure behind the balances."""
        return self.source.structure

    def at(self, parameter: float) -> Balance:
        """The balance at a circular frequency."""
        balance = self.source.balance(parameter)
        return balance if self.mean is None else balance.with_mean(self.mean)

    def law(self, parameter: float) -> Law:
        """The law, the same at every frequency."""
        return self.friction

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """dW/dω at fixed w, on the given components of w."""
        rate = response_to(deviation, rows, self.structure.slope(parameter, w))
        return rate if deviation.by_omega is None else rate + deviation.by_omega.reshape(-1)[rows]


@dataclass(frozen=True)
class Loads:
    """Problems at one frequency whose ũ moves along a direction dũ/dp, m, from the balance at 0."""

    balance: Balance
    direction: Floats
    friction: Law

    def at(self, parameter: float) -> Balance:
        """The balance at a value of the parameter."""
        return replace(self.balance, linear=self.balance.linear + parameter * self.direction)

    def law(self, parameter: float) -> Law:
        """The law, the same under every load."""
        return self.friction

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """dW/dp at fixed w, on the given components of w."""
        return response_to(deviation, rows, self.direction)


def fixed(balance: Balance, law: Law) -> Loads:
    """A family of one."""
    return Loads(balance, np.zeros_like(balance.linear), law)


@dataclass(frozen=True)
class Laws:
    """Problems at one frequency and load, by their law."""

    balance: Balance
    friction: Law

    def at(self, parameter: float) -> Balance:
        """The balance, the same for all."""
        return self.balance
