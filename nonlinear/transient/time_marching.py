"""Contacts and structure stepped through a period together, compiled.

Within a time step the relative displacements run straight from where they are to where they come to
rest at its end, u = known + G w, G the motion that the deviations w cause within the step. Along a
straight path the contact law is exact: a slider that meets its bound goes with it, and one that
comes back into contact holds on where the path crosses v = 0. The deviations at the end of the step
are one scalar problem each, of isotropic friction one of two unknowns (`_slider_in_plane`), solved
in turn, until none changes (nonlinear Gauss-Seidel).

For these the disc's centre moves straight and its radius linearly, so that the path has a closed
form (`disc_slider`): the place w at the end is a function P of the centre there, which w
itself moves,

    w = P(known + G w),

two equations, solved by Newton's method with the closed form's derivative. Where a step of it
does not come closer, one of the plain iteration is taken.
"""

import math
from typing import NamedTuple

import numpy as np

from vanelock.common.arrays import Booleans, Complex, Floats, Integers
from vanelock.nonlinear.contact.disc_slider import HELD, RATES, TO, pursue
from vanelock.nonlinear.fourier import kernel

_SWEEPS = 400  # a step that takes more is counted as not solved
_ITERATIONS = 60
_CLOSE = 1e-14  # of the displacements: what P(known + G w) may be off w at the end of the iteration


@kernel
def _slider_in_plane(
    free: Floats, G: Floats, held: Floats, start: Floats, r_start: float, r: float, slider: Floats
) -> None:
    """Place w of a slider at the end of a step, u = free + G w."""
    x, y, before = slider[0], slider[1], math.inf
    centre, following, rates = start.copy(), np.empty(2), np.empty((2, RATES))
    for _ in range(_ITERATIONS):
        centre[0] = free[0] + G[0, 0] * x + G[0, 1] * y
        centre[1] = free[1] + G[1, 0] * x + G[1, 1] * y
        kind, _ = pursue(held, start, centre, r_start, r, following, rates)
        fx, fy = following[0] - x, following[1] - y
        apart = math.hypot(fx, fy)
        size = abs(centre[0]) + abs(centre[1]) + abs(following[0]) + abs(following[1])
        if apart <= _CLOSE * size:
            break
        if apart >= before or (kind == HELD and r_start > 0.0):
            x, y, before = following[0], following[1], math.inf
            continue
        before = apart
        a, b = rates[0, TO], rates[0, TO + 1]
        c, d = rates[1, TO], rates[1, TO + 1]
        m00, m01 = (1.0 - a * G[0, 0] - b * G[1, 0], -a * G[0, 1] - b * G[1, 1])
        m10, m11 = (-c * G[0, 0] - d * G[1, 0], 1.0 - c * G[0, 1] - d * G[1, 1])
        det = m00 * m11 - m01 * m10
        x += (m11 * fx - m01 * fy) / det
        y += (m00 * fy - m10 * fx) / det
    slider[0], slider[1] = following[0], following[1]


@kernel
def _slider_place(
    free: float, G: float, held: float, u_before: float, v_before: float, v: float, alpha: float
) -> float:
    """Place w of a slider at the end of a step, u = free + G w."""
    if v <= 0.0:
        return free / (1.0 - G)
    place = held
    if v_before < 0.0:  # touches down on the way, unstressed
        share = v_before / (v_before - v)
        place = ((1.0 - share) * u_before + share * free) / (1.0 - share * G)
    apart = free + G * place - place
    if apart > alpha * v:
        return (free - alpha * v) / (1.0 - G)
    if apart < -alpha * v:
        return (free + alpha * v) / (1.0 - G)
    return place


@kernel
def _spread(
    u: Floats, coupling: Floats, sector: int, column: int, change: float, listed: Integers
) -> None:
    """Move the listed contacts of all sectors by the change of one deviation."""
    sectors = u.shape[0]
    for i in range(sectors):
        row = coupling[(i - sector) % sectors, column]
        for c in listed:
            u[i, 3 * c] += row[3 * c] * change
            u[i, 3 * c + 1] += row[3 * c + 1] * change
            u[i, 3 * c + 2] += row[3 * c + 2] * change


@kernel
def _sweep(
    u: Floats,
    w: Floats,
    u_before: Floats,
    w_before: Floats,
    coupling: Floats,
    alpha: Floats,
    isotropic: bool,
    listed: Integers,
) -> float:
    """Solve the listed contacts once, one after the other; the largest change of a deviation."""
    largest, places, free = 0.0, np.empty(3), np.empty(2)
    for j in range(u.shape[0]):
        for c in listed:
            for e in range(3):
                a = 3 * c + e
                own = coupling[0, a, a]
                known = u[j, a] - own * w[j, a]
                v_before, v = u_before[j, 3 * c], u[j, 3 * c]
                if e == 0:
                    places[0] = min(known, 0.0) / (1.0 - own)
                elif not isotropic:
                    places[e] = _slider_place(
                        known, own, w_before[j, a], u_before[j, a], v_before, v, alpha[c, e - 1]
                    )
                elif e == 1:
                    here, plane = w[j, a : a + 2], coupling[0, a : a + 2, a : a + 2].T
                    for i in range(2):
                        free[i] = u[j, a + i] - plane[i, 0] * here[0] - plane[i, 1] * here[1]
                    places[1:] = here
                    r_before, r = alpha[c, 0] * v_before, alpha[c, 0] * v
                    before, held = u_before[j, a : a + 2], w_before[j, a : a + 2]
                    _slider_in_plane(free, plane, held, before, r_before, r, places[1:])
                change = places[e] - w[j, a]
                if change != 0.0:
                    w[j, a] = places[e]
                    _spread(u, coupling, j, a, change, listed)
                    largest = max(largest, abs(change))
    return largest


@kernel
def follow(u: Floats, alpha: Floats, isotropic: bool, w: Floats) -> None:
    """Move the deviations w (N, 3c) along displacements u (s, N, 3c), which begin at u[0]."""
    for i in range(1, u.shape[0]):
        for j in range(u.shape[1]):
            for c in range(alpha.shape[0]):
                a, b = 3 * c, 3 * c + 3
                before, after, places = u[i - 1, j, a:b], u[i, j, a:b], w[j, a:b]
                places[0] = min(after[0], 0.0)
                if isotropic:
                    r0, r1 = alpha[c, 0] * before[0], alpha[c, 0] * after[0]
                    out, rates = np.empty(2), np.empty((2, RATES))
                    pursue(places[1:], before[1:], after[1:], r0, r1, out, rates)
                    places[1:] = out
                    continue
                for e in range(1, 3):
                    v_before, v, bound = before[0], after[0], alpha[c, e - 1]
                    places[e] = _slider_place(
                        after[e], 0.0, places[e], before[e], v_before, v, bound
                    )


@kernel
def _awaken(u: Floats, w: Floats, alpha: Floats, isotropic: bool, awake: Booleans) -> bool:
    """Mark sleeping contacts that no longer stick in some sector; whether there are any."""
    found = False
    for c in range(awake.size):
        if awake[c]:
            continue
        for j in range(u.shape[0]):
            v = u[j, 3 * c]
            x, y = u[j, 3 * c + 1] - w[j, 3 * c + 1], u[j, 3 * c + 2] - w[j, 3 * c + 2]
            beyond = abs(x) > alpha[c, 0] * v or abs(y) > alpha[c, 1] * v
            if isotropic:
                beyond = math.hypot(x, y) > alpha[c, 0] * v
            if v < 0.0 or beyond:
                awake[c] = True
                found = True
    return found


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
            while sweeps < _SWEEPS and ring.small < _sweep(
                u, w, u_before, w_before, ring.coupling, ring.alpha, ring.isotropic, listed
            ):
                sweeps += 1
            count = _changes(w, w_before, ring.shift, change, changed)
            moved[:] = known
            _add(ring.response, change, changed[:count], moved)
            _gather(moved, ring.linear[i], ring.shift, ring.weight, u)
            if not _awaken(u, w, ring.alpha, ring.isotropic, now.awake):
                break
        if sweeps == _SWEEPS:
            unsolved += 1
        count = _pull(ring.opened, now.resting, moved, change, changed, count)
        _add(ring.rigid, change, changed[:count], now.static)
        _commit(predicted, ring, change, changed[:count], now)
        path[i], places[i], motion[i] = u, w, now.state[:, 0]
    return unsolved
