"""One time step of linear modes under a load that is known at the ends of steps.

A mode obeys Λ y'' + D y' + A y = r(t). With its state s = (y, τ y', ., .), τ the step, and the
load's change Δr in the step,

    s_next = E s + hold r + rise Δr.

A mode that turns by at most a radian in a step is integrated exactly under a load that is linear
within steps. Chords of a smooth load lie off it by τ² r''/12 in the mean, and chords across a
kink of a load by a twelfth of its change of slope times τ, in the mean of the places where it may
lie. So the chords are drawn through r - δ²r/12 instead, δ² the second difference of the last three
values; the state keeps what that takes. Stiffer modes follow Wood, Bossak and Zienkiewicz (1980)
with α = -1, s = (y, τ y', τ² y'', 0): of second order, stable, and what they do not resolve dies
out, so that they become quasi-static. In both, 0 <= rise < 1 for y: the deviation of a contact from
sticking and the motion it causes in the step are bound by a monotone relation.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RESOLVED = 1.0
"""Largest turn of a mode in a step, rad, up to which it is integrated exactly."""


@dataclass(frozen=True)
class Steps:
    """One step of n modes.

    Attributes
    ----------
    transition : (4, 4, n) float
        E.
    hold : (4, n) float
        Response to the load at the beginning.
    rise : (4, n) float
        Response to its change.
    """

    transition: Floats
    hold: Floats
    rise: Floats


def steps_of(
    compliance: Floats, damping: Floats, step: float, static: Floats | None = None
) -> Steps:
    """The step of modes with compliance Λ, s²/rad², and damping D, s/rad; `step` in s.

    A is 1 if `static` is not given. Given, the load is that of springs as well, which their own
    motion sets: through r itself chords are drawn then, since what the past corrects might grow.
    """
    n = len(compliance)
    corrected, static = static is None, np.ones(n) if static is None else static
    transition, hold, rise = np.zeros((4, 4, n)), np.zeros((4, n)), np.zeros((4, n))
    slow = compliance * RESOLVED**2 >= static * step**2
    if np.any(slow):
        exact = _exact(compliance[slow] / step**2, static[slow], damping[slow] / step, corrected)
        transition[:, :, slow], hold[:, slow], rise[:, slow] = exact
    if not np.all(slow):
        implicit = _implicit(compliance[~slow] / step**2, static[~slow], damping[~slow] / step)
        transition[:, :, ~slow], hold[:, ~slow], rise[:, ~slow] = implicit
    return Steps(transition, hold, rise)


def _exact(
    compliance: Floats, static: Floats, damping: Floats, corrected: bool
) -> tuple[Floats, Floats, Floats]:
    """By the exponential of the mode and its load; the state is (y, τ y', e, Δr).

    e is what the load r is corrected by, -δ²r/12.
    """
    n = len(compliance)
    rate = np.zeros((n, 4, 4))
    rate[:, 0, 1] = rate[:, 2, 3] = 1.0
    rate[:, 1, 0], rate[:, 1, 2] = -static / compliance, 1 / compliance
    rate[:, 1, 1] = -damping / compliance
    moved = la.expm(rate)
    constant, ramp = moved[:, :2, 2].T, moved[:, :2, 3].T
    transition, hold, rise = np.zeros((4, 4, n)), np.zeros((4, n)), np.zeros((4, n))
    transition[:2, :2] = np.moveaxis(moved[:, :2, :2], 0, -1)
    if not corrected:
        hold[:2], rise[:2] = constant, ramp
        return transition, hold, rise
    transition[:2, 2] = constant - ramp
    transition[:2, 3] = ramp / 12
    transition[2, 3] = 1 / 12
    hold[:2], rise[:2] = constant, ramp * 11 / 12
    rise[2], rise[3] = -1 / 12, 1.0
    return transition, hold, rise


def _implicit(compliance: Floats, static: Floats, damping: Floats) -> tuple[Floats, Floats, Floats]:
    """Newmark's formulas with β = 1, γ = 3/2, Λ (2 y''_next - y'') + D y'_next + A y_next = r."""
    n = len(compliance)
    # Displacement and velocity before the new acceleration is added.
    y = np.array([np.ones(n), np.ones(n), np.full(n, -0.5)])
    v = np.array([np.zeros(n), np.ones(n), np.full(n, -0.5)])
    inertia = 2 * compliance + 1.5 * damping + static
    a = (np.array([np.zeros(n), np.zeros(n), compliance]) - damping * v - static * y) / inertia
    transition, load = np.zeros((4, 4, n)), np.zeros((4, n))
    transition[:3, :3] = [y + a, v + 1.5 * a, a]
    load[:3] = np.array([np.ones(n), np.full(n, 1.5), np.ones(n)]) / inertia
    return transition, load, load.copy()
