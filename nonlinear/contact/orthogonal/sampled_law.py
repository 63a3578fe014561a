"""The contact law on plain samples: a reference for the one with located events, and quick.

Events fall between samples, so the coefficients carry an error of first order in their distance;
the Jacobian is the exact derivative of the sampled law, followed through the states.
"""

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.contact.normal import ALWAYS, CLOSED, PARTLY
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import Floats


@kernel
def sampled_law(
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
    """The law on plain samples, contact by contact."""
    for c in range(u.shape[0]):
        opening[c], slips[c], energy[c] = sampled_contact(
            u[c], alpha[c], stiffness[c], table, w[c], jacobian[c]
        )


@kernel
def sampled_contact(
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
