"""Contacts and structure stepped through a period together, compiled."""

from typing import NamedTuple

import numpy as np

from vanelock.common.arrays import Booleans, Complex, Floats, Integers
from vanelock.nonlinear.fourier import kernel
from vanelock.nonlinear.transient.full_ring import awaken, sweep

_SWEEPS = 400  # a step that takes more is counted as not solved


class Stepping(NamedTuple):
    """What stays as it is while a ring is stepped at one frequency, by diameter k and sector.

    `linear` (s, N, d): steady linear vibration, m; `rows` (k, d, n): of the modes with inertia;
    `transition` (k, 4, 4, n), `hold`, `rise` (k, 4, n): their steps; `rigid`, `response` (k, d, d):
    what a deviation moves through the other modes, and through all within a step, row by row;
    `coupling` (N, d, d): the latter, between sectors; `shift`, `weight`, `stiffness`: as of
    `FullRing`; `opened`: components open in the modes; `small`: change, m, of a solved step.
    """

    linear: Floats
    rows: Complex
    transition: Floats
    hold: Floats
    rise: Floats
    rigid: Complex
    response: Complex
    coupling: Floats
    shift: Complex
    weight: Floats
    stiffness: Floats
    alpha: Floats
    isotropic: bool
    opened: Integers
    small: float


class RingMotion(NamedTuple):
    """Where the ring is; `march` moves it on.

    `state` (k, 4, n) is what steps keep of each mode, y first, by diameter; `load` (k, n) and
    `static` (k, 3c) the modal loads of the deviations and their displacements through modes without
    inertia; `resting` (k, 3c) the contacts' displacements beside the steady vibration; `u` and `w`
    (N, 3c), m, their relative displacements and deviations from sticking; `awake` (c,) contacts
    whose deviations change.
    """

    state: Complex
    load: Complex
    static: Complex
    resting: Complex
    u: Floats
    w: Floats
    awake: Booleans


@kernel
def _gather(moved: Complex, free: Floats, shift: Complex, weight: Floats, u: Floats) -> None:
    """Displacements u (N, d): what is known plus amplitudes (k, d) by diameter."""
    u[:] = free
    for j in range(u.shape[0]):
        for k in range(moved.shape[0]):
            turn = weight[k] * shift[k, j]
            for a in range(u.shape[1]):
                u[j, a] += turn.real * moved[k, a].real - turn.imag * moved[k, a].imag


@kernel
def _predict(
    state: Complex, load: Complex, transition: Floats, hold: Floats, predicted: Complex
) -> None:
    """States (k, 4, n) at the end of the step under the load at its beginning."""
    for k in range(state.shape[0]):
        for e in range(4):
            for m in range(state.shape[2]):
                predicted[k, e, m] = (
                    transition[k, e, 0, m] * state[k, 0, m]
                    + transition[k, e, 1, m] * state[k, 1, m]
                    + transition[k, e, 2, m] * state[k, 2, m]
                    + transition[k, e, 3, m] * state[k, 3, m]
                    + hold[k, e, m] * load[k, m]
                )


@kernel
def _contacts(predicted: Complex, rows: Complex, static: Complex, free: Complex) -> None:
    """Displacements (k, d) of the contacts by diameter while no deviation changes."""
    for k in range(rows.shape[0]):
        for a in range(rows.shape[1]):
            total = static[k, a]
            for m in range(rows.shape[2]):
                total += rows[k, a, m] * predicted[k, 0, m]
            free[k, a] = total


@kernel
def _changes(
    w: Floats, w_before: Floats, shift: Complex, change: Complex, changed: Integers
) -> int:
    """Changes of the deviations in a step by diameter (k, d); how many columns are not zero."""
    sectors = w.shape[0]
    count = 0
    for a in range(w.shape[1]):
        found = False
        for k in range(change.shape[0]):
            change[k, a] = 0.0
        for j in range(sectors):
            moved = (w[j, a] - w_before[j, a]) / sectors
            if moved != 0.0:
                found = True
                for k in range(change.shape[0]):
                    change[k, a] += np.conj(shift[k, j]) * moved
        if found:
            changed[count] = a
            count += 1
    return count


@kernel
def _add(columns: Complex, change: Complex, changed: Integers, out: Complex) -> None:
    """Add to displacements (k, d) what the changes cause, `columns` (k, d, d) row by row."""
    for k in range(out.shape[0]):
        for a in changed:
            size = change[k, a]
            for b in range(out.shape[1]):
                out[k, b] += columns[k, a, b] * size


@kernel
def _commit(
    predicted: Complex, ring: Stepping, change: Complex, changed: Integers, now: RingMotion
) -> None:
    """States and loads at the end of the step."""
    push = np.empty_like(now.load[0])
    for k in range(predicted.shape[0]):
        push[:] = 0.0
        for a in changed:
            size = ring.stiffness[a] * change[k, a]
            for m in range(push.size):
                push[m] += np.conj(ring.rows[k, a, m]) * size
        now.load[k] += push
        for e in range(4):
            now.state[k, e] = predicted[k, e] + ring.rise[k, e] * push


@kernel
def _hold(opened: Integers, resting: Complex, free: Complex, change: Complex) -> None:
    """Changes (k, d) of what pulls at contacts open in the modes, their deviations held."""
    for k in range(resting.shape[0]):
        for a in opened:
            change[k, a] = resting[k, a] - free[k, a]


@kernel
def _pull(
    opened: Integers,
    resting: Complex,
    moved: Complex,
    change: Complex,
    changed: Integers,
    count: int,
) -> int:
    """Changes of what pulls (k, d), from those of the deviations; how many columns are not zero.

    Updates `resting` (k, d) to where the contacts moved.
    """
    for a in opened:
        known = False
        for i in range(count):
            known = known or changed[i] == a
        if not known:
            changed[count] = a
            count += 1
        for k in range(resting.shape[0]):
            change[k, a] -= moved[k, a] - resting[k, a]
    resting[:] = moved
    return count


@kernel
def march(ring: Stepping, now: RingMotion, path: Floats, places: Floats, motion: Complex) -> int:
    """One period of all sectors; returns how many steps were not solved."""
    predicted, known = np.empty_like(now.state), np.empty_like(now.static)
    moved = np.empty_like(now.static)
    change, changed = np.empty_like(now.static), np.empty(now.w.shape[1], np.int64)
    u, w, unsolved = now.u, now.w, 0
    for i in range(ring.linear.shape[0]):
        u_before, w_before = u.copy(), w.copy()
        _predict(now.state, now.load, ring.transition, ring.hold, predicted)
        _contacts(predicted, ring.rows, now.static, known)
        _hold(ring.opened, now.resting, known, change)
        _add(ring.response, change, ring.opened, known)
        _gather(known, ring.linear[i], ring.shift, ring.weight, u)
        while True:
            listed, sweeps = np.flatnonzero(now.awake), 1
            while sweeps < _SWEEPS and ring.small < sweep(
                u, w, u_before, w_before, ring.coupling, ring.alpha, ring.isotropic, listed
            ):
                sweeps += 1
            count = _changes(w, w_before, ring.shift, change, changed)
            moved[:] = known
            _add(ring.response, change, changed[:count], moved)
            _gather(moved, ring.linear[i], ring.shift, ring.weight, u)
            if not awaken(u, w, ring.alpha, ring.isotropic, now.awake):
                break
        if sweeps == _SWEEPS:
            unsolved += 1
        count = _pull(ring.opened, now.resting, moved, change, changed, count)
        _add(ring.rigid, change, changed[:count], now.static)
        _commit(predicted, ring, change, changed[:count], now)
        path[i], places[i], motion[i] = u, w, now.state[:, 0]
    return unsolved
