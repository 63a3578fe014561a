"""One step of a friction slider that follows a disc in the tangential plane.

With isotropic friction and equal stiffness in both directions, t = kt (u - w), |t| <= μ n, the
slider at w is inside a disc of radius r = α v, α = μ kn/kt, whose centre is u. Sticking holds w;
slipping moves it with the disc's edge, along the friction force (Moreau's sweeping process). With
u - w = r (cos ψ, sin ψ) that is a pursuit,

    r dψ = du · (-sin ψ, cos ψ),

which has a closed form while u moves straight and r linearly: the angle χ between the force and the
motion shrinks as tan(χ/2) ∝ exp(-∫ |du|/r), the tractrix of a disc that changes its size. Slip
begins where the straight trial path leaves the disc, a root of a quadratic, and lasts to the
step's end, since χ only shrinks.
"""

import math

from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import Floats

HELD, SLIPPING, FREE = 0, 1, 2

# Columns of the rates of w at the end of a step: to w at its beginning, to the centre at the
# beginning and at the end, two each, and to the two radii.
START, FROM, TO, SMALLER, LARGER = 0, 2, 4, 6, 7
RATES = 8


@kernel
def _follow_centre(centre: Floats, out: Floats, rates: Floats) -> None:
    """An open contact's slider is where u is."""
    rates[:] = 0.0
    for i in range(2):
        out[i] = centre[i]
        rates[i, TO + i] = 1.0


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
            rates[i, FROM + i] = share
            rates[i, TO + i] = 1.0 - share
            rates[i, SMALLER] = -d * r1 / growth**2
            rates[i, LARGER] = d * r0 / growth**2
        return HELD, 0.0
    px, py = dx / length, dy / length
    out[0], out[1] = b[0] - r1 * px, b[1] - r1 * py
    across = (-py, px)
    for i in range(2):
        for j in range(2):
            turned = r1 / length * across[i] * across[j]
            rates[i, FROM + j] = turned
            rates[i, TO + j] = (1.0 if i == j else 0.0) - turned
    rates[0, LARGER], rates[1, LARGER] = -px, -py
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
    if r1 <= 0.0:
        _follow_centre(b, out, rates)
        return FREE, 0.0
    if r0 <= 0.0:
        return _touch_down(a, b, r0, r1, out, rates)
    trial_x, trial_y = b[0] - w[0], b[1] - w[1]
    if trial_x * trial_x + trial_y * trial_y <= r1 * r1:  # inside at both ends is inside between
        out[0], out[1] = w[0], w[1]
        rates[:] = 0.0
        rates[0, START] = rates[1, START + 1] = 1.0
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
        rates[i, START], rates[i, START + 1] = d0x + d1x, d0y + d1y
        rates[i, FROM], rates[i, FROM + 1] = -d0x, -d0y
        rates[i, TO], rates[i, TO + 1] = -d1x, -d1y
        rates[i, TO + i] += 1.0
        rates[i, SMALLER] = -to_first
        rates[i, LARGER] = -to_last - (fx if i == 0 else fy)
