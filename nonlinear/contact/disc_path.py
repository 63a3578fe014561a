"""Once round with a slider in a moving disc: held, dragged by its edge, or free, events located.

    held -> slip       where the edge meets it, |p - w| = r: a root of a trigonometric polynomial
    slip -> held       where λ = p'·e - r' falls to zero
    any -> free, free -> held or slip       at the roots of v

What is held has closed integrals, slip those of its collocation (`disc_slip`). Of no event but a
touch-down does the instant's derivative count: w is continuous, and at rest where it is caught.

Steps of slip are no longer than the one before resolves the path, and end at fixed angles. All
this changes continuously with the displacements, an event that passes one of the angles meeting a
step without length, so that w does, and Newton's iteration is not held up by jumps.
"""

import math

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear.contact.disc_slip import (
    DR,
    DX,
    DY,
    EX,
    EY,
    HIGHEST,
    NODES,
    PX,
    PY,
    RATE,
    SLOPE,
    STAGES,
    Path,
    R,
    Z,
    add_free,
    add_held,
    add_slip,
    changes_over,
    motion_at,
    slip_over,
)
from vanelock.nonlinear.fourier import TURN, derivative, kernel

_BRACKETS = 2  # angles that bracket events to one at which a step of slip ends
_RESOLVED = 5e-7
"""Of the displacements: the largest term of the highest power that a step's path should have."""
_ROUNDING = 1e-15  # of a step's z, below which its highest term is rounding
_FIRST = 0.3  # first step of slip, of the radius over the speed; of a whole step from a touch-down
_TURNING = 0.5  # of a step, to that in which the motion would turn back, at most
_SHRINK = 0.75  # of what is left to a lift-off, at most in one step
_NEAR = 5e-4  # ... but for the last, rad
_FUZZ = 4e-16  # of the displacements: rounding, by which a held slider may be outside
_REST = 1e-8
"""How long a slider that was caught is held at least, rad: λ, zero there, is rounding before."""


@kernel
def _excess(angle: float, u: Floats, alpha: float, path: Path) -> tuple[float, float]:
    """|p - w|² - r² and half its slope."""
    motion_at(angle, u, alpha, path.phi, path.motion)
    at = path.motion
    x, y, r = at[PX] - path.slider[0], at[PY] - path.slider[1], at[R]
    return x * x + y * y - r * r, x * at[DX] + y * at[DY] - r * at[DR]


@kernel
def _rounding(fuzz: float, path: Path) -> float:
    """What |p - w|² - r² may be of a slider on the edge."""
    r = path.motion[R]
    return float(1e-13 * r * r + fuzz * (2.0 * r + fuzz))


@kernel
def _met_between(left: float, right: float, u: Floats, alpha: float, path: Path) -> float:
    """Where the edge meets a held slider that is outside the disc at `right`."""
    for _ in range(40):  # at `left` it may still be on the edge
        middle = 0.5 * (left + right)
        if _excess(middle, u, alpha, path)[0] < 0.0:
            left = middle
            break
        right = middle
    angle = right
    for _ in range(80):
        f, slope = _excess(angle, u, alpha, path)
        if f < 0.0:
            left = angle
        else:
            right = angle
        following = angle - 0.5 * f / slope if slope != 0.0 else left
        if not left < following < right:
            following = 0.5 * (left + right)
        if abs(following - angle) <= 2e-16 * max(1.0, abs(angle)):
            return following
        angle = following
    return angle


@kernel
def _met(
    begin: float, end: float, fuzz: float, brackets: int, u: Floats, alpha: float, path: Path
) -> float:
    """Where from `begin` on the edge meets a held slider; `end` if it does not."""
    left, rising = begin, _excess(begin, u, alpha, path)[1] > 0.0
    index = math.floor(begin / TURN * brackets) + 1
    while left < end:
        right = min(TURN * index / brackets, end)
        index += 1
        if right <= left:
            continue
        f, slope = _excess(right, u, alpha, path)
        if f > _rounding(fuzz, path):
            return _met_between(left, right, u, alpha, path)
        if rising and slope < 0.0:  # perhaps outside for a while in between
            low, high = left, right
            while high - low > 1e-9:
                top = 0.5 * (low + high)
                f, along = _excess(top, u, alpha, path)
                if f > _rounding(fuzz, path):
                    return _met_between(left, top, u, alpha, path)
                low, high = (top, high) if along > 0.0 else (low, top)
        left, rising = right, slope > 0.0
    return end


@kernel
def _longest(length: float, limit: float, size: float, path: Path) -> float:
    """Longest next step, after one of a length that had a limit itself; of displacements' size."""
    highest, r = 0.0, 0.0
    for i in range(STAGES):
        highest += HIGHEST[i + 1] * path.slip[i, Z]
        r = max(r, path.motions[i, R])
    left_over = max(abs(highest) - _ROUNDING, 0.0) * r
    longest = limit + 0.5 * length
    if left_over > 0.0:
        longest = min(longest, length * (_RESOLVED * size / left_over) ** (1.0 / STAGES))
    return longest


@kernel
def _to_turning(angle: float, bent: Floats, alpha: float, r: float, path: Path) -> float:
    """Angle in which the motion, of `bent` velocities, turns back, and the force with it."""
    motion_at(angle, bent, alpha, path.phi, path.motion)
    at = path.motion
    speed, bending = math.hypot(at[PX], at[PY]), math.hypot(at[DX], at[DY])
    if bending == 0.0:
        return TURN
    return speed / bending + math.sqrt(max(r, 0.0) / bending)


@kernel
def _caught(
    begin: float, length: float, rate: float, fuzz: float, u: Floats, alpha: float, path: Path
) -> tuple[bool, float]:
    """Whether λ, `rate` at the beginning, falls to zero in a step; its length up to there."""
    slip, node = path.slip, 0
    while node < STAGES and slip[node, RATE] >= -fuzz:
        node += 1
    if node == STAGES:
        return False, length
    low = NODES[node - 1] * length if node > 0 else 0.0
    high = NODES[node] * length
    before = slip[node - 1, RATE] if node > 0 else max(rate, 0.0)
    length = low + before / (before - slip[node, RATE]) * (high - low)
    for _ in range(60):
        slip_over(begin, length, u, alpha, path)
        end = slip[STAGES - 1, RATE]
        if end < 0.0:
            high = length
        else:
            low = length
        slope = SLOPE[0] * rate  # of the polynomial through the beginning and all nodes
        for i in range(STAGES):
            slope += SLOPE[i + 1] * slip[i, RATE]
        following = length - end * length / slope if slope < 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - length) <= 1e-10:  # w rests there: it is off by the square
            break
        length = following
    return True, length


@kernel
def _begin_slip(x: float, y: float, path: Path) -> None:
    """The force along (x, y), and the changes across it."""
    size = math.hypot(x, y)
    if size == 0.0:  # where rounding leaves nothing of a disc
        x = size = 1.0
    path.force[0], path.force[1] = x / size, y / size
    for k in range(path.across.size):
        path.across[k] = (x * path.change[1, k] - y * path.change[0, k]) / size


@kernel
def _end_slip(alpha: float, path: Path) -> None:
    """W = p - r e at the end of a step and δw = e (e·δp - δr) + t η."""
    at, phi, m = path.motions[STAGES - 1], path.phis[STAGES - 1], path.phi.size
    ex, ey = path.force[0], path.force[1]
    path.slider[0], path.slider[1] = at[PX] - at[R] * ex, at[PY] - at[R] * ey
    for k in range(path.across.size):
        path.change[0, k], path.change[1, k] = -ey * path.across[k], ex * path.across[k]
    if path.across.size < 3 * m:
        return
    for block in range(3):
        share = -alpha if block == 0 else ex if block == 1 else ey
        for k in range(m):
            path.change[0, block * m + k] += ex * share * phi[k]
            path.change[1, block * m + k] += ey * share * phi[k]


@kernel
def _touch_down(angle: float, u: Floats, alpha: float, path: Path) -> bool:
    """Begin at the disc's centre; whether it slips at once, its centre faster than its edge."""
    motion_at(angle, u, alpha, path.phi, path.motion)
    at, m = path.motion, path.phi.size
    path.slider[0], path.slider[1] = at[PX], at[PY]
    slips = bool(math.hypot(at[DX], at[DY]) > at[DR])
    later = 0.0 if slips or at[DR] <= 0.0 else -alpha / at[DR]  # the instant moves with v
    for k in range(m):
        path.change[0, k], path.change[1, k] = (
            later * at[DX] * path.phi[k],
            later * at[DY] * path.phi[k],
        )
        path.change[0, m + k] = path.change[1, 2 * m + k] = path.phi[k]
        path.change[0, 2 * m + k] = path.change[1, m + k] = 0.0
    if slips:
        _begin_slip(at[DX], at[DY], path)
    return slips


@kernel
def _closed(
    angle: float, last: float, opens: bool, slips: bool, brackets: int, u: Floats, alpha: float,
    path: Path,
) -> tuple[bool, float]:  # fmt: skip
    """Follow a slider through closed contact; whether it slips anywhere, and ∫ r |dw|."""
    knots, work, any_slip = brackets // _BRACKETS, 0.0, False
    force, at, slip = path.force, path.motion, path.slip
    rate, limit = force[0] * at[DX] + force[1] * at[DY] - at[DR], _FIRST * TURN / knots
    r, size, bent = at[R], 0.0, np.empty(u.shape)
    for i in range(3):
        bent[i] = derivative(u[i])
    for k in range(1, u.shape[1]):
        size += u[1, k] ** 2 + u[2, k] ** 2
    size, rested = math.sqrt(size), angle
    fuzz = _FUZZ * (size + math.hypot(u[1, 0], u[2, 0]))
    for _ in range(400 * knots):
        if not slips:
            end = _met(min(rested, last), last, fuzz, brackets, u, alpha, path)
            add_held(angle, end, path)
            angle = end
        if angle >= last:
            break
        if not slips:
            motion_at(angle, u, alpha, path.phi, at)
            x, y = at[PX] - path.slider[0], at[PY] - path.slider[1]
            _begin_slip(x, y, path)
            rate = force[0] * at[DX] + force[1] * at[DY] - at[DR]
            limit = _FIRST * math.hypot(x, y) / max(math.hypot(at[DX], at[DY]), 1e-300)
            slips, r = True, at[R]
        knot = TURN * (math.floor(angle / TURN * knots) + 1) / knots
        if knot <= angle:
            knot += TURN / knots
        length = min(min(knot, last) - angle, limit)
        if opens and last - angle > _NEAR:
            length = min(length, _SHRINK * (last - angle))
        length = min(length, _TURNING * _to_turning(angle, bent, alpha, r, path))
        slip_over(angle, length, u, alpha, path)
        r = path.motions[STAGES - 1, R]
        limit = _longest(length, limit, size, path)
        caught, length = _caught(angle, length, rate, fuzz, u, alpha, path)
        changes_over(length, alpha, path)
        work += add_slip(angle, length, path)
        any_slip = True
        angle += length
        if last - angle < 1e-14:
            angle = last
        force[0], force[1] = slip[STAGES - 1, EX], slip[STAGES - 1, EY]
        rate = slip[STAGES - 1, RATE]
        path.across[:] = path.eta[STAGES - 1]
        if caught or angle >= last:
            _end_slip(alpha, path)
            slips, rested = False, angle + _REST
    else:
        path.w[:] = math.nan  # it did not arrive
    return any_slip, work


@kernel
def once_round(
    u: Floats, alpha: float, contact: Floats, count: int, brackets: int, path: Path
) -> tuple[bool, float]:
    """Follow a slider over a period from the first touch-down, or from 0 where it is given."""
    if count == 0:
        motion_at(0.0, u, alpha, path.phi, path.motion)
        at = path.motion
        x, y = at[PX] - path.slider[0], at[PY] - path.slider[1]
        size, slips = math.hypot(x, y), False
        if size >= (1.0 - 1e-13) * at[R]:
            _begin_slip(x, y, path)
            slips = at[DX] * path.force[0] + at[DY] * path.force[1] > at[DR]
        return _closed(0.0, TURN, False, slips, brackets, u, alpha, path)
    at_zero = u[0, 0]
    for k in range(1, u.shape[1], 2):
        at_zero += u[0, k]
    first = 1 if at_zero >= 0.0 else 0
    slips, work = False, 0.0
    for i in range(first, count, 2):
        last = contact[i + 1] if i + 1 < count else contact[0] + TURN
        again = contact[i + 2] if i + 2 < count else contact[first] + TURN
        begins = _touch_down(contact[i], u, alpha, path)
        slid, done = _closed(contact[i], last, True, begins, brackets, u, alpha, path)
        add_free(last, again, path)
        slips, work = slips or slid, work + done
    return slips, work
