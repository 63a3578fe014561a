"""The contact law with isotropic friction linearised about a periodic motion.

As in `law_transfer`, δu = Re[e^{λt} Σ_k u_k e^{ikθ}] and w_j = Σ_k Γ_jk(s) u_k, but the two
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
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.contact.isotropic.disc_slider import FREE, HELD, SLIPPING
from vanelock.nonlinear.contact.isotropic.disc_slip import NODES, WEIGHTS
from vanelock.nonlinear.floquet.law_transfer import Transferred, law_transfer
from vanelock.nonlinear.floquet.slider_steps import SliderSteps, passing, slider_steps
from vanelock.nonlinear.fourier.trigonometric import TURN, Floats, grid

Complex = NDArray[np.complex128]
Rows = NDArray[np.int64]

ALONG, ACROSS, BESIDE = 0, 1, 2
"""Rows of the partners: a component itself, v, and the other tangential component."""


@dataclass(frozen=True)
class PlaneTransfer:
    """Γ(s) of the components of w that a perturbation changes, 2P + 1 = M harmonics.

    Attributes
    ----------
    components : (o,) int
        Which, counted through (c, 3).
    partners : (3, o) int
        The component itself, v of its contact, and the other tangential component.
    still : (3, o, M, M) complex
        From each of them what does not depend on s.
    paths : tuple of (int, float, SliderSteps)
        Place among the components, α and path of each contact that slips.
    kept : (q,) float
        κ of those that never open.
    harmonics : int
        P.
    """

    components: Rows
    partners: Rows
    still: Complex
    paths: tuple[tuple[int, float, SliderSteps], ...]
    kept: Floats
    harmonics: int

    @property
    def remembering(self) -> Rows:
        """(q,) places among `components` of the first of the two that z belongs to."""
        return np.array([place for place, _, path in self.paths if path.remembers], np.int64)

    def at(self, s: complex) -> Transferred:
        """Γ, Y and C at one s."""
        parts, M = self.still.copy(), 2 * self.harmonics + 1
        shown, read = [], []
        for place, alpha, path in self.paths:
            eta, held, across = passing(path, alpha, self.harmonics, s)
            w = _harmonics(path, self.harmonics, s, eta, held)
            of_v, of_1, of_2 = (w[..., b * M : (b + 1) * M] for b in range(3))
            parts[ACROSS, place : place + 2] += of_v
            parts[ALONG, place : place + 2] += np.stack([of_1[0], of_2[1]])
            parts[BESIDE, place : place + 2] += np.stack([of_2[0], of_1[1]])
            if path.remembers:
                shown.append(w[..., -1])
                read.append(across[:-1].reshape(3, M)[[1, 0, 2]])
        q = len(shown)
        return Transferred(
            tuple(parts),
            np.array(shown, complex).reshape(q, 2, M),
            np.array(read, complex).reshape(q, 3, M),
        )

    def onto_open(self, opened: Rows) -> "PlaneTransfer":
        """The law of w - u instead of w in the (m,) components of contacts open in the modes."""
        components = np.union1d(self.components, opened)
        own = np.searchsorted(components, self.components)
        still = np.zeros((3, len(components), *self.still.shape[2:]), complex)
        still[:, own] = self.still
        still[ALONG, np.searchsorted(components, opened)] -= np.eye(2 * self.harmonics + 1)
        paths = tuple((int(own[place]), alpha, path) for place, alpha, path in self.paths)
        return replace(
            self, components=components, partners=_partners(components), still=still, paths=paths
        )


def _harmonics(
    path: SliderSteps, harmonics: int, s: complex, eta: Complex, held: Complex
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
    found: Complex = on_slip + on_held
    return found


def _nodes(path: SliderSteps) -> tuple[Floats, Floats]:
    """Angles and weights of all nodes of slip, (5 steps,) each."""
    kind, begin, end = path.pieces.T
    slips = kind == SLIPPING
    length = (end - begin)[slips, None]
    return (begin[slips, None] + length * NODES).ravel(), (length * WEIGHTS).ravel()


def _still(path: SliderSteps, alpha: float, harmonics: int) -> Complex:
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
        moments[ALONG] += np.where(lags == 0, last - first, waves)
    lag = np.subtract.outer(lags, lags).T
    each = moments[..., np.abs(lag)] / TURN
    found: Complex = np.where(lag < 0, each.conj(), each)
    return found


def _partners(components: Rows) -> Rows:
    """(3, o) the component itself, v of its contact, and the other tangential component."""
    contact, row = components // 3 * 3, components % 3
    return np.array([components, contact, contact + np.where(row > 0, 3 - row, 0)])


def plane_transfer(u: Floats, alpha: Floats, harmonics: int) -> PlaneTransfer:
    """Γ about a periodic motion."""
    u, M = np.ascontiguousarray(u), 2 * harmonics + 1
    normal = law_transfer(u, alpha, harmonics)
    opens = normal.components % 3 == 0
    table = grid(max(harmonics, u.shape[2] // 2))[:, : u.shape[2]]
    table = np.ascontiguousarray(table)
    found = [slider_steps(u[c], float(alpha[c, 0]), table) for c in range(len(u))]
    moved = [c for c, path in enumerate(found) if path is not None]
    planes = np.array([3 * c + i for c in moved for i in (1, 2)], np.int64)
    components = np.union1d(normal.components[opens], planes)
    still, paths, kept = np.zeros((3, len(components), M, M), complex), [], []
    still[ALONG, np.searchsorted(components, normal.components[opens])] = normal.along[opens]
    for c in moved:
        place, path, own = int(np.searchsorted(components, 3 * c + 1)), found[c], float(alpha[c, 0])
        assert path is not None
        still[:, place : place + 2] = _still(path, own, harmonics)
        if np.any(path.pieces[:, 0] != FREE):
            paths.append((place, own, path))
        if path.remembers:
            kept.append(passing(path, own, 0, 0j)[2][-1].real)
    return PlaneTransfer(
        components, _partners(components), still, tuple(paths), np.array(kept), harmonics
    )
