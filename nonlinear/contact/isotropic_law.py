"""The contact law with isotropic friction, |t| <= μ n in the tangential plane, events located.

A contact that opens forgets: one lap from a touch-down is the periodic path. One that stays closed
either finds a place where it sticks for good (`rest_point`), or it slips in every period; its
periodic path is then unique. A few laps of the polygon through samples lead near its beginning,
Newton's iteration on one lap's map of the plane to it.
"""

import math

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear.contact.disc_path import once_round
from vanelock.nonlinear.contact.disc_slider import (
    FREE,
    HELD,
    NONE,
    outside,
    periodic_start,
    rest_point,
    rest_rates,
)
from vanelock.nonlinear.contact.disc_slip import (
    BEGIN,
    DR,
    DX,
    DY,
    END,
    KIND,
    NODES,
    PX,
    PY,
    STAGES,
    STEP,
    WIDTH,
    R,
    X,
    Y,
    add_coefficients,
    motion_at,
    new_path,
)
from vanelock.nonlinear.contact.normal import ALWAYS, CLOSED, Evaluated, add_normal, place, stuck
from vanelock.nonlinear.fourier import (
    TURN,
    basis,
    basis_at,
    derivative,
    grid,
    kernel,
    roots,
    spread,
)

_LAPS = 50
_CLOSE = 1e-9  # of the displacements: a gap of a lap of which Newton's step leaves the square
_FORGOTTEN = 1e-12  # what the lap's end may keep of such a gap
_FINEST = 1e-14
"""Of the vibration: a disc whose slider has the displacements of its centre to their last digit."""
_ADDED = 24  # discs at located instants, among which a place of rest is sought, at most

_POWERS = np.arange(1, STAGES + 1)
_THROUGH = np.linalg.inv(NODES[:, None] ** _POWERS)  # values at the nodes to coefficients


@kernel
def _slope(angle: float, w: Floats, u: Floats, alpha: float, phi: Floats, motion: Floats) -> float:
    """Slope of |p - w| - r."""
    motion_at(angle, u, alpha, phi, motion)
    x, y = motion[PX] - w[0], motion[PY] - w[1]
    size = math.hypot(x, y)
    return (x * motion[DX] + y * motion[DY]) / size - motion[DR] if size > 0.0 else 0.0


@kernel
def _tightest(
    angle: float, apart: float, w: Floats, u: Floats, alpha: float, phi: Floats, motion: Floats
) -> float:
    """Where |p - w| - r is largest near the sample at an angle, larger than its neighbours."""
    at_low = _slope(angle, w, u, alpha, phi, motion)
    low, high = (angle, angle + apart) if at_low > 0.0 else (angle - apart, angle)
    for _ in range(60):
        angle = 0.5 * (low + high)
        slope = _slope(angle, w, u, alpha, phi, motion)
        if slope > 0.0:
            low = angle
        else:
            high = angle
        if high - low < 1e-12:
            break
    return 0.5 * (low + high)


@kernel
def _add_nearest(angle: float, u: Floats, alpha: float, jacobian: Floats) -> None:
    """Derivative of a rest at w = (|p| - r) e, e = p/|p|, the angle that where |p| - r is largest.

    With the displacements the angle moves, too, and e with it: the slope of |p| - r stays zero.
    """
    m = u.shape[1]
    phi, motion, further, turned = np.empty(m), np.empty(6), np.empty(6), np.empty(m)
    motion_at(angle, u, alpha, phi, motion)
    bent = np.empty((3, m))
    for i in range(3):
        bent[i] = derivative(u[i])
    motion_at(angle, bent, alpha, phi, further)
    size = math.hypot(motion[PX], motion[PY])
    ex, ey = motion[PX] / size, motion[PY] / size
    across = ex * motion[DY] - ey * motion[DX]
    curved = across**2 / size + ex * further[DX] + ey * further[DY] - further[DR]
    for k in range(m):  # dφ_k
        h = (k + 1) // 2
        turned[k] = 0.0 if k == 0 else h * phi[k + 1] if k % 2 == 1 else -h * phi[k - 1]
    share = 1.0 - motion[R] / size
    for block in range(3):
        along = -alpha if block == 0 else ex if block == 1 else ey
        beside = 0.0 if block == 0 else -ey if block == 1 else ex
        for k in range(m):
            later = 0.0
            if curved < 0.0:
                later = -(beside * phi[k] * across / size + along * turned[k]) / curved
            turn = share * (beside * phi[k] + across * later)
            jacobian[1, 0, block, k] += ex * along * phi[k] - ey * turn
            jacobian[2, 0, block, k] += ey * along * phi[k] + ex * turn


@kernel
def _rest(
    u: Floats, alpha: float, centre: Floats, radius: Floats, w: Floats, jacobian: Floats
) -> bool:
    """Whether a slider sticks for good; its place and derivatives are then added.

    `centre` and `radius` hold the samples, and room for ADDED discs more: those that leave a place
    out most, between two samples, join them, first for the place zero.
    """
    m, count = u.shape[1], radius.size - _ADDED
    angles, phi, motion = np.empty(radius.size), np.empty(m), np.empty(6)
    for i in range(count):
        angles[i] = TURN * i / count
    size = max(np.abs(centre[:count]).max(), radius[:count].max())
    used, rest = count, np.zeros(2)
    first, second = NONE, NONE
    for tried in range(_ADDED):
        before = used
        for i in range(count):
            top = outside(rest, centre, radius, i)
            left = outside(rest, centre, radius, (i - 1) % count)
            right = outside(rest, centre, radius, (i + 1) % count)
            if top < left or top < right or 3.0 * top < 2.0 * min(left, right):
                continue
            angle = _tightest(angles[i], TURN / count, rest, u, alpha, phi, motion)
            motion_at(angle, u, alpha, phi, motion)
            x, y = motion[PX] - rest[0], motion[PY] - rest[1]
            if used < radius.size and math.hypot(x, y) - motion[R] > 1e-13 * size:
                angles[used], radius[used] = angle, motion[R]
                centre[used, 0], centre[used, 1] = motion[PX], motion[PY]
                used += 1
        if tried > 0 and used == before:
            break
        found, first, second = rest_point(centre[:used], radius[:used], rest)
        if not found:
            return False
    if first == NONE:
        return True
    w[1, 0], w[2, 0] = rest[0], rest[1]
    if second == NONE:
        _add_nearest(angles[first], u, alpha, jacobian)
        return True
    rates = np.empty((2, 2, 3))
    rest_rates(rest, centre, radius, first, second, rates[0], rates[1])
    for n in range(2):
        basis_at(angles[first if n == 0 else second], phi)
        for i in range(2):
            for k in range(m):
                jacobian[1 + i, 0, 0, k] += alpha * rates[n, i, 2] * phi[k]
                jacobian[1 + i, 0, 1, k] += rates[n, i, 0] * phi[k]
                jacobian[1 + i, 0, 2, k] += rates[n, i, 1] * phi[k]
    return True


@kernel
def _inverse_of_gap(turn: Floats) -> tuple[bool, Floats]:
    """(1 - turn)⁻¹ of a lap's map of the plane, where it is far enough from singular."""
    a, b, c, d = 1.0 - turn[0, 0], -turn[0, 1], -turn[1, 0], 1.0 - turn[1, 1]
    det = a * d - b * c
    inverse = np.zeros((2, 2))
    if det <= 1e-14:
        return False, inverse
    inverse[0, 0], inverse[0, 1] = d / det, -b / det
    inverse[1, 0], inverse[1, 1] = -c / det, a / det
    return True, inverse


@kernel
def _begin(
    u: Floats, alpha: float, contact: Floats, brackets: int, size: float, start: Floats
) -> None:
    """From near the beginning of the periodic path of a closed contact to it.

    One lap never moves two sliders apart, so a plain lap is safe where Newton's step is not better.
    """
    m, gap, tried = u.shape[1], math.inf, False
    plain = start.copy()
    for _ in range(_LAPS):
        path = new_path(m, 2, 0)
        path.slider[:] = start
        path.change[0, 0] = path.change[1, 1] = 1.0
        once_round(u, alpha, contact, 0, brackets, path)
        x, y = path.slider[0] - start[0], path.slider[1] - start[1]
        before, gap = gap, math.hypot(x, y)
        if tried and gap > 0.5 * before and gap > 1e-13 * size:
            start[:] = plain
            tried, gap = False, math.inf
            continue
        plain[:] = path.slider
        if gap <= 1e-13 * size:
            start[:] = plain
            return
        tried, inverse = _inverse_of_gap(path.change)
        if tried:
            start[0] += inverse[0, 0] * x + inverse[0, 1] * y
            start[1] += inverse[1, 0] * x + inverse[1, 1] * y
            memory = np.abs(path.change).max()
            if gap <= _CLOSE * size or gap * memory <= _FORGOTTEN * size:
                return
        else:
            start[:] = plain


@kernel
def _start(
    u: Floats, alpha: float, contact: Floats, table: Floats, w: Floats, jacobian: Floats,
    start: Floats,
) -> bool:  # fmt: skip
    """Whether a closed contact sticks for good, as `_rest`; else where its path begins."""
    brackets = len(table)
    centre, radius = np.empty((brackets + _ADDED, 2)), np.empty(brackets + _ADDED)
    radius[:brackets] = alpha * (table @ u[0])
    centre[:brackets, 0], centre[:brackets, 1] = table @ u[1], table @ u[2]
    if _rest(u, alpha, centre, radius, w, jacobian):
        return True
    periodic_start(centre[:brackets], radius[:brackets], start)
    _begin(u, alpha, contact, brackets, np.abs(centre[:brackets]).max(), start)
    return False


@kernel
def slider_pieces(u: Floats, alpha: float, table: Floats) -> Floats:
    """The periodic path of a slider piece by piece, from a touch-down where there is one."""
    m, start, contact = u.shape[1], np.zeros(2), np.empty(2 * u.shape[1] + 2)
    count = roots(u[0], table, contact)
    whole = np.zeros((1, WIDTH))
    whole[0, END] = TURN
    if alpha == 0.0 or (count == 0 and u[0, 0] <= 0.0):
        whole[0, KIND] = FREE
        return whole
    if count == 0:
        w, jacobian = np.zeros((3, m)), np.zeros((3, m, 3, m))
        if _start(u, alpha, contact, table, w, jacobian, start):
            whole[0, KIND], whole[0, X], whole[0, Y] = HELD, w[1, 0], w[2, 0]
            return whole
    path = new_path(m, 3 * m, 0)
    for _ in range(2):  # to count the pieces, then to write them down
        path = new_path(m, 3 * m, path.filled[0])
        path.slider[:] = start
        once_round(u, alpha, contact, count, len(table), path)
    return path.pieces


@kernel
def _add_friction(
    u: Floats, alpha: float, contact: Floats, count: int, table: Floats, w: Floats, jacobian: Floats
) -> tuple[bool, float]:
    """W and dw/du of the plane of one contact; whether it slips and ∫ α v |dw|."""
    brackets, m = table.shape
    if count > 0:
        path = new_path(m, 3 * m, 0)
        slips, work = once_round(u, alpha, contact, count, brackets, path)
        add_coefficients(u, alpha, path, w, jacobian)
        return slips, work
    path = new_path(m, 3 * m + 2, 0)
    if _start(u, alpha, contact, table, w, jacobian, path.slider):
        return False, 0.0
    path.change[0, 3 * m] = path.change[1, 3 * m + 1] = 1.0
    slips, work = once_round(u, alpha, contact, 0, brackets, path)
    closed, inverse = _inverse_of_gap(path.change[:, 3 * m :])
    if closed:  # the beginning moves with the end
        for k in range(3 * m):
            x = inverse[0, 0] * path.change[0, k] + inverse[0, 1] * path.change[1, k]
            y = inverse[1, 0] * path.change[0, k] + inverse[1, 1] * path.change[1, k]
            for i in range(2):
                for j in range(m):
                    row = path.jacobian[i, j]
                    row[k] += x * row[3 * m] + y * row[3 * m + 1]
    add_coefficients(u, alpha, path, w, jacobian)
    return slips, work


@kernel
def _without_path(
    c: int, u: Floats, alpha: Floats, table: Floats, contact: Floats, along: Floats, made: Evaluated
) -> tuple[bool, int]:
    """The normal direction of a contact, and the plane of one that is free or never moved."""
    w, jacobian, opening, slips, _ = made
    v, a, m = u[c, 0], alpha[c, 0], u.shape[2]
    count = roots(v, table, contact)
    along[:] = 0.0
    opening[c] = add_normal(v, contact, count, w[c, 0], along)
    if opening[c] != CLOSED:
        place(along, c, 0, 0, jacobian)
    smooth = a * (v[0] + spread(v)) <= _FINEST * math.hypot(spread(u[c, 1]), spread(u[c, 2]))
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
def isotropic_located_law(u: Floats, alpha: Floats, stiffness: Floats, table: Floats) -> Evaluated:
    """The law with isotropic friction, contact by contact."""
    m, made = u.shape[2], stuck(u)
    w, jacobian, _, slips, energy = made
    contact, along = np.empty(2 * m + 2), np.empty((m, m))
    for c in range(u.shape[0]):
        done, count = _without_path(c, u, alpha, table, contact, along, made)
        if done:
            continue
        slips[c], energy[c] = _add_friction(
            u[c], alpha[c, 0], contact, count, table, w[c], jacobian[c]
        )
        energy[c] *= stiffness[c, 1]
    return made


def slider_places(u: Floats, alpha: float, angles: Floats) -> Floats:
    """Places (s, 2) of a slider, m, on its periodic path.

    While it slips, z of its step (`disc_slip`) is the polynomial that was collocated.
    """
    harmonics = u.shape[1] // 2
    pieces = slider_pieces(np.ascontiguousarray(u), alpha, grid(harmonics))
    first = pieces[0, BEGIN]
    wrapped = first + (angles - first) % TURN
    piece = pieces[np.searchsorted(pieces[:, BEGIN], wrapped, side="right") - 1]
    phi = basis(harmonics, angles)
    p, r = phi @ u[1:].T, alpha * (phi @ u[0])
    share = (wrapped - piece[:, BEGIN]) / (piece[:, END] - piece[:, BEGIN])
    z = np.einsum("sp,pi,si->s", share[:, None] ** _POWERS, _THROUGH, piece[:, STEP:])
    e0 = piece[:, X : Y + 1]
    turned = (1 - z**2)[:, None] * e0 + (2 * z)[:, None] * np.stack([-e0[:, 1], e0[:, 0]], axis=1)
    slipping = p - (r / (1 + z**2))[:, None] * turned
    kind = piece[:, [KIND]]
    return np.asarray(np.where(kind == HELD, e0, np.where(kind == FREE, p, slipping)))
