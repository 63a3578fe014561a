"""The contact element under given motions, in the three conditions of the published Figure 8.

    u(t) = U cos θ,    v(t) = v0 + V cos(θ - lag)

In phase without lift-off; with partial lift-off, V > v0; out of phase. The loop is exact at every
instant, its energy checked by the same element marched sample by sample.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.forced_response.hysteresis_loop import slider_history
from vanelock.nonlinear.fourier.trigonometric import TURN
from vanelock.nonlinear.verification.marched_contact import march_contacts
from vanelock.rom import Contacts

Floats = NDArray[np.float64]

SAMPLES = 2048
MARCHED = 1 << 16
TITLES = ("in phase", "partial lift-off", "out of phase")
NORMAL = (0.6, 1.6, 0.6)
"""Amplitude V of the normal motion over the interference."""
LAG = (0.0, 0.0, 90.0)
"""Degrees by which it lags behind the sliding."""
SLIDING = 3.0
"""Amplitude U over the displacement at which friction's bound at rest is reached."""


@dataclass(frozen=True)
class PrescribedLoop:
    """One condition.

    Attributes
    ----------
    title : str
    displacement : (s, 3) float
        v, u and 0 at equal steps of a period, m.
    force : (s, 3) float
        n, t and 0, N.
    mu : float
    energy : float
        Friction takes in a cycle, J.
    marched : float
        The same from the element marched sample by sample, J.
    opened : float
        Share of the period without contact.
    """

    title: str
    displacement: Floats
    force: Floats
    mu: float
    energy: float
    marched: float
    opened: float


def conditions(kn: float, kt: float, mu: float, interference: float) -> tuple[PrescribedLoop, ...]:
    """Loops of the three conditions, for the stiffness [N/m] and interference [m] of a joint."""
    angle = TURN * np.arange(SAMPLES) / SAMPLES
    alpha = mu * kn / kt
    sliding = SLIDING * alpha * interference
    found = []
    for title, normal, lag in zip(TITLES, NORMAL, LAG, strict=True):
        turn, size = np.radians(lag), normal * interference
        v = np.array([interference, size * np.cos(turn), -size * np.sin(turn)])
        u = np.array([0.0, sliding, 0.0])
        place = slider_history(v, u, alpha, angle)
        at_v = interference + size * np.cos(angle - turn)
        at_u = sliding * np.cos(angle)
        closed = at_v > 0
        n = np.where(closed, kn * at_v, 0.0)
        t = np.where(closed, kt * (at_u - place), 0.0)
        zero = np.zeros(SAMPLES)
        moved = np.zeros((2, 1, 3), complex)
        moved[0, 0, 0] = interference
        moved[1, 0, :2] = size * np.exp(-1j * turn), sliding
        one = Contacts(np.array([kn]), np.full((1, 2), kt), np.array([mu]), np.zeros(1))
        found.append(
            PrescribedLoop(
                title=title,
                displacement=np.column_stack([at_v, at_u, zero]),
                force=np.column_stack([n, t, zero]),
                mu=mu,
                energy=_energy(at_u, t),
                marched=float(march_contacts(one, moved, MARCHED).work[0]),
                opened=float(np.mean(~closed)),
            )
        )
    return tuple(found)


def _energy(u: Floats, t: Floats) -> float:
    """∮ t du, trapezoidal."""
    step = np.roll(u, -1) - u
    return float(np.sum((t + np.roll(t, -1)) / 2 * step))
