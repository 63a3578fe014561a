"""The contact law with located events: integrals are exact, segment by segment."""

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.contact.normal import CLOSED, add_normal, place, scale
from vanelock.nonlinear.contact.orthogonal.slider import (
    BEGIN,
    END,
    FACTOR,
    FREE,
    HELD,
    HIGH,
    KIND,
    LOW,
    PLACE,
    SOURCE,
    WIDTH,
    slider_path,
)
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import (
    TURN,
    Floats,
    add_integrals,
    basis_at,
    derivative,
    gram,
    roots,
)


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
def located_law(
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
    """The law with located events, contact by contact."""
    m = u.shape[2]
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
