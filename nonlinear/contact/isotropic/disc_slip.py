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

import numpy as np
from numpy.polynomial import Legendre

from vanelock.common.arrays import Floats
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import basis_at

STAGES = 5
SMALLEST = 1e-16
"""Radius over what it and its centre move in a radian, below which a disc is taken as a point."""
# Columns of the motion at a node: p, p', r, r'.
PX, PY, DX, DY, R, DR = 0, 1, 2, 3, 4, 5
# Columns of the slip at a node: e, λ, ψ', and z of its step.
EX, EY, RATE, TURNING, Z = 0, 1, 2, 3, 4


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
def solve_in_place(matrix: Floats, right: Floats) -> None:
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


@kernel
def slip_over(
    begin: float,
    length: float,
    ex: float,
    ey: float,
    u: Floats,
    alpha: float,
    phi: Floats,
    motion: Floats,
    slip: Floats,
) -> None:
    """Collocate one step of slip from the force e on: φ, motion and slip (s, .) at the nodes."""
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
        solve_in_place(matrix, step)
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
        slip[i, TURNING] = across / motion[i, R]


@kernel
def changes_over(
    length: float,
    alpha: float,
    phi: Floats,
    motion: Floats,
    slip: Floats,
    start: Floats,
    eta: Floats,
) -> None:
    """Collocate η (s, n) of a step for changes of all coefficients, 3 m, and of earlier ones."""
    s, (_, m) = STAGES, phi.shape
    matrix, answer = np.empty((s, s)), np.empty((s, s + 1))
    for i in range(s):
        answer[i, s] = 1.0
        for j in range(s):
            answer[i, j] = length * INTEGRALS[i, j]
            fading = slip[j, RATE] / motion[j, R]
            matrix[i, j] = answer[i, j] * fading
        matrix[i, i] += 1.0
    solve_in_place(matrix, answer)
    for i in range(s):
        for k in range(start.size):
            eta[i, k] = answer[i, s] * start[k]
    if start.size < 3 * m:
        return
    for j in range(s):
        ex, ey, turning = slip[j, EX], slip[j, EY], slip[j, TURNING]
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
