"""From contacts held by force, so that all stick, to contacts as they are.

Lifting off is judged by v + p·a, friction by v + p·b, with a and b so large that at p = 1 every
contact sticks under the linear response; at p = 0 the contact is itself. Each contact has its own a
and b, of the size that it needs: with one preload for all, as high as the contact of least friction
asks for, all that happens on the way would happen in the last millionth of it.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.contact.law import Deviation, Law
from vanelock.nonlinear.newton.law_jacobian import response_to

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

SURPLUS = 1.1
LEAST = 1e-3  # of the largest displacement, for contacts that hardly move


@dataclass(frozen=True, kw_only=True)
class HeldLaw(Law):
    """The law of contacts that are pressed and held back from outside.

    Both (c,), m, are added to v, where contacts lift off and where friction is bounded.
    """

    pressed: Floats
    held: Floats

    def __call__(self, u: Floats, omega: float = 0.0) -> Deviation:
        """Evaluate at the relative displacements (c, 3, 2H + 1), m, of (v, u1, u2)."""
        shifted = u.copy()
        shifted[:, 0, 0] = u[:, 0, 0] + self.held
        found = super().__call__(shifted, omega)
        shifted[:, 0, 0] = u[:, 0, 0] + self.pressed
        smooth = replace(self, alpha=np.zeros_like(self.alpha))
        normal = super(HeldLaw, smooth).__call__(shifted, omega)
        found.w[:, 0] = normal.w[:, 0]
        found.jacobian[:, 0] = normal.jacobian[:, 0]
        return found


@dataclass(frozen=True)
class Release:
    """Problems at one load, contacts held as by `HeldLaw` at p = 1 and themselves at p = 0."""

    balance: Balance
    friction: Law
    pressed: Floats
    held: Floats

    def at(self, parameter: float) -> Balance:
        """The balance, the same for all."""
        return self.balance

    def law(self, parameter: float) -> HeldLaw:
        """The law at a value of the parameter."""
        pressed, held = parameter * self.pressed, parameter * self.held
        return HeldLaw(**vars(self.friction), pressed=pressed, held=held)

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Rows) -> Floats:
        """dW/dp at fixed w, on the given components of w."""
        moved = np.zeros_like(w)
        moved[:, 0, 0] = self.pressed
        lifting = response_to(deviation, rows, moved)
        moved[:, 0, 0] = self.held
        sliding = response_to(deviation, rows, moved)
        return np.where(rows // w.shape[2] % 3 == 0, lifting, sliding)


def release(balance: Balance, law: Law) -> Release:
    """The family from contacts that all stick, held as much as each needs, to `law`."""
    size = np.abs(balance.linear).sum(axis=2)
    if law.isotropic:  # friction has to hold both directions at once
        size[:, 1:] = np.hypot(size[:, 1], size[:, 2])[:, None]
    least = LEAST * size.max(initial=0.0)
    pressed = SURPLUS * size[:, 0] + least
    alpha = np.where(law.alpha > 0, law.alpha, np.inf)
    held = pressed + SURPLUS * ((size[:, 1:] + least) / alpha).max(axis=1)
    pressed[list(law.elements)] = held[list(law.elements)] = 0.0
    return Release(balance, law, pressed, held)
