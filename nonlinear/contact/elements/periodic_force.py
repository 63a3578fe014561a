"""Coefficients of the force of any element over a period, by alternating frequency and time.

The force is taken at instants of the period and projected on the harmonics (Cameron & Griffin
1989): on uniform samples if their number is given, else where the force itself asks for them
(`instants`).

Derivatives are central differences of the law at each instant; where the law remembers, those of
its state are carried along. An element with a memory runs round the period until it repeats.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vanelock.nonlinear.contact.elements.instants import resolved
from vanelock.nonlinear.contact.elements.marching import (
    LAPS,
    REPEATS,
    Samples,
    compiled,
    laps_of,
    uniform,
)
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import Floats
from vanelock.rom.system.element import Element

DIFFERENCE = 2e-9
"""Step of differences over the largest value: where a slider turns back, two instants may be as
close, and longer steps would pass the law's kink between them. Rounding leaves 1e-7; steps are
powers of two, so that it leaves nothing where a state stays as it is, many instants long."""


@kernel
def _chain(
    slopes: Floats,
    table: Floats,
    slope: Floats,
    rate: Floats,
    omega: float,
    states: Floats,
    out: Floats,
) -> None:
    """Derivatives (e, dm + 1) at an instant from those (2d + n, e) to u, its rate and the state."""
    d, m = rate.size, table.size
    for e in range(out.shape[0]):
        last = 0.0
        for j in range(d):
            by_u, by_rate = slopes[j, e], omega * slopes[d + j, e]
            for a in range(m):
                out[e, j * m + a] = by_u * table[a] + by_rate * slope[a]
            last += slopes[d + j, e] * rate[j]
        out[e, d * m] = last / omega if omega > 0.0 else 0.0
        for q in range(states.shape[0]):
            by_state = slopes[2 * d + q, e]
            for a in range(out.shape[1]):
                out[e, a] += by_state * states[q, a]


@kernel
def _differentiate(
    force: Any,
    u: Floats,
    rate: Floats,
    p: Floats,
    before: Floats,
    steps: Floats,
    table: Floats,
    slope: Floats,
    omega: float,
    states: Floats,
    out: Floats,
) -> None:
    """Derivatives (s, d, dm + 1) of the forces to all coefficients of u, and to ω, u held.

    `states` (n, dm + 1) are those of the state, at the first sample; those after the last one are
    left there.
    """
    d, n, m = u.shape[1], before.shape[1], table.shape[1]
    x, v, state = np.empty(d), np.empty(d), np.empty(n)
    ahead, behind, reached = np.empty(d), np.empty(d), np.empty(n)
    of_force, of_state = np.empty((2 * d + n, d)), np.empty((2 * d + n, n))
    following = np.empty((n, d * m + 1))
    for i in range(len(u)):
        for j in range(2 * d + n):
            for sign in (1.0, -1.0):
                x[:], v[:], state[:] = u[i], rate[i], before[i]
                if j < d:
                    x[j] += sign * steps[j]
                elif j < 2 * d:
                    v[j - d] += sign * steps[j]
                else:
                    state[j - 2 * d] += sign * steps[j]
                force(x, v, state, p, ahead if sign > 0 else behind)
                if sign > 0:
                    reached[:] = state
            of_force[j] = (ahead - behind) / (2 * steps[j])
            of_state[j] = (reached - state) / (2 * steps[j])
        _chain(of_force, table[i], slope[i], rate[i], omega, states, out[i])
        if n:
            _chain(of_state, table[i], slope[i], rate[i], omega, states, following)
            states[:] = following


@dataclass(frozen=True)
class PeriodicForce:
    """Coefficients of an element's force, and their derivatives.

    Attributes
    ----------
    force : (d, m) float
        N.
    jacobian : (d, m, d, m) float
        To the coefficients of u, N/m.
    by_omega : (d, m) float
        To the circular frequency, u held, N s.
    """

    force: Floats
    jacobian: Floats
    by_omega: Floats


def periodic_force(
    element: Element, u: Floats, omega: float, samples: int | None = None, counts: float = 0.0
) -> PeriodicForce:
    """The force of an element under periodic displacements."""
    law = compiled(element.function, element.name)
    harmonics = (u.shape[1] - 1) // 2
    if harmonics == 0 or samples is not None:
        on = uniform(harmonics, samples or 1)
    else:
        on = resolved(law, element, np.ascontiguousarray(u), omega, counts)
    return _on(law, element, u, omega, on)


def _on(law: Any, element: Element, u: Floats, omega: float, on: Samples) -> PeriodicForce:
    """The force on given samples, and its derivatives."""
    moved, rate, forces, laps = laps_of(law, element, u, omega, on)
    (s, d), m = moved.shape, u.shape[1]
    sizes = np.concatenate([_sizes(moved), _sizes(rate), _sizes(laps[-1])])
    steps = 2.0 ** np.floor(np.log2(DIFFERENCE * sizes))
    parameters = np.asarray(element.parameters)
    states, slopes = np.zeros((element.memory, d * m + 1)), np.empty((s, d, d * m + 1))
    for lap in range(LAPS):  # once with each lap's own states, on with the last lap's
        begun = states.copy()
        before = laps[min(lap, len(laps) - 1)]
        _differentiate(
            law, moved, rate, parameters, before, steps, on.table, on.slope, omega, states, slopes
        )
        repeats = np.abs(states - begun).max(initial=0.0) <= REPEATS * np.abs(begun).max(initial=0)
        if lap + 1 >= len(laps) and repeats:
            break
    found = np.tensordot(on.project, slopes, axes=(1, 0)).transpose(1, 0, 2)
    jacobian = found[:, :, :-1].reshape(d, m, d, m)
    return PeriodicForce((on.project @ forces).T, jacobian, found[:, :, -1])


def _sizes(values: Floats) -> Floats:
    """The largest size of each column (s, k); of what does not move, the largest of all."""
    sizes = np.abs(values).max(axis=0)
    largest = sizes.max(initial=0.0)
    return np.where(sizes > 0, sizes, largest if largest > 0 else 1.0)
