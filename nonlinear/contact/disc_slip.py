"""Slip on the edge of a moving disc over one step, by collocation.

A slider on the edge of a disc, w = p - r e, e a unit vector, t across it, moves along the friction
force, w' = λ e (`disc_slider`). So the force turns by

    e' = ψ' t,        r ψ' = p'·t,        λ = p'·e - r' >= 0,

and with e = (e0 (1 - z²) + 2 z t0)/(1 + z²), e0 at the step's beginning, that is Riccati's equation

    z' = (b (1 - z²) - 2 a z)/(2 r),        a = p'·e0,  b = p'·t0.

What changes of p, r and of the slider at the beginning do to it has one unknown, the slider's
displacement η across the force,

    δw = e (e·δp - δr) + t η,        η' = -(λ/r) (η - t·δp) - ψ' (e·δp - δr),

in which no derivative of a change occurs; it fades as long as the slider moves. Both are collocated
at the nodes of Radau's right-hand rule, the rule of the integrals, too: it damps what is stiff,
where the disc is small, and the end of a step is a node (Hairer & Wanner, Solving Ordinary
Differential Equations II, IV.5). r = 0 at the beginning is allowed: a touch-down.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre

from vanelock.common.arrays import Complex, Floats, Integers
from vanelock.nonlinear.contact.disc_slider import FREE, HELD, SLIPPING
from vanelock.nonlinear.fourier import TURN, add_integrals, basis_at, gram, kernel

STAGES = 5
SMALLEST = 1e-16
"""Radius over what it and its centre move in a radian, below which a disc is taken as a point."""
# Columns of the motion at a node: p, p', r, r'.
PX, PY, DX, DY, R, DR = 0, 1, 2, 3, 4, 5
# Columns of the slip at a node: e, λ, ψ', and z of its step.
EX, EY, RATE, _TURNING, Z = 0, 1, 2, 3, 4


def _radau(stages: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Nodes c in (0, 1], integrals A from 0 to c_i of the j-th cardinal polynomial.

    And of the polynomial through 0 and all nodes its slope at 1, and its part of the highest
    degree as the largest value of such a Chebyshev polynomial on (0, 1).
    """
    ends = np.zeros(stages + 1)
    ends[-2:] = -1.0, 1.0  # P_s - P_(s-1) vanishes at the nodes
    c = np.sort(0.5 * (1.0 + Legendre(ends).roots().real))
    c[-1] = 1.0
    powers = np.arange(stages)
    at_nodes = c[:, None] ** powers
    A = np.linalg.solve(at_nodes.T, (c[:, None] ** (powers + 1) / (powers + 1)).T).T
    more = np.concatenate([[0.0], c])[:, None] ** np.arange(stages + 1)
    slope = np.linalg.solve(more.T, np.arange(stages + 1.0))
    highest = np.linalg.inv(more)[-1] / 2 ** (2 * stages - 1)
    return c, np.ascontiguousarray(A), slope, np.ascontiguousarray(highest)


NODES, INTEGRALS, SLOPE, HIGHEST = _radau(STAGES)
WEIGHTS = INTEGRALS[-1].copy()


@kernel
def _solve_in_place(matrix: Floats, right: Floats) -> None:
    """Gauss elimination with row exchanges, of `right` (n, k); both are overwritten."""
    n, columns = right.shape
    for i in range(n):
        pivot = i
        for j in range(i + 1, n):
            if abs(matrix[j, i]) > abs(matrix[pivot, i]):
                pivot = j
        if pivot != i:
            for k in range(i, n):
                matrix[i, k], matrix[pivot, k] = matrix[pivot, k], matrix[i, k]
            for k in range(columns):
                right[i, k], right[pivot, k] = right[pivot, k], right[i, k]
        inverse = 1.0 / matrix[i, i]
        for j in range(i + 1, n):
            factor = matrix[j, i] * inverse
            if factor == 0.0:
                continue
            for k in range(i + 1, n):
                matrix[j, k] -= factor * matrix[i, k]
            for k in range(columns):
                right[j, k] -= factor * right[i, k]
    for i in range(n - 1, -1, -1):
        for k in range(columns):
            total = right[i, k]
            for j in range(i + 1, n):
                total -= matrix[i, j] * right[j, k]
            right[i, k] = total / matrix[i, i]


@kernel
def motion_at(angle: float, u: Floats, alpha: float, phi: Floats, motion: Floats) -> None:
    """φ(θ), and p, p', r, r' of the displacements (3, m) of (v, u1, u2)."""
    basis_at(angle, phi)
    v, dv = u[0, 0], 0.0
    x, dx, y, dy = u[1, 0], 0.0, u[2, 0], 0.0
    for h in range(1, (phi.size + 1) // 2):
        i, j = 2 * h - 1, 2 * h
        c, s = phi[i], phi[j]
        hc, hs = h * c, h * s
        v += c * u[0, i] + s * u[0, j]
        x += c * u[1, i] + s * u[1, j]
        y += c * u[2, i] + s * u[2, j]
        dv += hs * u[0, i] - hc * u[0, j]
        dx += hs * u[1, i] - hc * u[1, j]
        dy += hs * u[2, i] - hc * u[2, j]
    motion[PX], motion[PY], motion[DX], motion[DY] = x, y, dx, dy
    motion[R], motion[DR] = alpha * v, alpha * dv


# Rows of the moments: of e_x, e_y, e_x², e_x e_y and 1 over slip, of 1 over what is free.
_FORCE_X, _FORCE_Y, _FORCE_XX, _FORCE_XY, _SLIPS, _IS_FREE = 0, 1, 2, 3, 4, 5
# Columns of a piece of the path: HELD, SLIPPING or FREE and its angles; the place of what is held,
# e at the beginning of a step of slip, and the step's z at the nodes.
KIND, BEGIN, END, X, Y, STEP = 0, 1, 2, 3, 4, 5
WIDTH = STEP + STAGES


class Path(NamedTuple):
    """What a lap works on and adds to.

    `slider`, `change` (2,), (2, n): the slider and its changes: with the coefficients of (v, u1,
    u2) in the first 3 m columns, unless n < 3 m, and with what else is given at the beginning; at
    the end, those there; `force` (2,), `across` (n,): e and η of a slip; `phi`, `motion` (m,),
    (6,): at one angle; `phis`, `motions`, `slip`, `eta` (s, m), (s, 6), (s, 5), (s, n): at the
    nodes of a step; `moments` (6, 2m - 1): ∫ (e_x, e_y, e_x², e_x e_y) e^{ikθ} of slip, ∫ e^{ikθ}
    of slip and of what is free; `w`, `jacobian` (2, m), (2, m, n): ∫ w φ_j of what is held, and
    ∫ φ_j dw but for what the moments hold; `pieces`, `filled` (p, WIDTH), (1,): the path piece by
    piece where there is room, and how many there are.
    """

    slider: Floats
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
def slip_over(begin: float, length: float, u: Floats, alpha: float, path: Path) -> None:
    """Collocate one step of slip from the force e on: φ, motion and slip (s, .) at the nodes."""
    phi, motion, slip = path.phis, path.motions, path.slip
    ex, ey = path.force[0], path.force[1]
    s = STAGES
    z, a, b, half = np.zeros(s), np.empty(s), np.empty(s), np.empty(s)
    for i in range(s):
        motion_at(begin + length * NODES[i], u, alpha, phi[i], motion[i])
        a[i] = motion[i, DX] * ex + motion[i, DY] * ey
        b[i] = motion[i, DY] * ex - motion[i, DX] * ey
        speed = abs(a[i]) + abs(b[i]) + abs(motion[i, DR])
        motion[i, R] = max(motion[i, R], SMALLEST * speed, 1e-300)  # where it opens
        half[i] = 0.5 * length / motion[i, R]
    matrix, step = np.empty((s, s)), np.empty((s, 1))
    for _ in range(30):
        for i in range(s):
            step[i, 0] = -z[i]
            for j in range(s):
                f = half[j] * (b[j] * (1.0 - z[j] * z[j]) - 2.0 * a[j] * z[j])
                step[i, 0] += INTEGRALS[i, j] * f
                matrix[i, j] = INTEGRALS[i, j] * 2.0 * half[j] * (b[j] * z[j] + a[j])
            matrix[i, i] += 1.0
        _solve_in_place(matrix, step)
        size = 0.0
        for i in range(s):
            z[i] += step[i, 0]
            size = max(size, abs(step[i, 0]))
        if size <= 1e-8:  # the next one would be its square
            break
    for i in range(s):
        over = 1.0 / (1.0 + z[i] * z[i])
        cosine, sine = (1.0 - z[i] * z[i]) * over, 2.0 * z[i] * over
        x, y = cosine * ex - sine * ey, cosine * ey + sine * ex
        slip[i, EX], slip[i, EY], slip[i, Z] = x, y, z[i]
        slip[i, RATE] = motion[i, DX] * x + motion[i, DY] * y - motion[i, DR]
        across = motion[i, DY] * x - motion[i, DX] * y
        slip[i, _TURNING] = across / motion[i, R]


@kernel
def changes_over(length: float, alpha: float, path: Path) -> None:
    """Collocate η (s, n) of a step for changes of all coefficients, 3 m, and of earlier ones."""
    phi, motion, slip, start, eta = path.phis, path.motions, path.slip, path.across, path.eta
    s, (_, m) = STAGES, phi.shape
    matrix, answer = np.empty((s, s)), np.empty((s, s + 1))
    for i in range(s):
        answer[i, s] = 1.0
        for j in range(s):
            answer[i, j] = length * INTEGRALS[i, j]
            fading = slip[j, RATE] / motion[j, R]
            matrix[i, j] = answer[i, j] * fading
        matrix[i, i] += 1.0
    _solve_in_place(matrix, answer)
    for i in range(s):
        for k in range(start.size):
            eta[i, k] = answer[i, s] * start[k]
    if start.size < 3 * m:
        return
    for j in range(s):
        ex, ey, turning = slip[j, EX], slip[j, EY], slip[j, _TURNING]
        fading = slip[j, RATE] / motion[j, R]
        to_v = alpha * turning
        to_x, to_y = -fading * ey - turning * ex, fading * ex - turning * ey
        for i in range(s):
            share = answer[i, j]
            on_v, on_x, on_y = share * to_v, share * to_x, share * to_y
            for k in range(m):
                eta[i, k] += on_v * phi[j, k]
                eta[i, m + k] += on_x * phi[j, k]
                eta[i, 2 * m + k] += on_y * phi[j, k]


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
    add_integrals(begin, end, path.moments[_IS_FREE])
    _write(FREE, begin, end, 0.0, 0.0, path)


@kernel
def add_held(begin: float, end: float, path: Path) -> None:
    """Add the integrals of a held slider and of its changes."""
    _write(HELD, begin, end, path.slider[0], path.slider[1], path)
    m = path.w.shape[1]
    held = np.zeros((m + 1) // 2, np.complex128)
    add_integrals(begin, end, held)
    for j in range(m):
        h = (j + 1) // 2
        integral = -held[h].imag if j > 0 and j % 2 == 0 else held[h].real
        for i in range(2):
            path.w[i, j] += path.slider[i] * integral
            for k in range(path.change.shape[1]):
                path.jacobian[i, j, k] += path.change[i, k] * integral


@kernel
def add_slip(begin: float, length: float, path: Path) -> float:
    """Add the integrals of a step of slip, e that at its beginning; returns ∫ r λ."""
    _write(SLIPPING, begin, begin + length, path.force[0], path.force[1], path)
    work, slip, phis, moments = 0.0, path.slip, path.phis, path.moments
    m, columns = phis.shape[1], path.eta.shape[1]
    add_integrals(begin, begin + length, moments[_SLIPS])
    for n in range(STAGES):
        share = length * WEIGHTS[n]
        ex, ey = slip[n, EX], slip[n, EY]
        work += share * path.motions[n, R] * max(slip[n, RATE], 0.0)
        turn, power = complex(phis[n, 1], -phis[n, 2]), complex(share, 0.0)
        for k in range(moments.shape[1]):
            moments[_FORCE_X, k] += ex * power
            moments[_FORCE_Y, k] += ey * power
            moments[_FORCE_XX, k] += ex * ex * power
            moments[_FORCE_XY, k] += ex * ey * power
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
    ex, ey, xx, xy = grams[_FORCE_X], grams[_FORCE_Y], grams[_FORCE_XX], grams[_FORCE_XY]
    slips, free = grams[_SLIPS], grams[_IS_FREE]
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
