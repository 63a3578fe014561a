"""Coefficients of the force of any element over a period, by alternating frequency and time.

The force is taken at instants of the period and projected on the harmonics (Cameron & Griffin
1989): on uniform samples if their number is given, else where the force itself asks for them
(`_resolved`).

Derivatives are central differences of the law at each instant; where the law remembers, those of
its state are carried along. An element with a memory runs round the period until it repeats.

These are five Lobatto points in each of a few panels, which are halved until force and state of
either half agree with those of the whole. Kinks and jumps of the law so cost some twenty halvings
and no error; where the law remembers, panels begin and end where displacements turn back.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import numba
import numpy as np
from numba import float64, types

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.fourier import TURN, basis, derivative, grid, kernel, roots, value_and_slope
from vanelock.rom.system.element import Element, Force

_LAPS = 64
_REPEATS = 1e-13  # of the largest state: how closely it must return
_SIGNATURE = types.void(float64[::1], float64[::1], float64[::1], float64[::1], float64[::1])
_PANELS = 16
_HALVINGS = 30
_MOST = 10_000
"""Ends of panels, more than any law needs that rounding does not hide, or whose memory is of more
than the motion."""
_RESOLVED = 1e-12
"""Of the largest force over all the period, and of the largest state: by how much a panel and its
halves may differ."""
_NODES = np.array([-1.0, -math.sqrt(3 / 7), 0.0, math.sqrt(3 / 7), 1.0])
_WEIGHTS = np.array([9.0, 49.0, 64.0, 49.0, 9.0]) / 90.0  # of Lobatto's rule on [-1, 1]
_DIFFERENCE = 2e-9
"""Step of differences over the largest value: where a slider turns back, two instants may be as
close, and longer steps would pass the law's kink between them. Rounding leaves 1e-7; steps are
powers of two, so that it leaves nothing where a state stays as it is, many instants long."""


@lru_cache(maxsize=256)
def _compiled(function: Force, name: str) -> Any:
    """The law, compiled."""
    try:
        return numba.cfunc(_SIGNATURE)(function)
    except (numba.core.errors.NumbaError, TypeError) as error:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        why = next((line for line in lines if "Error" in line), lines[0])
        raise InputError(f"Element {name!r}: force cannot be compiled: {why}") from None


class _Samples(NamedTuple):
    """φ and its derivative (s, m) at instants; what projects values there on harmonics (m, s)."""

    table: Floats
    slope: Floats
    project: Floats


def _samples_at(harmonics: int, angles: Floats, weights: Floats) -> _Samples:
    """Instants by their angles (s,), and what each counts in an integral over θ."""
    table = basis(harmonics, angles)
    slope = np.zeros_like(table)
    h = np.arange(1, harmonics + 1)
    slope[:, 1::2] = h * table[:, 2::2]
    slope[:, 2::2] = -h * table[:, 1::2]
    project = table.T * (weights / np.pi)
    project[0] *= 0.5
    return _Samples(table, slope, project)


@lru_cache(maxsize=64)
def _uniform(harmonics: int, count: int) -> _Samples:
    """Uniform samples of a period."""
    return _samples_at(harmonics, TURN * np.arange(count) / count, np.full(count, TURN / count))


@kernel
def _march(
    force: Any, u: Floats, rate: Floats, p: Floats, state: Floats, forces: Floats, before: Floats
) -> None:
    """Forces (s, d) once round the period, and the states (s, n) that each sample began with."""
    for i in range(len(u)):
        before[i] = state
        force(u[i], rate[i], state, p, forces[i])


def _laps_of(
    law: Any, element: Element, u: Floats, omega: float, on: _Samples
) -> tuple[Floats, Floats, Floats, list[Floats]]:
    """Displacements, velocities and the last lap's forces (s, d); states (s, n) of every lap."""
    moved = np.ascontiguousarray(on.table @ u.T)
    rate = np.ascontiguousarray(omega * (on.slope @ u.T))
    forces, state, laps = np.empty_like(moved), np.zeros(element.memory), []
    while True:
        before = np.empty((len(moved), element.memory))
        _march(law, moved, rate, np.asarray(element.parameters), state, forces, before)
        laps.append(before)
        least = _REPEATS * np.abs(before).max(initial=0.0)
        if np.abs(state - before[0]).max(initial=0.0) <= least or len(laps) == _LAPS:
            return moved, rate, forces, laps


@kernel
def _panel(
    force: Any, u: Floats, omega: float, p: Floats, begin: float, end: float, state: Floats
) -> Floats:
    """Integrals (3, d) of f, f cos Hθ and f sin Hθ over a panel, its state carried to the end."""
    d, harmonics = u.shape[0], (u.shape[1] - 1) // 2
    x, v, f, sums = np.empty(d), np.empty(d), np.empty(d), np.zeros((3, d))
    half = 0.5 * (end - begin)
    for i in range(_NODES.size):
        angle = begin + half * (1.0 + _NODES[i])
        for j in range(d):
            x[j], slope = value_and_slope(u[j], angle)
            v[j] = omega * slope
        force(x, v, state, p, f)
        weight = half * _WEIGHTS[i]
        cos, sin = math.cos(harmonics * angle), math.sin(harmonics * angle)
        for j in range(d):
            sums[0, j] += weight * f[j]
            sums[1, j] += weight * f[j] * cos
            sums[2, j] += weight * f[j] * sin
    return sums


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
    n = state.size
    coarse, fine = np.empty(n), np.empty(n)
    waiting = np.empty(_HALVINGS + 2)
    size = np.abs(state).max() if n else 0.0
    ends[0], count = edges[0], 1
    for i in range(edges.size - 1):
        begin = edges[i]
        waiting[0], left = edges[i + 1], 1
        shortest = (waiting[0] - begin) * 0.5**_HALVINGS
        while left > 0:
            end = waiting[left - 1]
            middle = 0.5 * (begin + end)
            coarse[:], fine[:] = state, state
            whole = _panel(force, u, omega, p, begin, end, coarse)
            first = _panel(force, u, omega, p, begin, middle, fine)
            second = _panel(force, u, omega, p, middle, end, fine)
            close = np.abs(first + second - whole).max() <= _RESOLVED * TURN * largest
            for j in range(n):
                size = max(size, abs(fine[j]))
                close = close and abs(coarse[j] - fine[j]) <= _RESOLVED * size
            if close or end - begin <= shortest or count > _MOST:
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


def _resolved(law: Any, element: Element, u: Floats, omega: float, counts: float) -> _Samples:
    """Instants that resolve the force of an element; see `periodic_force`."""
    harmonics, parameters = (u.shape[1] - 1) // 2, np.asarray(element.parameters)
    count = max(_PANELS, 4 * harmonics)
    scanned = _laps_of(law, element, u, omega, _uniform(harmonics, 4 * count))
    largest, state = max(float(np.abs(scanned[2]).max()), counts), np.zeros(element.memory)
    edges = TURN * np.arange(count + 1) / count
    if element.memory:
        edges = np.unique(np.concatenate([edges, *(_turns(each) for each in u)]))
    ends = np.empty(2 * _MOST)
    for _ in range(_LAPS):
        begun = state.copy()
        found = _panels(law, u, omega, parameters, state, largest, edges, ends)
        if np.abs(state - begun).max(initial=0.0) <= _REPEATS * np.abs(state).max(initial=0.0):
            break
    if element.memory and found > _MOST:
        raise InputError(
            f"Element {element.name!r}: its force changes with every finer division of the period: "
            "what it remembers must be of the motion alone, or samples be given"
        )
    bounds = ends[:found]
    half = 0.5 * np.diff(bounds)[:, None]
    angles = (bounds[:-1, None] + half * (1 + _NODES)).reshape(-1)
    return _samples_at(harmonics, angles, (half * _WEIGHTS).reshape(-1))


def _turns(u: Floats) -> Floats:
    """Angles at which a displacement turns back."""
    found = np.empty(2 * len(u))
    return found[: roots(derivative(u), grid(len(u) // 2), found)]


@kernel
def _chain(
    by: Floats, phi: Floats, dphi: Floats, rate: Floats, omega: float, states: Floats, out: Floats
) -> None:
    """Derivatives (e, dm + 1) at an instant from those (2d + n, e) to u, its rate and the state."""
    d, m = rate.size, phi.size
    for e in range(out.shape[0]):
        last = 0.0
        for j in range(d):
            by_u, by_rate = by[j, e], omega * by[d + j, e]
            for a in range(m):
                out[e, j * m + a] = by_u * phi[a] + by_rate * dphi[a]
            last += by[d + j, e] * rate[j]
        out[e, d * m] = last / omega if omega > 0.0 else 0.0
        for q in range(states.shape[0]):
            by_state = by[2 * d + q, e]
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


_Derived: TypeAlias = tuple[Floats, Floats, Floats]
"""A force (d, m), N, and its derivatives: to the coefficients of u, (d, m, d, m) N/m, and to the
circular frequency, u held, (d, m) N s."""


def periodic_force(
    element: Element, u: Floats, omega: float, samples: int | None = None, counts: float = 0.0
) -> _Derived:
    """The force of an element under periodic displacements, and its derivatives."""
    law, parameters = _compiled(element.function, element.name), np.asarray(element.parameters)
    harmonics, m = (u.shape[1] - 1) // 2, u.shape[1]
    if harmonics == 0 or samples is not None:
        on = _uniform(harmonics, samples or 1)
    else:
        on = _resolved(law, element, np.ascontiguousarray(u), omega, counts)
    moved, rate, forces, laps = _laps_of(law, element, u, omega, on)
    s, d = moved.shape
    sizes = np.concatenate([_sizes(moved), _sizes(rate), _sizes(laps[-1])])
    steps = 2.0 ** np.floor(np.log2(_DIFFERENCE * sizes))
    states, slopes = np.zeros((element.memory, d * m + 1)), np.empty((s, d, d * m + 1))
    for lap in range(_LAPS):  # once with each lap's own states, on with the last lap's
        begun = states.copy()
        before = laps[min(lap, len(laps) - 1)]
        _differentiate(
            law, moved, rate, parameters, before, steps, on.table, on.slope, omega, states, slopes
        )
        repeats = np.abs(states - begun).max(initial=0.0) <= _REPEATS * np.abs(begun).max(initial=0)
        if lap + 1 >= len(laps) and repeats:
            break
    found = np.tensordot(on.project, slopes, axes=(1, 0)).transpose(1, 0, 2)
    jacobian = found[:, :, :-1].reshape(d, m, d, m)
    return (on.project @ forces).T, jacobian, found[:, :, -1]


def _sizes(values: Floats) -> Floats:
    """The largest size of each column (s, k); of what does not move, the largest of all."""
    sizes = np.abs(values).max(axis=0)
    largest = sizes.max(initial=0.0)
    return np.where(sizes > 0, sizes, largest if largest > 0 else 1.0)
