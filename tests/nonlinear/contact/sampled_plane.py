"""Isotropic friction on the polygon through samples: a second way to the law with located events.

Between samples of (u1, u2) and of the bound α v the slider's path has a closed form
(`disc_slider`), so that coefficients are of second order in the sampling, touch-downs and partial
slip included. A contact that opens forgets: one lap from an open instant is the periodic path.
"""

from types import SimpleNamespace

import numpy as np

from vanelock.nonlinear.contact.disc_slider import (
    HELD,
    RATES,
    SLIPPING,
    periodic_start,
    pursue,
    rest_point,
)
from vanelock.nonlinear.contact.law import OPEN, SLIP, SLIP_OPEN, STUCK
from vanelock.nonlinear.fourier import TURN, basis, kernel


@kernel
def _lap(centre, radius, path):
    """Periodic path (s, 2) of a slider that slips or opens; whether it slips, and ∫ α v |dw|."""
    size = radius.size
    now, following, rates = np.empty(2), np.empty(2), np.empty((2, RATES))
    start = int(radius.argmin())
    if radius[start] <= 0.0:
        now[:] = centre[start]
    else:
        start = 0
        periodic_start(centre, radius, now)
    slips, work = False, 0.0
    for n in range(size):
        i, j = (start + n) % size, (start + n + 1) % size
        kind, share = pursue(now, centre[i], centre[j], radius[i], radius[j], following, rates)
        if kind != HELD or radius[i] <= 0.0:
            now[:] = following
        slips = slips or kind == SLIPPING
        work += share
        path[j] = now
    return slips, work


def sampled_plane(made, samples, u):
    """Coefficients w (c, 3, 2H + 1), the normal ones zero, state and dissipation (c,)."""
    table = basis(u.shape[2] // 2, TURN * np.arange(samples) / samples)
    w, rest, path = np.zeros_like(u), np.empty(2), np.empty((samples, 2))
    state, dissipation = np.full(len(u), STUCK), np.zeros(len(u))
    for c, alpha in enumerate(made.alpha[:, 0]):
        v, centre = table @ u[c, 0], np.ascontiguousarray(table @ u[c, 1:].T)
        if (v > 0).all() and rest_point(centre, alpha * v, rest)[0]:
            w[c, 1:, 0] = rest
            continue
        slips, work = _lap(centre, alpha * v, path)
        w[c, 1:] = 2 / samples * path.T @ table
        w[c, 1:, 0] /= 2
        dissipation[c] = made.kt[c, 0] * work
        if (v <= 0).any():
            state[c] = OPEN if (v <= 0).all() else SLIP_OPEN
        elif slips or alpha == 0:
            state[c] = SLIP
    return SimpleNamespace(w=w, state=state, dissipation=dissipation)
