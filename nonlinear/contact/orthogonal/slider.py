"""The path of one friction slider over a period, with located events.

A contact's friction spring ends in a slider at w, t = kt (u - w). Sticking holds w; slipping keeps
it at a bound,

    low = u - α v  <=  w  <=  high = u + α v,        α = μ kn/kt,

and a lifted-off contact (v < 0) carries it along, w = u, which is also where sticking restarts.
So every piece of w(θ) is a trigonometric polynomial or a constant, and what remains is to find
where one piece ends and the next begins. Between two neighbouring roots of v, low' and high' each
bound is monotone and the contact open or closed, so that a held slider meets at most one bound
once: roots are all that has to be searched for.
"""

import math

import numpy as np

from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import (
    TURN,
    Floats,
    crossing,
    derivative,
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


@kernel
def _append(
    segments: Floats,
    count: int,
    kind: int,
    begin: float,
    end: float,
    place: float,
    source: float,
    factor: float,
) -> int:
    """Add a segment, or lengthen the last one where it only continues; empty ones are left out."""
    if end <= begin:
        return count
    if count > 0:
        last = segments[count - 1]
        same = last[KIND] == kind and last[END] == begin
        if same and (kind != HELD or last[SOURCE] == source):
            last[END] = end
            return count
    row = segments[count]
    row[KIND], row[BEGIN], row[END] = kind, begin, end
    row[PLACE], row[SOURCE], row[FACTOR] = place, source, factor
    return count + 1


@kernel
def _whole(segments: Floats, kind: int, place: float, source: float, factor: float) -> int:
    """One segment over the whole period."""
    return _append(segments, 0, kind, 0.0, TURN, place, source, factor)


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
        return _whole(out, FREE, 0.0, np.nan, 0.0)
    low, high = u - alpha * v, u + alpha * v
    if closed and low[0] + spread(low) <= 0.0 <= high[0] - spread(high):
        return _whole(out, HELD, 0.0, np.nan, 0.0)
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
                return _whole(out, HELD, lowest, low_at, -alpha)
            if highest < 0.0:
                return _whole(out, HELD, highest, high_at, alpha)
            return _whole(out, HELD, 0.0, np.nan, 0.0)
        start, mode = low_at, LOW  # only slipping takes a slider to the top of its lower bound
    else:
        start, mode = contact[1 if value(v, 0.0) >= 0.0 else 0], FREE  # where it touches down
    order = np.empty(3 * contact.size + 1)
    total = _ordered(start, breaks, counts, order)
    return _march(v, u, alpha, low, high, start, mode, order, total, out)


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
    v: Floats,
    u: Floats,
    alpha: float,
    low: Floats,
    high: Floats,
    start: float,
    mode: int,
    order: Floats,
    total: int,
    out: Floats,
) -> int:
    """Follow the slider once round from an instant at which its place is known."""
    count = 0
    place, source, factor = 0.0, np.nan, 0.0
    for i in range(total):
        a = start + order[i]
        b = start + (order[i + 1] if i + 1 < total else TURN)
        if b <= a:  # roots of two of the polynomials at the same angle
            continue
        if _is_open(v, a, b):
            count = _append(out, count, FREE, a, b, 0.0, np.nan, 0.0)
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
            count = _append(out, count, HELD, a, event, place, source, factor)
        if mode != HELD:
            count = _append(out, count, mode, event, b, 0.0, np.nan, 0.0)
    return count
