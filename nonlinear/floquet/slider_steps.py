"""A friction slider that follows a disc, linearised step by step along its periodic path.

Notation as in `plane_transfer`. Slip is collocated on the path's own steps (`disc_slip`),
y = e^{sθ} η being the unknown, so that the matrices do not depend on s.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.contact.isotropic.disc_integrals import BEGIN, END, KIND, STEP, X, Y
from vanelock.nonlinear.contact.isotropic.disc_slider import FREE, HELD, SLIPPING
from vanelock.nonlinear.contact.isotropic.disc_slip import (
    DR,
    DX,
    DY,
    INTEGRALS,
    NODES,
    SMALLEST,
    STAGES,
    R,
    motion_at,
)
from vanelock.nonlinear.contact.isotropic.located_law import slider_pieces
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import TURN, Floats

Complex = NDArray[np.complex128]


class SliderSteps(NamedTuple):
    """One contact's path, piece by piece, the first a step of slip where it never opens.

    Attributes
    ----------
    pieces : (p, 3) float
        HELD, SLIPPING or FREE, from and to, rad.
    e : (p, 2, 2) float
        The force's direction at the beginning and the end of slip.
    touching : (p, 2) float
        c of dw = dp + c dv, where what is held has touched down.
    forcing : (p, STAGES, 3) float
        What dv and dp add to η' at the nodes of slip.
    answer : (p, STAGES, STAGES + 1) float
        y at the nodes from what is added there and from y at the beginning.
    nodes : (p, STAGES, 2) float
        e at the nodes.
    remembers : bool
    """

    pieces: Floats
    e: Floats
    touching: Floats
    forcing: Floats
    answer: Floats
    nodes: Floats
    remembers: bool


@kernel
def _steps(
    rows: Floats,
    u: Floats,
    alpha: float,
    e: Floats,
    touching: Floats,
    forcing: Floats,
    answer: Floats,
    nodes: Floats,
) -> None:
    """Fill the arrays of `SliderSteps` from the pieces of a path."""
    phi, at = np.empty(u.shape[1]), np.empty(6)
    matrix, right = np.empty((STAGES, STAGES)), np.empty((STAGES, STAGES + 1))
    for i in range(rows.shape[0]):
        row = rows[i]
        length = row[END] - row[BEGIN]
        motion_at(row[BEGIN], u, alpha, phi, at)
        if row[KIND] == HELD and at[DR] > 0.0:
            touching[i, 0], touching[i, 1] = -alpha * at[DX] / at[DR], -alpha * at[DY] / at[DR]
        if row[KIND] != SLIPPING:
            continue
        e[i, 0, 0], e[i, 0, 1] = row[X], row[Y]
        for n in range(STAGES):
            z = row[STEP + n]
            over = 1.0 / (1.0 + z * z)
            cosine, sine = (1.0 - z * z) * over, 2.0 * z * over
            x, y = cosine * row[X] - sine * row[Y], cosine * row[Y] + sine * row[X]
            motion_at(row[BEGIN] + length * NODES[n], u, alpha, phi, at)
            speed = abs(at[DX]) + abs(at[DY]) + abs(at[DR])
            r = max(at[R], SMALLEST * speed, 1e-300)
            fading = (at[DX] * x + at[DY] * y - at[DR]) / r
            turning = (at[DY] * x - at[DX] * y) / r
            nodes[i, n, 0], nodes[i, n, 1] = x, y
            forcing[i, n, 0] = alpha * turning
            forcing[i, n, 1] = -fading * y - turning * x
            forcing[i, n, 2] = fading * x - turning * y
            for k in range(STAGES):
                right[k, n] = length * INTEGRALS[k, n]
                matrix[k, n] = right[k, n] * fading
            matrix[n, n] += 1.0
            right[n, STAGES] = 1.0
        e[i, 1] = nodes[i, STAGES - 1]
        answer[i] = np.linalg.solve(matrix, right)


@kernel
def _passed(
    pieces: Floats,
    e: Floats,
    touching: Floats,
    forcing: Floats,
    answer: Floats,
    remembers: bool,
    alpha: float,
    harmonics: int,
    s: complex,
    eta: Complex,
    held: Complex,
) -> Complex:
    """Once round with unit perturbations: (n,) η where it began, after the period.

    The columns are the harmonics -P ... P of v, of u1 and of u2, and the remembered value.
    """
    M = 2 * harmonics + 1
    across, w = np.zeros(3 * M + 1, np.complex128), np.zeros((2, 3 * M + 1), np.complex128)
    orders = np.arange(-harmonics, harmonics + 1)
    added, before = np.empty((STAGES, 3 * M), np.complex128), FREE
    if remembers:
        across[3 * M], before = 1.0, SLIPPING
    for i in range(pieces.shape[0]):
        kind, begin, length = pieces[i, 0], pieces[i, 1], pieces[i, 2] - pieces[i, 1]
        wave = np.exp(1j * begin * orders)
        if kind == HELD:
            if before != HELD:
                w[:] = 0.0
            if before == FREE:
                for j in range(2):
                    w[j, :M] = touching[i, j] * wave
                    w[j, M * (j + 1) : M * (j + 2)] = wave
            elif before == SLIPPING:
                x, y = e[i - 1, 1, 0], e[i - 1, 1, 1]
                w[0], w[1] = -y * across, x * across
                for j in range(2):
                    along = x if j == 0 else y
                    w[j, :M] -= along * alpha * wave
                    w[j, M : 2 * M] += along * x * wave
                    w[j, 2 * M : 3 * M] += along * y * wave
            held[i] = w
            w *= np.exp(-s * length)
        elif kind == SLIPPING:
            x, y = e[i, 0, 0], e[i, 0, 1]
            if before == HELD:
                across[:] = x * w[1] - y * w[0]
            elif before == FREE:
                across[:] = 0.0
                across[M : 2 * M], across[2 * M : 3 * M] = -y * wave, x * wave
            for n in range(STAGES):
                angle = begin + length * NODES[n]
                there = np.exp(1j * angle * orders + s * length * NODES[n])
                for b in range(3):
                    added[n, b * M : (b + 1) * M] = forcing[i, n, b] * there
            for n in range(STAGES):
                node = eta[i, n]
                node[:] = answer[i, n, STAGES] * across
                for k in range(STAGES):
                    node[: 3 * M] += answer[i, n, k] * added[k]
                node *= np.exp(-s * length * NODES[n])
            across[:] = eta[i, STAGES - 1]
        before = int(kind)
    if before == HELD:
        across[:] = e[0, 0, 0] * w[1] - e[0, 0, 1] * w[0]
    return across


def slider_steps(u: Floats, alpha: float, table: Floats) -> SliderSteps | None:
    """The path of one contact's slider; None where it sticks for good."""
    rows = slider_pieces(u, alpha, table)
    kinds = rows[:, KIND]
    if len(rows) == 1 and kinds[0] == HELD:
        return None
    remembers = not np.any(kinds == FREE)
    if remembers:  # begins where slip does, or in the midst of it
        begins = np.flatnonzero((kinds == SLIPPING) & (np.roll(kinds, 1) != SLIPPING))
        first = int(begins[0]) if len(begins) else 0
        rows = np.roll(rows, -first, axis=0)
        rows[len(rows) - first :, [BEGIN, END]] += TURN
    p = len(rows)
    arrays = (
        np.zeros((p, 2, 2)),
        np.zeros((p, 2)),
        np.zeros((p, STAGES, 3)),
        np.zeros((p, STAGES, STAGES + 1)),
        np.zeros((p, STAGES, 2)),
    )
    _steps(rows, u, alpha, *arrays)
    pieces = np.ascontiguousarray(rows[:, [KIND, BEGIN, END]])
    return SliderSteps(pieces, *arrays, remembers)


def passing(
    path: SliderSteps, alpha: float, harmonics: int, s: complex
) -> tuple[Complex, Complex, Complex]:
    """η (p, STAGES, n), dw (p, 2, n) and η in the end (n,) of `_passed`."""
    n, p = 3 * (2 * harmonics + 1) + 1, len(path.pieces)
    eta, held = np.zeros((p, STAGES, n), complex), np.zeros((p, 2, n), complex)
    given = path.pieces, path.e, path.touching, path.forcing, path.answer, path.remembers
    across: Complex = _passed(*given, alpha, harmonics, complex(s), eta, held)
    return eta, held, across
