"""Integrals over a slider's path in a moving disc, and Fourier coefficients from them."""

from typing import NamedTuple

import numpy as np

from vanelock.common.arrays import Complex, Floats, Integers
from vanelock.nonlinear.contact.isotropic.disc_slider import FREE, HELD, SLIPPING
from vanelock.nonlinear.contact.isotropic.disc_slip import EX, EY, RATE, STAGES, WEIGHTS, R, Z
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import TURN, add_integrals, gram

# Rows of the moments: of e_x, e_y, e_x², e_x e_y and 1 over slip, of 1 over what is free.
FORCE_X, FORCE_Y, FORCE_XX, FORCE_XY, SLIPS, IS_FREE = 0, 1, 2, 3, 4, 5
# Columns of a piece of the path: HELD, SLIPPING or FREE and its angles; the place of what is held,
# e at the beginning of a step of slip, and the step's z at the nodes.
KIND, BEGIN, END, X, Y, STEP = 0, 1, 2, 3, 4, 5
WIDTH = STEP + STAGES


class Path(NamedTuple):
    """What a lap works on and adds to.

    Attributes
    ----------
    place, change : (2,), (2, n)
        The slider and its changes: with the coefficients of (v, u1, u2) in the first 3 m columns,
        unless n < 3 m, and with what else is given at the beginning. At the end, those there.
    force : (2,)
        e of a slip.
    across : (n,)
        η of a slip.
    phi, motion : (m,), (6,)
        At one angle.
    phis, motions, slip, eta : (s, m), (s, 6), (s, 5), (s, n)
        At the nodes of a step.
    moments : (6, 2m - 1)
        ∫ (e_x, e_y, e_x², e_x e_y) e^{ikθ} of slip, ∫ e^{ikθ} of slip and of what is free.
    w, jacobian : (2, m), (2, m, n)
        ∫ w φ_j of what is held, and ∫ φ_j dw but for what the moments hold.
    pieces, filled : (p, WIDTH), (1,)
        The path piece by piece where there is room, and how many there are.
    """

    place: Floats
    change: Floats
    force: Floats
    across: Floats
    phi: Floats
    motion: Floats
    phis: Floats
    motions: Floats
    slip: Floats
    eta: Floats
    moments: Complex
    w: Floats
    jacobian: Floats
    pieces: Floats
    filled: Integers


@kernel
def new_path(m: int, columns: int, pieces: int) -> Path:
    """A path of which nothing is known, with room for so many pieces."""
    return Path(
        np.zeros(2),
        np.zeros((2, columns)),
        np.zeros(2),
        np.zeros(columns),
        np.empty(m),
        np.empty(6),
        np.empty((STAGES, m)),
        np.empty((STAGES, 6)),
        np.empty((STAGES, 5)),
        np.empty((STAGES, columns)),
        np.zeros((6, 2 * m - 1), np.complex128),
        np.zeros((2, m)),
        np.zeros((2, m, columns)),
        np.zeros((pieces, WIDTH)),
        np.zeros(1, np.int64),
    )


@kernel
def _write(kind: int, begin: float, end: float, x: float, y: float, path: Path) -> None:
    """Write a piece down."""
    if end <= begin:
        return
    place = path.filled[0]
    path.filled[0] += 1
    if place < len(path.pieces):
        row = path.pieces[place]
        row[KIND], row[BEGIN], row[END], row[X], row[Y] = kind, begin, end, x, y
        if kind == SLIPPING:
            row[STEP:] = path.slip[:, Z]


@kernel
def add_free(begin: float, end: float, path: Path) -> None:
    """Add the integrals of a free slider."""
    add_integrals(begin, end, path.moments[IS_FREE])
    _write(FREE, begin, end, 0.0, 0.0, path)


@kernel
def add_held(begin: float, end: float, path: Path) -> None:
    """Add the integrals of a held slider and of its changes."""
    _write(HELD, begin, end, path.place[0], path.place[1], path)
    m = path.w.shape[1]
    held = np.zeros((m + 1) // 2, np.complex128)
    add_integrals(begin, end, held)
    for j in range(m):
        h = (j + 1) // 2
        integral = -held[h].imag if j > 0 and j % 2 == 0 else held[h].real
        for i in range(2):
            path.w[i, j] += path.place[i] * integral
            for k in range(path.change.shape[1]):
                path.jacobian[i, j, k] += path.change[i, k] * integral


@kernel
def add_slip(begin: float, length: float, path: Path) -> float:
    """Add the integrals of a step of slip, e that at its beginning; returns ∫ r λ."""
    _write(SLIPPING, begin, begin + length, path.force[0], path.force[1], path)
    work, slip, phis, moments = 0.0, path.slip, path.phis, path.moments
    m, columns = phis.shape[1], path.eta.shape[1]
    add_integrals(begin, begin + length, moments[SLIPS])
    for n in range(STAGES):
        share = length * WEIGHTS[n]
        ex, ey = slip[n, EX], slip[n, EY]
        work += share * path.motions[n, R] * max(slip[n, RATE], 0.0)
        turn, power = complex(phis[n, 1], -phis[n, 2]), complex(share, 0.0)
        for k in range(moments.shape[1]):
            moments[FORCE_X, k] += ex * power
            moments[FORCE_Y, k] += ey * power
            moments[FORCE_XX, k] += ex * ex * power
            moments[FORCE_XY, k] += ex * ey * power
            power *= turn
        for j in range(m):
            on_x, on_y = -share * ey * phis[n, j], share * ex * phis[n, j]
            for k in range(columns):
                path.jacobian[0, j, k] += on_x * path.eta[n, k]
                path.jacobian[1, j, k] += on_y * path.eta[n, k]
    return work


@kernel
def add_coefficients(u: Floats, alpha: float, path: Path, w: Floats, jacobian: Floats) -> None:
    """Fourier coefficients of a path and their derivatives, from its integrals."""
    m = u.shape[1]
    grams = np.empty((6, m, m))
    for row in range(6):
        gram(path.moments[row], grams[row])
    ex, ey, xx, xy = grams[FORCE_X], grams[FORCE_Y], grams[FORCE_XX], grams[FORCE_XY]
    slips, free = grams[SLIPS], grams[IS_FREE]
    for j in range(m):
        over = 1.0 / TURN if j == 0 else 2.0 / TURN
        x, y = path.w[0, j], path.w[1, j]
        for k in range(m):
            both = slips[j, k] + free[j, k]
            x += both * u[1, k] - alpha * ex[j, k] * u[0, k]
            y += both * u[2, k] - alpha * ey[j, k] * u[0, k]
            jacobian[1, j, 0, k] = over * (path.jacobian[0, j, k] - alpha * ex[j, k])
            jacobian[2, j, 0, k] = over * (path.jacobian[1, j, k] - alpha * ey[j, k])
            jacobian[1, j, 1, k] = over * (path.jacobian[0, j, m + k] + free[j, k] + xx[j, k])
            jacobian[1, j, 2, k] = over * (path.jacobian[0, j, 2 * m + k] + xy[j, k])
            jacobian[2, j, 1, k] = over * (path.jacobian[1, j, m + k] + xy[j, k])
            jacobian[2, j, 2, k] = over * (path.jacobian[1, j, 2 * m + k] + both - xx[j, k])
        w[1, j], w[2, j] = over * x, over * y
