"""One step of a friction slider that follows a disc in the tangential plane.

With isotropic friction and equal stiffness in both directions, t = kt (u - w), |t| <= μ n, the
slider at w is inside a disc of radius r = α v, α = μ kn/kt, whose centre is u. Sticking holds w;
slipping moves it with the disc's edge, along the friction force (Moreau's sweeping process). With
u - w = r (cos ψ, sin ψ) that is a pursuit,

    r dψ = du · (-sin ψ, cos ψ),

which has a closed form while u moves straight and r linearly: the angle χ between the force and the
motion shrinks as tan(χ/2) ∝ exp(-∫ |du|/r), the tractrix of a disc that changes its size. Slip
begins where the straight trial path leaves the disc, a root of a quadratic, and lasts to the
step's end, since χ only shrinks. Step by step it follows the polygon through samples: the periodic
path of a contact that slips in every period is unique, and Newton's iteration on one lap's map of
the plane finds where it begins.

A slider that sticks for good rests at the point nearest to zero common to all discs. A contact that
is assembled unstressed and then shaken slides until no instant's disc |w - u| <= r leaves it out.
Among the places where it may end, the one nearest to zero depends neither on the origin of time nor
on the way there. It is found as one solves a small convex programme of two unknowns: the most
violated disc enters the at most two that hold the point.
"""

import math

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear.fourier import kernel

HELD, SLIPPING, FREE = 0, 1, 2
_LAPS = 200

# Columns of the rates of w at the end of a step: to w at its beginning, to the centre at the
# beginning and at the end, two each, and to the two radii.
_START, _FROM, TO, _SMALLER, _LARGER = 0, 2, 4, 6, 7
RATES = 8


@kernel
def _touch_down(
    a: Floats, b: Floats, r0: float, r1: float, out: Floats, rates: Floats
) -> tuple[int, float]:
    """A disc that opens from nothing within the step: unstressed there, then held or dragged."""
    growth = r1 - r0
    share = r1 / growth  # of the step in contact
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = math.hypot(dx, dy)
    rates[:] = 0.0
    if length <= growth:
        for i in range(2):
            d = b[i] - a[i]
            out[i] = b[i] - share * d
            rates[i, _FROM + i] = share
            rates[i, TO + i] = 1.0 - share
            rates[i, _SMALLER] = -d * r1 / growth**2
            rates[i, _LARGER] = d * r0 / growth**2
        return HELD, 0.0
    px, py = dx / length, dy / length
    out[0], out[1] = b[0] - r1 * px, b[1] - r1 * py
    across = (-py, px)
    for i in range(2):
        for j in range(2):
            turned = r1 / length * across[i] * across[j]
            rates[i, _FROM + j] = turned
            rates[i, TO + j] = (1.0 if i == j else 0.0) - turned
    rates[0, _LARGER], rates[1, _LARGER] = -px, -py
    return SLIPPING, 0.5 * r1 * share * (length - growth)


@kernel
def _mean_inverse(r0: float, r1: float) -> tuple[float, float, float]:
    """Mean of 1/r between two radii, ln(r1/r0)/(r1 - r0), and its derivatives to r0 and r1."""
    z = (r1 - r0) / r0
    if abs(z) < 1e-2:
        mean, slope, power = 0.0, 0.0, 1.0
        for k in range(8):  # Σ (-z)^k / (k + 1) and its derivative to z
            mean += power / (k + 1)
            slope -= (k + 1) * power / (k + 2)
            power *= -z
        mean /= r0
        to_last = slope / r0**2
    else:
        mean = math.log(r1 / r0) / (r1 - r0)
        to_last = (1.0 / r1 - mean) / (r1 - r0)
    return mean, -(mean + r1 * to_last) / r0, to_last


@kernel
def pursue(
    w: Floats, a: Floats, b: Floats, r0: float, r1: float, out: Floats, rates: Floats
) -> tuple[int, float]:
    """Move a slider at w while the disc's centre moves straight and its radius linearly.

    From `a` and r0 to `b` and r1, which are not positive where the contact is open; `out` and
    `rates` (2, 8) receive the slider at the end and, unless HELD from the beginning, its rates.
    """
    if r1 <= 0.0:  # an open contact's slider is where u is
        rates[:] = 0.0
        out[0], out[1] = b[0], b[1]
        rates[0, TO] = rates[1, TO + 1] = 1.0
        return FREE, 0.0
    if r0 <= 0.0:
        return _touch_down(a, b, r0, r1, out, rates)
    trial_x, trial_y = b[0] - w[0], b[1] - w[1]
    if trial_x * trial_x + trial_y * trial_y <= r1 * r1:  # inside at both ends is inside between
        out[0], out[1] = w[0], w[1]
        rates[:] = 0.0
        rates[0, _START] = rates[1, _START + 1] = 1.0
        return HELD, 0.0
    # Slip begins at the share s of the step where |d0 + s Δ| = r0 + s ρ.
    x, y = a[0] - w[0], a[1] - w[1]
    dx, dy, growth = b[0] - a[0], b[1] - a[1], r1 - r0
    square = dx * dx + dy * dy - growth * growth
    linear = x * dx + y * dy - r0 * growth
    constant = min(x * x + y * y - r0 * r0, 0.0)
    s, root = 0.0, 0.0
    if linear < 0.0 or constant < -1e-13 * r0 * r0:
        root = math.sqrt(max(linear * linear - square * constant, 0.0))
        over, under = (-constant, linear + root) if linear >= 0.0 else (root - linear, square)
        s = min(max(over / under, 0.0), 1.0) if under > 0.0 else 1.0
    left = 1.0 - s
    x, y, r = x + s * dx, y + s * dy, r0 + s * growth
    size, length = math.hypot(x, y), math.hypot(dx, dy)
    if size == 0.0:  # where rounding leaves nothing of the disc
        return _touch_down(a, b, 0.0, r1, out, rates)
    ex, ey = x / size, y / size
    px, py = (dx / length, dy / length) if length > 0.0 else (ex, ey)
    # The pursuit over the rest of the step.
    mean, to_first, to_last = _mean_inverse(r, r1)
    reach = left * mean
    fall = math.exp(-length * reach)
    cosine, sine = ex * px + ey * py, px * ey - py * ex
    ahead, behind = 0.5 * (1.0 + cosine), 0.5 * (1.0 - cosine)
    scale = ahead + fall * fall * behind
    if scale > 1e-300:
        cosine, sine = (ahead - fall * fall * behind) / scale, fall * sine / scale
        kept = fall / scale  # dχ after / dχ before
        share = -math.expm1(-length * reach) / length if length > 0.0 else reach
        lost = share * (ahead * (1.0 + fall) - fall) / scale  # (1 - kept) / length
    else:
        cosine, sine, kept, lost = 1.0, 0.0, 0.0, 1.0 / length
    fx, fy = cosine * px - sine * py, cosine * py + sine * px
    out[0], out[1] = b[0] - r1 * fx, b[1] - r1 * fy
    # δψ for unit changes of d0, d1 (two each), r0 and r1
    for k in range(6):
        first, last = 1.0 if k < 2 else 0.0, 1.0 if 2 <= k < 4 else 0.0
        along_x, along_y = (1.0, 0.0) if k % 2 == 0 else (0.0, 1.0)
        point = left * first + s * last
        radius = left if k == 4 else s if k == 5 else 0.0
        later = 0.0
        if root > 0.0:
            later = -(point * (x * along_x + y * along_y) - r * radius) / root
        moved_x, moved_y = point * along_x + later * dx, point * along_y + later * dy
        radius += later * growth
        turned = (ex * moved_y - ey * moved_x) / size
        step_x, step_y = (last - first) * along_x, (last - first) * along_y
        grown = reach * (px * step_x + py * step_y) - length * mean * later
        grown += length * left * (to_first * radius + (to_last if k == 5 else 0.0))
        change = kept * turned + lost * (px * step_y - py * step_x) - sine * grown
        rates[0, k], rates[1, k] = -fy * r1 * change, fx * r1 * change
    _rearrange(fx, fy, rates)
    return SLIPPING, 0.5 * (r + r1) * math.hypot(out[0] - w[0], out[1] - w[1])


@kernel
def _rearrange(fx: float, fy: float, rates: Floats) -> None:
    """Rates of u - w to (d0, d1, r0, r1) into those of w to (w, u0, u1, r0, r1)."""
    for i in range(2):
        to_first, to_last = rates[i, 4], rates[i, 5]
        d0x, d0y, d1x, d1y = rates[i, 0], rates[i, 1], rates[i, 2], rates[i, 3]
        rates[i, _START], rates[i, _START + 1] = d0x + d1x, d0y + d1y
        rates[i, _FROM], rates[i, _FROM + 1] = -d0x, -d0y
        rates[i, TO], rates[i, TO + 1] = -d1x, -d1y
        rates[i, TO + i] += 1.0
        rates[i, _SMALLER] = -to_first
        rates[i, _LARGER] = -to_last - (fx if i == 0 else fy)


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
            turn[0, k] = rates[0, _START] * x + rates[0, _START + 1] * y
            turn[1, k] = rates[1, _START] * x + rates[1, _START + 1] * y


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
    for _ in range(_LAPS):
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


NONE = -1


@kernel
def outside(w: Floats, centre: Floats, radius: Floats, i: int) -> float:
    """How far w is outside the i-th disc."""
    distance = math.hypot(w[0] - centre[i, 0], w[1] - centre[i, 1])
    return float(distance - radius[i])


@kernel
def _nearest(centre: Floats, radius: Floats, i: int, out: Floats) -> None:
    """Point of one disc nearest to zero."""
    distance = math.hypot(centre[i, 0], centre[i, 1])
    share = max(0.0, 1.0 - radius[i] / distance) if distance > 0.0 else 0.0
    out[0], out[1] = share * centre[i, 0], share * centre[i, 1]


@kernel
def _corner(centre: Floats, radius: Floats, i: int, j: int, side: float, out: Floats) -> bool:
    """One of the two points where the edges of two discs cross."""
    dx, dy = centre[j, 0] - centre[i, 0], centre[j, 1] - centre[i, 1]
    apart = math.hypot(dx, dy)
    if apart == 0.0:
        return False
    along = 0.5 * (apart + (radius[i] - radius[j]) * (radius[i] + radius[j]) / apart)
    height = (radius[i] - along) * (radius[i] + along)
    if height < 0.0:
        return False
    height = side * math.sqrt(height)
    out[0] = centre[i, 0] + (along * dx - height * dy) / apart
    out[1] = centre[i, 1] + (along * dy + height * dx) / apart
    return True


@kernel
def rest_point(centre: Floats, radius: Floats, w: Floats) -> tuple[bool, int, int]:
    """Find the common point of all discs nearest to zero."""
    size = 0.0
    for i in range(radius.size):
        size = max(size, abs(centre[i, 0]), abs(centre[i, 1]), abs(radius[i]))
    slack = 1e-13 * size
    w[0] = w[1] = 0.0
    first, second = NONE, NONE
    trial_x, trial_y = 0.0, 0.0
    for _ in range(200):
        worst, entering = slack, NONE
        for i in range(radius.size):
            excess = outside(w, centre, radius, i)
            if excess > worst:
                worst, entering = excess, i
        if entering == NONE:
            return True, first, second
        # the nearest point of the entering disc and those that held the last one
        best, kept = math.inf, NONE
        old = (first, second)
        _nearest(centre, radius, entering, w)
        inside = True
        for i in old:
            inside = inside and (i == NONE or outside(w, centre, radius, i) <= slack)
        if inside:
            best, trial_x, trial_y = 0.0, w[0], w[1]
        else:
            for n in range(2):
                if old[n] == NONE:
                    continue
                other = old[1 - n]
                for side in (-1.0, 1.0):
                    if not _corner(centre, radius, entering, old[n], side, w):
                        continue
                    if other != NONE and outside(w, centre, radius, other) > slack:
                        continue
                    distance = math.hypot(w[0], w[1])
                    if distance < best:
                        best, kept, trial_x, trial_y = distance, old[n], w[0], w[1]
        if best == math.inf:
            return False, NONE, NONE
        first, second = entering, kept
        w[0], w[1] = trial_x, trial_y
    return False, NONE, NONE


@kernel
def rest_rates(
    w: Floats, centre: Floats, radius: Floats, one: int, other: int, to_one: Floats,
    to_other: Floats,
) -> None:  # fmt: skip
    """Rates (2, 3) of the rest point to the centre and radius of the discs that hold it."""
    ex, ey = centre[one, 0] - w[0], centre[one, 1] - w[1]
    size = math.hypot(ex, ey)
    ex, ey = ex / size, ey / size
    to_one[:] = 0.0
    to_other[:] = 0.0
    if other == NONE:
        turned = math.hypot(w[0], w[1]) / math.hypot(centre[one, 0], centre[one, 1])
        to_one[0, 0] = ex * ex + turned * ey * ey
        to_one[0, 1] = to_one[1, 0] = (1.0 - turned) * ex * ey
        to_one[1, 1] = ey * ey + turned * ex * ex
        to_one[0, 2], to_one[1, 2] = -ex, -ey
        return
    fx, fy = centre[other, 0] - w[0], centre[other, 1] - w[1]
    size = math.hypot(fx, fy)
    fx, fy = fx / size, fy / size
    # e·(δu - δw) = δr on both edges
    det = ex * fy - ey * fx
    if det == 0.0:
        return
    to_one[0, 0], to_one[0, 1], to_one[0, 2] = fy * ex / det, fy * ey / det, -fy / det
    to_one[1, 0], to_one[1, 1], to_one[1, 2] = -fx * ex / det, -fx * ey / det, fx / det
    to_other[0, 0], to_other[0, 1], to_other[0, 2] = -ey * fx / det, -ey * fy / det, ey / det
    to_other[1, 0], to_other[1, 1], to_other[1, 2] = ex * fx / det, ex * fy / det, -ex / det
