"""From contacts that are soft, so that nothing happens suddenly, to contacts as they are.

Springs s kₙ and s kₜ, 0 < s <= 1, leave the ratio that friction is bounded by, μ kₙ/kₜ, as it is:
the force s K_c (u - W(u)) of soft contacts is that of true ones with the deviation

    W_s(u) = (1 - s) u + s W(u).

At s = 0 there are no contacts at all. With s small the free structure presses against something
soft, and has one response near its own.
"""

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.contact.law import Deviation, Law

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class SoftLaw(Law):
    """The law of contacts with the share s of their stiffness."""

    share: float

    def __call__(self, u: Floats, omega: float = 0.0) -> Deviation:
        """Evaluate at the relative displacements (c, 3, 2H + 1), m, of (v, u1, u2)."""
        found = super().__call__(u, omega)
        width = 3 * u.shape[2]
        jacobian = self.share * found.jacobian.reshape(len(u), width, width)
        jacobian += (1 - self.share) * np.eye(width)
        w = (1 - self.share) * u + self.share * found.w
        return Deviation(w, jacobian.reshape(found.jacobian.shape), found.state, found.dissipation)


@dataclass(frozen=True)
class Hardening:
    """Problems at one load whose contacts have the share s = softest^(1 - p) of their stiffness."""

    balance: Balance
    friction: Law
    softest: float

    def _share(self, parameter: float) -> float:
        return float(self.softest ** (1 - min(parameter, 2.0)))

    def at(self, parameter: float) -> Balance:
        """The balance, the same for all."""
        return self.balance

    def law(self, parameter: float) -> SoftLaw:
        """The law at a value of the parameter."""
        return SoftLaw(**vars(self.friction), share=self._share(parameter))

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Rows) -> Floats:
        """dW/dp at fixed w, on the given components of w: (W_s - u)/s · ds/dp."""
        beyond = (deviation.w - self.balance.displacement(w)).reshape(-1)[rows]
        return np.asarray(-log(self.softest) * beyond)
