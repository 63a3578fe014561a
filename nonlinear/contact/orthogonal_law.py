"""The contact law with orthogonal friction, its events located or on samples.

A contact's friction spring ends in a slider at w, t = kt (u - w). Sticking holds w; slipping keeps
it at a bound,

    low = u - α v  <=  w  <=  high = u + α v,        α = μ kn/kt,

and a lifted-off contact (v < 0) carries it along, w = u, which is also where sticking restarts.
So every piece of w(θ) is a trigonometric polynomial or a constant, and what remains is to find
where one piece ends and the next begins. Between two neighbouring roots of v, low' and high' each
bound is monotone and the contact open or closed, so that a held slider meets at most one bound
once: roots are all that has to be searched for, and integrals are exact, segment by segment.

On plain samples, quick and a reference, events fall between samples, so the coefficients carry an
error of first order in their distance; the Jacobian is the exact derivative of the sampled law,
followed through the states.
"""

import math
from typing import TypeAlias

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear.contact.normal import (
    ALWAYS,
    CLOSED,
    PARTLY,
    Evaluated,
    add_normal,
    place,
    scale,
    stuck,
)
from vanelock.nonlinear.fourier import (
    TURN,
    add_integrals,
    basis_at,
    crossing,
    derivative,
    gram,
    kernel,
    roots,
    spread,
    value,
    value_and_slope,
)

HELD, LOW, HIGH, FREE = 0, 1, 2, 3
# Columns of a segment: its kind and angles; for a held slider its place w, the angle at which that
# was set (nan: at w = 0, for good) and the factor c in dw = du + c dv, both at that angle.
KIND, BEGIN, END, PLACE, SOURCE, FACTOR = 0, 1, 2, 3, 4, 5
WIDTH = 6
_Slider: TypeAlias = tuple[float, float, float]
_AT_REST = (0.0, math.nan, 0.0)


@kernel
def _append(
    segments: Floats, count: int, kind: int, begin: float, end: float, slider: _Slider
) -> int:
    """Add a segment, or lengthen the last one where it only continues; empty ones are left out."""
    if end <= begin:
        return count
    if count > 0:
        last = segments[count - 1]
        same = last[KIND] == kind and last[END] == begin
        if same and (kind != HELD or last[SOURCE] == slider[1]):
            last[END] = end
            return count
    row = segments[count]
    row[KIND], row[BEGIN], row[END] = kind, begin, end
    row[PLACE], row[SOURCE], row[FACTOR] = slider
    return count + 1


@kernel
def _whole(segments: Floats, kind: int, slider: _Slider) -> int:
    """One segment over the whole period."""
    return _append(segments, 0, kind, 0.0, TURN, slider)


@kernel
def _highest(a: Floats, stationary: Floats, count: int, sign: float) -> tuple[float, float]:
    """The largest sign·a(θ) over its stationary points: sign·a there, and where."""
    best, where = sign * value(a, 0.0), 0.0
    for i in range(count):
        candidate = sign * value(a, stationary[i])
        if candidate > best:
            best, where = candidate, stationary[i]
    return best, where


@kernel
def _ordered(start: float, groups: Floats, counts: Floats, out: Floats) -> int:
    """Angles of all groups as distances past `start` in [0, 2π), ascending, 0 the first."""
    out[0] = 0.0
    total = 1
    for g in range(groups.shape[0]):
        for i in range(int(counts[g])):
            distance = (groups[g, i] - start) % TURN
            if distance <= 0.0:
                continue
            place = total
            while place > 1 and out[place - 1] > distance:
                out[place] = out[place - 1]
                place -= 1
            out[place] = distance
            total += 1
    return total


@kernel
def slider_path(
    v: Floats, u: Floats, alpha: float, contact: Floats, contacts: int, table: Floats, out: Floats
) -> int:
    """Segments of the periodic slider path into `out`; returns how many."""
    closed = contacts == 0 and v[0] > 0.0
    if alpha == 0.0 or (contacts == 0 and not closed):
        return _whole(out, FREE, _AT_REST)
    low, high = u - alpha * v, u + alpha * v
    if closed and low[0] + spread(low) <= 0.0 <= high[0] - spread(high):
        return _whole(out, HELD, _AT_REST)
    low_slope, high_slope = derivative(low), derivative(high)
    breaks = np.empty((3, contact.size))
    counts = np.empty(3)
    breaks[0, :contacts] = contact[:contacts]
    counts[0] = contacts
    counts[1] = roots(low_slope, table, breaks[1])
    counts[2] = roots(high_slope, table, breaks[2])
    if closed:
        lowest, low_at = _highest(low, breaks[1], int(counts[1]), 1.0)
        highest, high_at = _highest(high, breaks[2], int(counts[2]), -1.0)
        highest = -highest
        if lowest <= highest:  # slides at most once, then sticks for good
            if lowest > 0.0:
                return _whole(out, HELD, (lowest, low_at, -alpha))
            if highest < 0.0:
                return _whole(out, HELD, (highest, high_at, alpha))
            return _whole(out, HELD, _AT_REST)
        start, mode = low_at, LOW  # only slipping takes a slider to the top of its lower bound
    else:
        start, mode = contact[1 if value(v, 0.0) >= 0.0 else 0], FREE  # where it touches down
    order = np.empty(3 * contact.size + 1)
    total = _ordered(start, breaks, counts, order)
    return _march(v, u, alpha, start, mode, order[:total], out)


@kernel
def _is_open(v: Floats, begin: float, end: float) -> bool:
    """Whether v < 0 in a piece without change of sign, though it may touch zero here and there."""
    largest = 0.0
    for i in range(1, 6):
        sample = value(v, begin + i / 6 * (end - begin))
        if abs(sample) > abs(largest):
            largest = sample
    return largest < 0.0


@kernel
def _march(
    v: Floats, u: Floats, alpha: float, start: float, mode: int, order: Floats, out: Floats
) -> int:
    """Follow the slider once round from an instant at which its place is known."""
    count, total, low, high = 0, order.size, u - alpha * v, u + alpha * v
    place, source, factor = 0.0, np.nan, 0.0
    for i in range(total):
        a = start + order[i]
        b = start + (order[i + 1] if i + 1 < total else TURN)
        if b <= a:  # roots of two of the polynomials at the same angle
            continue
        if _is_open(v, a, b):
            count = _append(out, count, FREE, a, b, _AT_REST)
            mode = FREE
            continue
        # Both bounds are monotone from a to b, so their ends decide, wherever a slope may vanish.
        rising = value(low, b) > value(low, a)
        falling = value(high, b) < value(high, a)
        if mode == FREE:  # touches down unstressed; the instant moves with v
            place, slope = value_and_slope(u, a)
            closing = value_and_slope(v, a)[1]
            mode, source = HELD, a
            factor = -slope / closing if closing > 0.0 else 0.0
        elif mode == LOW and not rising:
            mode, place, source, factor = HELD, value(low, a), a, -alpha
        elif mode == HIGH and not falling:
            mode, place, source, factor = HELD, value(high, a), a, alpha
        event = a
        if mode == HELD:
            under = value(low, b) - place if rising else -math.inf
            over = place - value(high, b) if falling else -math.inf
            event = b
            if under > 0.0 and under >= over:
                event = crossing(low, place, a, b) if value(low, a) < place else a
                mode = LOW
            elif over > 0.0:
                event = crossing(high, place, a, b) if value(high, a) > place else a
                mode = HIGH
            count = _append(out, count, HELD, a, event, (place, source, factor))
        if mode != HELD:
            count = _append(out, count, mode, event, b, _AT_REST)
    return count


@kernel
def sampled_law(u: Floats, alpha: Floats, stiffness: Floats, table: Floats) -> Evaluated:
    """The law on plain samples, contact by contact."""
    w, jacobian, opening, slips, energy = stuck(u)
    for c in range(u.shape[0]):
        opening[c], slips[c], energy[c] = _sampled_contact(
            u[c], alpha[c], stiffness[c], table, w[c], jacobian[c]
        )
    return w, jacobian, opening, slips, energy


@kernel
def _sampled_contact(
    u: Floats, alpha: Floats, stiffness: Floats, table: Floats, w: Floats, jacobian: Floats
) -> tuple[int, bool, float]:
    """W and dw/du of one contact from samples of the period."""
    size, m = table.shape
    v = table @ u[0]
    opened = 0
    for i in range(size):
        if v[i] <= 0.0:
            opened += 1
            for j in range(m):
                w[0, j] += v[i] * table[i, j]
                for k in range(m):
                    jacobian[0, j, 0, k] += table[i, j] * table[i, k]
    slips, work = False, 0.0
    for d in range(1, 3):
        slip, share = _sampled_slider(
            v, table @ u[d], alpha[d - 1], table, opened, w[d], jacobian[d, :, d], jacobian[d, :, 0]
        )
        slips = slips or slip
        work += stiffness[d] * share
    w /= 0.5 * size
    w[:, 0] *= 0.5
    jacobian /= 0.5 * size
    jacobian[:, 0] *= 0.5
    return CLOSED if opened == 0 else ALWAYS if opened == size else PARTLY, slips, work


@kernel
def _sampled_slider(
    v: Floats,
    u: Floats,
    alpha: float,
    table: Floats,
    opened: int,
    w: Floats,
    along: Floats,
    across: Floats,
) -> tuple[bool, float]:
    """Sums of one slider over the samples: clip(w, u - αv, u + αv) from one to the next, twice."""
    size, m = table.shape
    low, high = u - alpha * np.maximum(v, 0.0), u + alpha * np.maximum(v, 0.0)
    source, factor = 0, 0.0  # dw = du + factor dv at that sample
    stays = opened == 0 and low.max() <= high.min()
    place = 0.0
    if stays:
        if low.max() > 0.0:
            place, source, factor = low.max(), int(np.argmax(low)), -alpha
        elif high.min() < 0.0:
            place, source, factor = high.min(), int(np.argmin(high)), alpha
        else:  # sticks where it was assembled
            return False, 0.0
    slips, work = False, 0.0
    for i in range(size if stays else 2 * size):
        s = i % size
        before = place
        if not stays:
            if v[s] <= 0.0:
                place, source, factor = u[s], s, 0.0
            elif place < low[s]:
                place, source, factor = low[s], s, -alpha
            elif place > high[s]:
                place, source, factor = high[s], s, alpha
            if i < size:
                continue
            if source == s and v[s] > 0.0:
                slips = True
                work += alpha * v[s] * abs(place - before)
        for j in range(m):
            w[j] += place * table[s, j]
            for k in range(m):
                along[j, k] += table[s, j] * table[source, k]
                across[j, k] += table[s, j] * factor * table[source, k]
    return slips, work


@kernel
def _add_slider(
    v: Floats, u: Floats, alpha: float, path: Floats, w: Floats, along: Floats, across: Floats
) -> tuple[bool, float]:
    """Coefficients of a slider path, its derivatives to u and to v; whether it slips; ∫ αv |dw|."""
    m = u.size
    moments = np.zeros((3, m), np.complex128)  # of the angles on the lower and upper bound, and off
    held = np.empty((m + 1) // 2, np.complex128)
    integral, phi = np.empty(m), np.empty(m)
    slips, opens = False, False
    for i in range(path.shape[0]):
        kind, begin, end = int(path[i, KIND]), path[i, BEGIN], path[i, END]
        if kind == HELD:
            if np.isnan(path[i, SOURCE]):
                continue
            held[:] = 0.0
            add_integrals(begin, end, held)
            integral[0] = held[0].real
            for h in range(1, held.size):
                integral[2 * h - 1], integral[2 * h] = held[h].real, -held[h].imag
            basis_at(path[i, SOURCE], phi)
            for j in range(m):
                w[j] += path[i, PLACE] * integral[j]
                for k in range(m):
                    along[j, k] += integral[j] * phi[k]
                    across[j, k] += integral[j] * path[i, FACTOR] * phi[k]
        else:
            add_integrals(begin, end, moments[0 if kind == LOW else 1 if kind == HIGH else 2])
            slips = slips or kind != FREE
            opens = opens or kind == FREE
    work = 0.0
    share, moving = np.empty((m, m)), np.empty(m)
    for g in range(3):
        if (not slips and g < 2) or (not opens and g == 2):
            continue
        gram(moments[g], share)
        factor = -alpha if g == 0 else alpha if g == 1 else 0.0
        for k in range(m):
            moving[k] = u[k] + factor * v[k]
        rate = derivative(moving)
        for j in range(m):
            for k in range(m):
                w[j] += share[j, k] * moving[k]
                along[j, k] += share[j, k]
                across[j, k] += factor * share[j, k]
                work -= factor * v[j] * share[j, k] * rate[k]
    for j in range(m):
        w[j] /= TURN if j == 0 else 0.5 * TURN
    scale(along)
    scale(across)
    return slips, work


@kernel
def located_law(u: Floats, alpha: Floats, stiffness: Floats, table: Floats) -> Evaluated:
    """The law with located events, contact by contact."""
    m, (w, jacobian, opening, slips, energy) = u.shape[2], stuck(u)
    contact = np.empty(2 * m + 2)
    path = np.empty((6 * contact.size + 2, WIDTH))
    along, across = np.empty((m, m)), np.empty((m, m))
    for c in range(u.shape[0]):
        v = u[c, 0]
        count = roots(v, table, contact)
        along[:] = 0.0
        opening[c] = add_normal(v, contact, count, w[c, 0], along)
        if opening[c] != CLOSED:
            place(along, c, 0, 0, jacobian)
        for d in range(1, 3):
            a = alpha[c, d - 1]
            size = slider_path(v, u[c, d], a, contact, count, table, path)
            if size == 1 and path[0, KIND] == HELD and np.isnan(path[0, SOURCE]):
                continue  # sticks where it was assembled
            along[:] = 0.0
            across[:] = 0.0
            slip, work = _add_slider(v, u[c, d], a, path[:size], w[c, d], along, across)
            place(along, c, d, d, jacobian)
            place(across, c, d, 0, jacobian)
            slips[c] = slips[c] or slip or (a == 0.0 and m > 1)
            energy[c] += stiffness[c, d] * work
    return w, jacobian, opening, slips, energy
