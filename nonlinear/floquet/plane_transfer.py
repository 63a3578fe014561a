"""The contact law with isotropic friction linearised about a periodic motion.

As in `perturbation`, δu = Re[e^{λt} Σ_k u_k e^{ikθ}] and w_j = Σ_k Γ_jk(s) u_k, but the two
tangential directions answer together. With p = (u1, u2), r = α v and the force along e, t across
it, pieces of the located path (`disc_path`) have

    dw = dp                                             open,
    dw = e (e·dp - dr) + t η                            slipping,
    dw = e^{-s(θ-σ)} dw(σ)                              held since σ, in the frame of e^{sθ},

    η' = -(s + λ/r) η + (λ/r) t·dp - ψ' (e·dp - dr),

η the slider's displacement across the force (`disc_slip`). Where slip begins η = t·dw: of dw along
e nothing is left, since what is slower there merely begins to slip later. Where it ends λ = 0 and
dw is continuous. At touch-down dw = dp - (p'/v') dv, the instant moving with v; across p' it is dp.

A contact that never opens remembers η from one period to the next. Γ would have poles there, at
κ e^{-2πs} = 1. So what it remembers at the beginning of a slip is an unknown z of its own.

The slider is linearised step by step along its periodic path. Slip is collocated on the path's own
steps (`disc_slip`), y = e^{sθ} η being the unknown, so that the matrices do not depend on s.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vanelock.common.arrays import Complex, Floats, Integers
from vanelock.nonlinear.contact.disc_slider import FREE, HELD, SLIPPING
from vanelock.nonlinear.contact.disc_slip import (
    BEGIN,
    DR,
    DX,
    DY,
    END,
    INTEGRALS,
    KIND,
    NODES,
    SMALLEST,
    STAGES,
    STEP,
    WEIGHTS,
    R,
    X,
    Y,
    motion_at,
)
from vanelock.nonlinear.contact.isotropic_law import slider_pieces
from vanelock.nonlinear.floquet.perturbation import Transfer, Transferred, law_transfer
from vanelock.nonlinear.fourier import TURN, grid, kernel


class _SliderSteps(NamedTuple):
    """One contact's path, piece by piece, the first a step of slip where it never opens."""

    pieces: Floats  # (p, 3), HELD, SLIPPING or FREE, from and to, rad
    e: Floats  # (p, 2, 2), the force's direction at the beginning and the end of slip
    touching: Floats  # (p, 2), c of dw = dp + c dv, where what is held has touched down
    forcing: Floats  # (p, STAGES, 3), what dv and dp add to η' at the nodes of slip
    answer: Floats  # (p, STAGES, STAGES + 1)
    nodes: Floats  # (p, STAGES, 2), e at the nodes
    remembers: bool


@kernel
def _steps(rows: Floats, u: Floats, alpha: float, path: _SliderSteps) -> None:
    """Fill the arrays of `_SliderSteps` from the pieces of a path."""
    _, e, touching, forcing, answer, nodes, _ = path
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
    path: _SliderSteps, alpha: float, harmonics: int, s: complex
) -> tuple[Complex, Complex, Complex]:
    """Once round with unit perturbations: η (p, STAGES, n), dw (p, 2, n), and η (n,) in the end.

    The columns are the harmonics -P ... P of v, of u1 and of u2, and the remembered value.
    """
    pieces, e, touching, forcing, answer, _, remembers = path
    M, p = 2 * harmonics + 1, len(pieces)
    eta = np.zeros((p, STAGES, 3 * M + 1), np.complex128)
    held = np.zeros((p, 2, 3 * M + 1), np.complex128)
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
    return eta, held, across


def _slider_steps(u: Floats, alpha: float, table: Floats) -> _SliderSteps | None:
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
    path = _SliderSteps(
        pieces=np.ascontiguousarray(rows[:, [KIND, BEGIN, END]]),
        e=np.zeros((p, 2, 2)),
        touching=np.zeros((p, 2)),
        forcing=np.zeros((p, STAGES, 3)),
        answer=np.zeros((p, STAGES, STAGES + 1)),
        nodes=np.zeros((p, STAGES, 2)),
        remembers=remembers,
    )
    _steps(rows, u, alpha, path)
    return path


_ALONG, _ACROSS, _BESIDE = 0, 1, 2
"""Rows of the partners: a component itself, v, and the other tangential component."""


@dataclass(frozen=True)
class _PlaneTransfer(Transfer):
    """That of isotropic friction, the other tangential component the third partner.

    `paths` tuple of (int, float, SliderSteps): place among the components, α and path of each
    contact that slips.
    """

    paths: tuple[tuple[int, float, _SliderSteps], ...]

    @property
    def partners(self) -> Integers:
        """(3, o)."""
        row = self.components % 3
        beside = np.where(row > 0, 3 - row, 0)
        return np.array([*super().partners, self.components // 3 * 3 + beside])

    @property
    def remembering(self) -> Integers:
        """(q,)."""
        return np.array([place for place, _, path in self.paths if path.remembers], np.int64)

    @cached_property
    def memory(self) -> Floats:
        """(q,)."""
        remember = [(path, alpha) for _, alpha, path in self.paths if path.remembers]
        return np.array([_passed(*each, 0, 0j)[2][-1].real for each in remember])

    def at(self, s: complex) -> Transferred:
        """Γ, Y and C at one s."""
        parts, M = self.static.copy(), 2 * self.harmonics + 1
        shown, read = [], []
        for place, alpha, path in self.paths:
            eta, held, across = _passed(path, alpha, self.harmonics, complex(s))
            w = _harmonics(path, self.harmonics, s, eta, held)
            of_v, of_1, of_2 = (w[..., b * M : (b + 1) * M] for b in range(3))
            parts[_ACROSS, place : place + 2] += of_v
            parts[_ALONG, place : place + 2] += np.stack([of_1[0], of_2[1]])
            parts[_BESIDE, place : place + 2] += np.stack([of_2[0], of_1[1]])
            if path.remembers:
                shown.append(w[..., -1])
                read.append(across[:-1].reshape(3, M)[[1, 0, 2]])
        q = len(shown)
        return Transferred(
            tuple(parts),
            np.array(shown, complex).reshape(q, 2, M),
            np.array(read, complex).reshape(q, 3, M),
        )

    def _among(self, components: Integers, static: Complex, places: Integers) -> "_PlaneTransfer":
        paths = tuple((int(places[own]), alpha, path) for own, alpha, path in self.paths)
        return _PlaneTransfer(components, static, paths)


def _harmonics(
    path: _SliderSteps, harmonics: int, s: complex, eta: Complex, held: Complex
) -> Complex:
    """(2, M, n) harmonics of t η while slipping and of what is held."""
    orders = np.arange(-harmonics, harmonics + 1)
    kind, begin, end = path.pieces.T
    slips, holds = kind == SLIPPING, kind == HELD
    angle, weight = _nodes(path)
    turned = weight.ravel() * np.exp(-1j * np.outer(orders, angle)) / TURN
    e = path.nodes[slips].reshape(-1, 2)
    t = np.stack([-e[:, 1], e[:, 0]])
    on_slip = (t[:, None] * turned) @ eta[slips].reshape(-1, eta.shape[2])
    rate = s + 1j * orders[:, None]
    small = np.abs(rate) < 1e-12
    length = end[holds] - begin[holds]
    passed = np.where(small, length, -np.expm1(-rate * length) / np.where(small, 1.0, rate))
    shown = np.exp(-1j * np.outer(orders, begin[holds])) * passed / TURN
    on_held = np.einsum("jp,pin->ijn", shown, held[holds])
    return np.asarray(on_slip + on_held)


def _nodes(path: _SliderSteps) -> tuple[Floats, Floats]:
    """Angles and weights of all nodes of slip, (5 steps,) each."""
    kind, begin, end = path.pieces.T
    slips = kind == SLIPPING
    length = (end - begin)[slips, None]
    return (begin[slips, None] + length * NODES).ravel(), (length * WEIGHTS).ravel()


def _still(path: _SliderSteps, alpha: float, harmonics: int) -> Complex:
    """(3, 2, M, M) of both tangential components: e (e·dp - dr) of slip, and dp where open."""
    lags = np.arange(2 * harmonics + 1)
    kind, begin, end = path.pieces.T
    angle, weight = _nodes(path)
    x, y = path.nodes[kind == SLIPPING].reshape(-1, 2).T
    # From the component itself, from v, and from the other one.
    factors = np.array([[x * x, y * y], [-alpha * x, -alpha * y], [x * y, x * y]]) * weight
    moments = factors @ np.exp(1j * np.outer(angle, lags))
    for first, last in zip(begin[kind == FREE], end[kind == FREE], strict=True):
        over = np.where(lags == 0, 1, lags)
        waves = (np.exp(1j * lags * last) - np.exp(1j * lags * first)) / (1j * over)
        moments[_ALONG] += np.where(lags == 0, last - first, waves)
    lag = np.subtract.outer(lags, lags).T
    each = moments[..., np.abs(lag)] / TURN
    return np.asarray(np.where(lag < 0, each.conj(), each))


def plane_transfer(u: Floats, alpha: Floats, harmonics: int) -> _PlaneTransfer:
    """Γ about a periodic motion."""
    u, M = np.ascontiguousarray(u), 2 * harmonics + 1
    normal = law_transfer(u, alpha, harmonics)
    opens = normal.components % 3 == 0
    table = grid(max(harmonics, u.shape[2] // 2))[:, : u.shape[2]]
    table = np.ascontiguousarray(table)
    found = [_slider_steps(u[c], float(alpha[c, 0]), table) for c in range(len(u))]
    moved = [c for c, path in enumerate(found) if path is not None]
    planes = np.array([3 * c + i for c in moved for i in (1, 2)], np.int64)
    components = np.union1d(normal.components[opens], planes)
    still, paths = np.zeros((3, len(components), M, M), complex), []
    still[_ALONG, np.searchsorted(components, normal.components[opens])] = normal.static[0][opens]
    for c in moved:
        place, path, own = int(np.searchsorted(components, 3 * c + 1)), found[c], float(alpha[c, 0])
        assert path is not None
        still[:, place : place + 2] = _still(path, own, harmonics)
        if np.any(path.pieces[:, 0] != FREE):
            paths.append((place, own, path))
    return _PlaneTransfer(components, still, tuple(paths))
