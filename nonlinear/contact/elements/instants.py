"""Instants of a period that resolve the force of an element: panels, halved where it needs them.

Five Lobatto points in each of a few panels, which are halved until force and state of either half
agree with those of the whole. Kinks and jumps of the law so cost some twenty halvings and no error;
where the law remembers, panels begin and end where displacements turn back.
"""

import math
from typing import Any

import numpy as np

from vanelock.common.errors import InputError
from vanelock.nonlinear.contact.elements.marching import (
    LAPS,
    REPEATS,
    Samples,
    laps_of,
    samples_at,
    uniform,
)
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import (
    TURN,
    Floats,
    derivative,
    grid,
    roots,
    value_and_slope,
)
from vanelock.rom.system.element import Element

PANELS = 16
HALVINGS = 30
MOST = 10_000
"""Ends of panels, more than any law needs that rounding does not hide, or whose memory is of more
than the motion."""
RESOLVED = 1e-12
"""Of the largest force over all the period, and of the largest state: by how much a panel and its
halves may differ."""
NODES = np.array([-1.0, -math.sqrt(3 / 7), 0.0, math.sqrt(3 / 7), 1.0])
WEIGHTS = np.array([9.0, 49.0, 64.0, 49.0, 9.0]) / 90.0
"""Of Lobatto's rule on [-1, 1]."""


@kernel
def _panel(
    force: Any,
    u: Floats,
    omega: float,
    p: Floats,
    begin: float,
    end: float,
    state: Floats,
    sums: Floats,
) -> None:
    """Integrals (3, d) of f, f cos Hθ and f sin Hθ over a panel, its state carried to the end."""
    d, harmonics = u.shape[0], (u.shape[1] - 1) // 2
    x, v, f = np.empty(d), np.empty(d), np.empty(d)
    half = 0.5 * (end - begin)
    sums[:] = 0.0
    for i in range(NODES.size):
        angle = begin + half * (1.0 + NODES[i])
        for j in range(d):
            x[j], slope = value_and_slope(u[j], angle)
            v[j] = omega * slope
        force(x, v, state, p, f)
        weight = half * WEIGHTS[i]
        cos, sin = math.cos(harmonics * angle), math.sin(harmonics * angle)
        for j in range(d):
            sums[0, j] += weight * f[j]
            sums[1, j] += weight * f[j] * cos
            sums[2, j] += weight * f[j] * sin


@kernel
def _panels(
    force: Any,
    u: Floats,
    omega: float,
    p: Floats,
    state: Floats,
    largest: float,
    edges: Floats,
    ends: Floats,
) -> int:
    """Ends of panels within the edges, each fine enough, and their number; the state goes round."""
    d, n = u.shape[0], state.size
    whole, first, second = np.empty((3, d)), np.empty((3, d)), np.empty((3, d))
    coarse, fine = np.empty(n), np.empty(n)
    waiting = np.empty(HALVINGS + 2)
    size = np.abs(state).max() if n else 0.0
    ends[0], count = edges[0], 1
    for i in range(edges.size - 1):
        begin = edges[i]
        waiting[0], left = edges[i + 1], 1
        shortest = (waiting[0] - begin) * 0.5**HALVINGS
        while left > 0:
            end = waiting[left - 1]
            middle = 0.5 * (begin + end)
            coarse[:], fine[:] = state, state
            _panel(force, u, omega, p, begin, end, coarse, whole)
            _panel(force, u, omega, p, begin, middle, fine, first)
            _panel(force, u, omega, p, middle, end, fine, second)
            close = np.abs(first + second - whole).max() <= RESOLVED * TURN * largest
            for j in range(n):
                size = max(size, abs(fine[j]))
                close = close and abs(coarse[j] - fine[j]) <= RESOLVED * size
            if close or end - begin <= shortest or count > MOST:
                if count + 2 > ends.size:
                    return count
                ends[count], ends[count + 1], count = middle, end, count + 2
                state[:] = fine
                begin = end
                left -= 1
            else:
                waiting[left] = middle
                left += 1
    return count


def resolved(law: Any, element: Element, u: Floats, omega: float, counts: float) -> Samples:
    """Instants that resolve the force of an element; see `periodic_force`."""
    harmonics, parameters = (u.shape[1] - 1) // 2, np.asarray(element.parameters)
    count = max(PANELS, 4 * harmonics)
    scanned = laps_of(law, element, u, omega, uniform(harmonics, 4 * count))
    largest, state = max(float(np.abs(scanned[2]).max()), counts), np.zeros(element.memory)
    edges = TURN * np.arange(count + 1) / count
    if element.memory:
        edges = np.unique(np.concatenate([edges, *(_turns(each) for each in u)]))
    ends = np.empty(2 * MOST)
    for _ in range(LAPS):
        begun = state.copy()
        found = _panels(law, u, omega, parameters, state, largest, edges, ends)
        if np.abs(state - begun).max(initial=0.0) <= REPEATS * np.abs(state).max(initial=0.0):
            break
    if element.memory and found > MOST:
        raise InputError(
            f"Element {element.name!r}: its force changes with every finer division of the period: "
            "what it remembers must be of the motion alone, or samples be given"
        )
    bounds = ends[:found]
    half = 0.5 * np.diff(bounds)[:, None]
    angles = (bounds[:-1, None] + half * (1 + NODES)).reshape(-1)
    return samples_at(harmonics, angles, (half * WEIGHTS).reshape(-1))


def _turns(u: Floats) -> Floats:
    """Angles at which a displacement turns back."""
    found = np.empty(2 * len(u))
    return found[: roots(derivative(u), grid(len(u) // 2), found)]
