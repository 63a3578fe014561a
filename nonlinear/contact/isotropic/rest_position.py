"""Where a slider that sticks for good rests: the point nearest to zero common to all discs.

A contact that is assembled unstressed and then shaken slides until no instant's disc |w - u| <= r
leaves it out. Among the places where it may end, the one nearest to zero depends neither on the
origin of time nor on the way there. It is found as one solves a small convex programme of two
unknowns: the most violated disc enters the at most two that hold the point.
"""

import math

from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import Floats

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
    w: Floats, centre: Floats, radius: Floats, first: int, second: int, to_first: Floats,
    to_second: Floats,
) -> None:  # fmt: skip
    """Rates (2, 3) of the rest point to the centre and radius of the discs that hold it."""
    ex, ey = centre[first, 0] - w[0], centre[first, 1] - w[1]
    size = math.hypot(ex, ey)
    ex, ey = ex / size, ey / size
    to_first[:] = 0.0
    to_second[:] = 0.0
    if second == NONE:
        turned = math.hypot(w[0], w[1]) / math.hypot(centre[first, 0], centre[first, 1])
        to_first[0, 0] = ex * ex + turned * ey * ey
        to_first[0, 1] = to_first[1, 0] = (1.0 - turned) * ex * ey
        to_first[1, 1] = ey * ey + turned * ex * ex
        to_first[0, 2], to_first[1, 2] = -ex, -ey
        return
    fx, fy = centre[second, 0] - w[0], centre[second, 1] - w[1]
    size = math.hypot(fx, fy)
    fx, fy = fx / size, fy / size
    # e·(δu - δw) = δr on both edges
    det = ex * fy - ey * fx
    if det == 0.0:
        return
    to_first[0, 0], to_first[0, 1], to_first[0, 2] = fy * ex / det, fy * ey / det, -fy / det
    to_first[1, 0], to_first[1, 1], to_first[1, 2] = -fx * ex / det, -fx * ey / det, fx / det
    to_second[0, 0], to_second[0, 1], to_second[0, 2] = -ey * fx / det, -ey * fy / det, ey / det
    to_second[1, 0], to_second[1, 1], to_second[1, 2] = ex * fx / det, ex * fy / det, -ex / det
