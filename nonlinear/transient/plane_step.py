"""A slider bounded in the tangential plane at the end of a time step, compiled.

Within the step its disc's centre moves straight and its radius linearly, so that its path has a
closed form (`disc_slider`): the place w at the end is a function P of the centre there, which w
itself moves,

    w = P(known + G w),

two equations, solved by Newton's method with the closed form's derivative. Where a step of it
does not come closer, one of the plain iteration is taken.
"""

import math

from vanelock.nonlinear.contact.isotropic.disc_slider import HELD, TO, pursue
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import Floats

ITERATIONS = 60
CLOSE = 1e-14
"""Of the displacements: what P(known + G w) may be off w at the end of the iteration."""


@kernel
def slider_in_plane(
    known: Floats,
    own: Floats,
    held: Floats,
    u_before: Floats,
    r_before: float,
    r: float,
    place: Floats,
    following: Floats,
    rates: Floats,
) -> None:
    """Place w of a slider at the end of a step, u = known + own w."""
    x, y, before = place[0], place[1], math.inf
    centre = u_before.copy()
    for _ in range(ITERATIONS):
        centre[0] = known[0] + own[0, 0] * x + own[0, 1] * y
        centre[1] = known[1] + own[1, 0] * x + own[1, 1] * y
        kind, _ = pursue(held, u_before, centre, r_before, r, following, rates)
        fx, fy = following[0] - x, following[1] - y
        apart = math.hypot(fx, fy)
        size = abs(centre[0]) + abs(centre[1]) + abs(following[0]) + abs(following[1])
        if apart <= CLOSE * size:
            break
        if apart >= before or (kind == HELD and r_before > 0.0):
            x, y, before = following[0], following[1], math.inf
            continue
        before = apart
        a, b = rates[0, TO], rates[0, TO + 1]
        c, d = rates[1, TO], rates[1, TO + 1]
        m00, m01 = 1.0 - a * own[0, 0] - b * own[1, 0], -a * own[0, 1] - b * own[1, 1]
        m10, m11 = -c * own[0, 0] - d * own[1, 0], 1.0 - c * own[0, 1] - d * own[1, 1]
        det = m00 * m11 - m01 * m10
        x += (m11 * fx - m01 * fy) / det
        y += (m00 * fy - m10 * fx) / det
    place[0], place[1] = following[0], following[1]
