"""Contacts and structure stepped through a period together, compiled."""

import numpy as np

from vanelock.common.arrays import Booleans, Complex, Floats, Integers
from vanelock.nonlinear.fourier import kernel
from vanelock.nonlinear.transient.full_ring import awaken, sweep

_SWEEPS = 400  # a step that takes more is counted as not solved


@kernel
def _gather(moved: Complex, free: Floats, shift: Complex, weight: Floats, u: Floats) -> None:
    """Displacements u (N, d): what is known plus amplitudes (k, d) by diameter."""
    for j in range(u.shape[0]):
        for a in range(u.shape[1]):
            u[j, a] = free[j, a]
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
def _add(columns: Complex, change: Complex, changed: Integers, count: int, out: Complex) -> None:
    """Add to displacements (k, d) what the changes cause, `columns` (k, d, d) row by row."""
    for k in range(out.shape[0]):
        for i in range(count):
            a = changed[i]
            size = change[k, a]
            for b in range(out.shape[1]):
                out[k, b] += columns[k, a, b] * size


@kernel
def _commit(
    predicted: Complex,
    rows: Complex,
    rise: Floats,
    stiffness: Floats,
    change: Complex,
    changed: Integers,
    count: int,
    state: Complex,
    load: Complex,
    push: Complex,
) -> None:
    """States and loads at the end of the step."""
    modes = state.shape[2]
    for k in range(state.shape[0]):
        for m in range(modes):
            push[m] = 0.0
        for i in range(count):
            a = changed[i]
            size = stiffness[a] * change[k, a]
            for m in range(modes):
                push[m] += np.conj(rows[k, a, m]) * size
        for m in range(modes):
            load[k, m] += push[m]
            for e in range(4):
                state[k, e, m] = predicted[k, e, m] + rise[k, e, m] * push[m]


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
    for k in range(resting.shape[0]):
        for a in range(resting.shape[1]):
            resting[k, a] = moved[k, a]
    return count


@kernel
def _copy(source: Floats, target: Floats) -> None:
    """Copy (N, d)."""
    for j in range(source.shape[0]):
        for a in range(source.shape[1]):
            target[j, a] = source[j, a]


@kernel
def _list(awake: Booleans, listed: Integers) -> int:
    """Write the contacts that are awake; how many."""
    count = 0
    for c in range(awake.size):
        if awake[c]:
            listed[count] = c
            count += 1
    return count


@kernel
def march(
    linear: Floats,
    rows: Complex,
    transition: Floats,
    hold: Floats,
    rise: Floats,
    rigid: Complex,
    response: Complex,
    coupling: Floats,
    shift: Complex,
    weight: Floats,
    stiffness: Floats,
    alpha: Floats,
    isotropic: bool,
    opened: Integers,
    small: float,
    state: Complex,
    load: Complex,
    static: Complex,
    resting: Complex,
    u: Floats,
    w: Floats,
    awake: Booleans,
    path: Floats,
    places: Floats,
    motion: Complex,
) -> int:
    """One period of all sectors; returns how many steps were not solved."""
    predicted = np.empty_like(state)
    known, moved, change = np.empty_like(static), np.empty_like(static), np.empty_like(static)
    push = np.empty_like(load[0])
    u_before, w_before = np.empty_like(u), np.empty_like(w)
    changed, listed = np.empty(w.shape[1], np.int64), np.empty(awake.size, np.int64)
    unsolved = 0
    for i in range(linear.shape[0]):
        _copy(u, u_before)
        _copy(w, w_before)
        _predict(state, load, transition, hold, predicted)
        _contacts(predicted, rows, static, known)
        _hold(opened, resting, known, change)
        _add(response, change, opened, opened.size, known)
        _gather(known, linear[i], shift, weight, u)
        while True:
            awake_count = _list(awake, listed)
            sweeps = 1
            while sweeps < _SWEEPS and small < sweep(
                u, w, u_before, w_before, coupling, alpha, isotropic, listed[:awake_count]
            ):
                sweeps += 1
            count = _changes(w, w_before, shift, change, changed)
            for k in range(known.shape[0]):
                for a in range(known.shape[1]):
                    moved[k, a] = known[k, a]
            _add(response, change, changed, count, moved)
            _gather(moved, linear[i], shift, weight, u)
            if not awaken(u, w, alpha, isotropic, awake):
                break
        if sweeps == _SWEEPS:
            unsolved += 1
        count = _pull(opened, resting, moved, change, changed, count)
        _add(rigid, change, changed, count, static)
        _commit(predicted, rows, rise, stiffness, change, changed, count, state, load, push)
        _copy(u, path[i])
        _copy(w, places[i])
        for k in range(state.shape[0]):
            for m in range(state.shape[2]):
                motion[i, k, m] = state[k, 0, m]
    return unsolved
