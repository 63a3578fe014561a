"""The contact law with isotropic friction: |t| <= μ n in the tangential plane.

The law is that of the polygon through samples of (u1, u2) and of the bound α v: between samples the
slider's path has a closed form (`disc_slider`), so that coefficients are of second order in the
sampling, touch-downs and partial slip included. The normal direction is exact, as elsewhere.

A contact that opens forgets: one lap from an open instant is the periodic path. One that stays
closed either finds a place where it sticks for good (`rest_position`), or it slips in every period;
its periodic path is then unique, and Newton's iteration on one lap's map of the plane finds it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.contact.isotropic.disc_slider import (
    FREE,
    FROM,
    HELD,
    LARGER,
    RATES,
    SLIPPING,
    SMALLER,
    START,
    TO,
    pursue,
)
from vanelock.nonlinear.contact.isotropic.rest_position import NONE, rest_point, rest_rates
from vanelock.nonlinear.contact.normal import ALWAYS, CLOSED, add_normal, place
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import Floats, roots, spread

LAPS = 200
FINEST = 1e-14
"""Of the vibration: a disc whose slider has the displacements of its centre to their last digit."""


@kernel
def _lap(centre: Floats, radius: Floats, begin: Floats, end: Floats, turn: Floats) -> None:
    """Once round from a slider at `begin` at the first sample; `turn` is d end / d begin."""
    size = radius.size
    rates, following = np.empty((2, RATES)), np.empty(2)
    turn[0, 0] = turn[1, 1] = 1.0
    turn[0, 1] = turn[1, 0] = 0.0
    end[0], end[1] = begin[0], begin[1]
    for i in range(size):
        j = i + 1 if i + 1 < size else 0
        kind, _ = pursue(end, centre[i], centre[j], radius[i], radius[j], following, rates)
        if kind == HELD:
            continue
        end[0], end[1] = following[0], following[1]
        for k in range(2):
            x, y = turn[0, k], turn[1, k]
            turn[0, k] = rates[0, START] * x + rates[0, START + 1] * y
            turn[1, k] = rates[1, START] * x + rates[1, START + 1] * y


@kernel
def periodic_start(centre: Floats, radius: Floats, begin: Floats) -> None:
    """Where at the first sample the slider of a closed contact that slips is in its periodic path.

    One lap never moves two sliders apart, so a plain lap is safe where Newton's step is not better.
    """
    size = 0.0
    for i in range(radius.size):
        size = max(size, abs(centre[i, 0]), abs(centre[i, 1]))
    end, turn = np.empty(2), np.empty((2, 2))
    trial, trial_end, trial_turn = np.empty(2), np.empty(2), np.empty((2, 2))
    begin[0], begin[1] = centre[:, 0].mean(), centre[:, 1].mean()
    _lap(centre, radius, begin, end, turn)
    gap = math.inf
    for _ in range(LAPS):
        before = gap
        gap = math.hypot(end[0] - begin[0], end[1] - begin[1])
        if gap <= 1e-16 * size or (gap >= 0.5 * before and gap <= 1e-14 * size):
            break
        a, b, c, d = 1.0 - turn[0, 0], -turn[0, 1], -turn[1, 0], 1.0 - turn[1, 1]
        det = a * d - b * c
        if det > 1e-14:
            x, y = end[0] - begin[0], end[1] - begin[1]
            trial[0], trial[1] = begin[0] + (d * x - b * y) / det, begin[1] + (a * y - c * x) / det
            _lap(centre, radius, trial, trial_end, trial_turn)
            if math.hypot(trial_end[0] - trial[0], trial_end[1] - trial[1]) < 0.5 * gap:
                begin[:], end[:], turn[:] = trial, trial_end, trial_turn
                continue
        begin[:] = end
        _lap(centre, radius, begin, end, turn)
    begin[:] = end


@kernel
def _advance(
    rates: Floats, alpha: float, phi0: Floats, phi1: Floats, kind: int, rate: Floats
) -> None:
    """Carry the slider's rates (2, 3, m) to all coefficients of (v, u1, u2) over a step."""
    m = phi0.size
    for k in range(m):
        if kind == FREE:
            rate[:, :, k] = 0.0
            rate[0, 1, k] = rate[1, 2, k] = phi1[k]
            continue
        for b in range(3):
            x, y = rate[0, b, k], rate[1, b, k]
            for i in range(2):
                moved = rates[i, START] * x + rates[i, START + 1] * y
                if b == 0:
                    moved += alpha * (rates[i, SMALLER] * phi0[k] + rates[i, LARGER] * phi1[k])
                else:
                    moved += rates[i, FROM + b - 1] * phi0[k] + rates[i, TO + b - 1] * phi1[k]
                rate[i, b, k] = moved


@kernel
def slider_path(
    centre: Floats, radius: Floats, alpha: float, table: Floats, path: Floats, rate: Floats
) -> tuple[bool, float]:
    """Periodic path (s, 2) of a slider that slips or opens, and its rates (2, s, 3, m)."""
    size, m = table.shape
    now, following, rates = np.empty(2), np.empty(2), np.empty((2, RATES))
    carried = np.zeros((2, 3, m))
    start = 0
    for i in range(size):
        if radius[i] < radius[start]:
            start = i
    forgets = radius[start] <= 0.0
    if forgets:
        now[:] = centre[start]
        carried[0, 1] = carried[1, 2] = table[start]
    else:
        start = 0
        periodic_start(centre, radius, now)
    turn, turns = np.eye(2), np.empty((size, 2, 2))
    slips, work = False, 0.0
    for n in range(size):
        i, j = (start + n) % size, (start + n + 1) % size
        kind, share = pursue(now, centre[i], centre[j], radius[i], radius[j], following, rates)
        if kind != HELD or radius[i] <= 0.0:
            now[:] = following
            _advance(rates, alpha, table[i], table[j], kind, carried)
            turn = rates[:, START : START + 2].copy() @ turn
        slips = slips or kind == SLIPPING
        work += share
        path[j], turns[j] = now, turn
        rate[:, j] = carried
    if not forgets:  # d begin = turn · d begin + carried
        a, b, c, d = 1.0 - turn[0, 0], -turn[0, 1], -turn[1, 0], 1.0 - turn[1, 1]
        det = a * d - b * c
        if det > 1e-14:
            for k in range(3):
                for n in range(m):
                    p, q = carried[0, k, n], carried[1, k, n]
                    x, y = (d * p - b * q) / det, (a * q - c * p) / det
                    for j in range(size):
                        rate[0, j, k, n] += turns[j, 0, 0] * x + turns[j, 0, 1] * y
                        rate[1, j, k, n] += turns[j, 1, 0] * x + turns[j, 1, 1] * y
    return slips, work


@kernel
def _add_rest(
    w: Floats,
    centre: Floats,
    radius: Floats,
    discs: tuple[int, int],
    alpha: float,
    table: Floats,
    jacobian: Floats,
) -> None:
    """Derivative of the mean of a slider that rests on the edges of one or two discs."""
    to_first, to_second = np.empty((2, 3)), np.empty((2, 3))
    rest_rates(w, centre, radius, discs[0], discs[1], to_first, to_second)
    for n in range(2):
        if discs[n] == NONE:
            continue
        phi, to = table[discs[n]], to_first if n == 0 else to_second
        for i in range(2):
            for k in range(phi.size):
                jacobian[1 + i, 0, 0, k] += alpha * to[i, 2] * phi[k]
                jacobian[1 + i, 0, 1, k] += to[i, 0] * phi[k]
                jacobian[1 + i, 0, 2, k] += to[i, 1] * phi[k]


@kernel
def _add_friction(
    u: Floats, alpha: float, table: Floats, w: Floats, jacobian: Floats
) -> tuple[bool, float]:
    """W and dw/du of the plane of one contact; whether it slips and ∫ α v |dw|."""
    size, m = table.shape
    centre, radius = np.empty((size, 2)), alpha * (table @ u[0])
    centre[:, 0], centre[:, 1] = table @ u[1], table @ u[2]
    rest = np.empty(2)
    if radius.min() > 0.0:
        sticks, first, second = rest_point(centre, radius, rest)
        if sticks:
            if first != NONE:
                w[1, 0], w[2, 0] = rest[0], rest[1]
                _add_rest(rest, centre, radius, (first, second), alpha, table, jacobian)
            return False, 0.0
    path, rate = np.empty((size, 2)), np.empty((2, size, 3, m))
    slips, work = slider_path(centre, radius, alpha, table, path, rate)
    columns = np.ascontiguousarray(table.T) * (2.0 / size)
    columns[0] *= 0.5
    for i in range(2):
        w[1 + i] = columns @ np.ascontiguousarray(path[:, i])
        jacobian[1 + i] = (columns @ rate[i].reshape(size, 3 * m)).reshape(m, 3, m)
    return slips, work


@kernel
def without_path(
    c: int,
    u: Floats,
    alpha: Floats,
    table: Floats,
    contact: Floats,
    along: Floats,
    w: Floats,
    jacobian: Floats,
    opening: NDArray[np.int64],
    slips: NDArray[np.bool_],
) -> tuple[bool, int]:
    """The normal direction of a contact, and the plane of one that is free or never moved."""
    v, a, m = u[c, 0], alpha[c, 0], u.shape[2]
    count = roots(v, table, contact)
    along[:] = 0.0
    opening[c] = add_normal(v, contact, count, w[c, 0], along)
    if opening[c] != CLOSED:
        place(along, c, 0, 0, jacobian)
    smooth = a * (v[0] + spread(v)) <= FINEST * math.hypot(spread(u[c, 1]), spread(u[c, 2]))
    if opening[c] == ALWAYS or smooth:
        for d in range(1, 3):
            w[c, d] = u[c, d]
            for k in range(m):
                jacobian[c, d, k, d, k] = 1.0
        slips[c] = smooth and m > 1
        return True, count
    furthest = math.hypot(abs(u[c, 1, 0]) + spread(u[c, 1]), abs(u[c, 2, 0]) + spread(u[c, 2]))
    return opening[c] == CLOSED and furthest <= a * (v[0] - spread(v)), count


@kernel
def isotropic_sampled_law(
    u: Floats,
    alpha: Floats,
    stiffness: Floats,
    table: Floats,
    w: Floats,
    jacobian: Floats,
    opening: NDArray[np.int64],
    slips: NDArray[np.bool_],
    energy: Floats,
) -> None:
    """The law with isotropic friction, contact by contact."""
    m = u.shape[2]
    contact, along = np.empty(2 * m + 2), np.empty((m, m))
    for c in range(u.shape[0]):
        done, _ = without_path(c, u, alpha, table, contact, along, w, jacobian, opening, slips)
        if done:
            continue
        slips[c], energy[c] = _add_friction(u[c], alpha[c, 0], table, w[c], jacobian[c])
        energy[c] *= stiffness[c, 1]
