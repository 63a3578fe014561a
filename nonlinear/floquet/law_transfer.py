"""The contact law linearised about a periodic motion, sliders' memory included.

To perturbed displacements Re[e^{λt} Σ_k u_k e^{ikθ}], s = λ/ω, θ = ωt, the deviation w answers with
harmonics w_j = Σ_k Γ_jk(s) u_k. Between two events of the motion

    dw_n = dv                                 open,
    dw_t = du -/+ α dv                        slipping on the lower, upper bound,
    dw_t = du                                 open,
    dw_t = e^{-s(θ-σ)} [du(σ) + c dv(σ)]      held since σ, in the frame that turns with e^{sθ},

c the factor of the event that set the slider (`slider_path`): -α or α where slipping ended, -u'/v'
where it touched down. Instants of events move, too, but w has no jumps there, so that to first
order only those that set a slider count. Integrals over the pieces are closed:

    Γ_jk = 1/2π ∫ e^{i(k-j)θ} dθ,     held: 1/2π e^{(s+ik)σ} ∫ e^{-(s+ij)θ} dθ (1 for u, c for v).

A slider that rests where it once came to, all round the period, is put back by nothing and moved by
nothing: it is left out, and with it the exponents 0 of its places.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from vanelock.common.arrays import Booleans, Complex, Floats, Integers
from vanelock.nonlinear.contact.orthogonal_law import (
    BEGIN,
    END,
    FACTOR,
    FREE,
    HELD,
    HIGH,
    KIND,
    SOURCE,
    WIDTH,
    slider_path,
)
from vanelock.nonlinear.fourier.kernels import kernel
from vanelock.nonlinear.fourier.trigonometric import TURN, add_integrals, grid, roots, value


class Transferred(NamedTuple):
    """The linearised law at one s.

    `parts` tuple of (o, M, M) complex: Γ from each of the rows of `partners`; `shown` (q, 2, M):
    harmonics of w that a unit of each remembered value z adds to w of its plane; `read` (q, 3, M):
    what perturbations of its partners add to z in a period.
    """

    parts: tuple[Complex, ...]
    shown: Complex
    read: Complex


class Transfer(Protocol):
    """Γ(s) of the components of w that a perturbation changes, 2P + 1 = M harmonics.

    Values z that contacts remember over a period are unknowns beside w,

        w = Γ u + Y z,      (1 - κ e^{-2πs}) z = C u.
    """

    @property
    def components(self) -> Integers:
        """(o,) which, counted through (c, 3)."""

    @property
    def partners(self) -> Integers:
        """(n, o) components of u that each answers to: its own, v, and what else."""

    @property
    def remembering(self) -> Integers:
        """(q,) places among `components` of the first of the two that z belongs to."""

    @property
    def kept(self) -> Floats:
        """(q,) κ."""

    def at(self, s: complex) -> Transferred:
        """Γ, Y and C at one s."""

    def onto_open(self, opened: Integers) -> "Transfer":
        """The law of w - u instead of w in the (m,) components of contacts open in the modes."""


@dataclass(frozen=True)
class LawTransfer:
    """Γ(s) of the components of w that a perturbation changes, 2P + 1 = M harmonics.

    `components` (o,): which, counted through (c, 3); `along`, `across` (o, M, M): what does not
    depend on s: from the component's own u, and from v of its contact; `held` (o, h, 4): where a
    slider is held: from, to, since when, and the factor c; zeros for none.
    """

    components: Integers
    along: Complex
    across: Complex
    held: Floats

    @property
    def harmonics(self) -> int:
        """P."""
        return int(self.along.shape[1]) // 2

    @property
    def partners(self) -> Integers:
        """(2, o) each component itself, and the normal one of its contact."""
        return np.array([self.components, self.components // 3 * 3])

    @property
    def remembering(self) -> Integers:
        """(0,) since all that is remembered is set anew in every period."""
        return np.zeros(0, np.int64)

    @property
    def kept(self) -> Floats:
        """(0,)."""
        return np.zeros(0)

    def at(self, s: complex) -> Transferred:
        """Γ(s) from u and from v."""
        k = np.arange(-self.harmonics, self.harmonics + 1)
        begin, end, since, factor = np.moveaxis(self.held[..., None], 2, 0)
        rate = s + 1j * k
        small = np.abs(rate) < 1e-12
        passed = -np.expm1(-rate * (end - begin)) / np.where(small, 1.0, rate)
        length = np.where(small, end - begin, passed)
        kept = np.exp(s * since - rate * begin) * length / TURN
        begun = np.exp(1j * k * since)
        along = self.along + kept.swapaxes(1, 2) @ begun
        across = self.across + (kept * factor).swapaxes(1, 2) @ begun
        none = np.zeros((0, 3, 2 * self.harmonics + 1), complex)
        return Transferred((along, across), none[:, :2], none)

    def onto_open(self, opened: Integers) -> "LawTransfer":
        """The law of w - u instead of w in the (m,) components of contacts open in the modes."""
        components = np.union1d(self.components, opened)
        own = np.searchsorted(components, self.components)
        along, across = np.zeros((2, len(components), *self.along.shape[1:]), complex)
        held = np.zeros((len(components), *self.held.shape[1:]))
        along[own], across[own], held[own] = self.along, self.across, self.held
        along[np.searchsorted(components, opened)] -= np.eye(2 * self.harmonics + 1)
        return LawTransfer(components, along, across, held)


def law_transfer(u: Floats, alpha: Floats, harmonics: int) -> LawTransfer:
    """Γ about a periodic motion."""
    m, count = u.shape[2], u.shape[0]
    longest = 6 * (2 * m + 2) + 2
    moments = np.zeros((count, 3, 2, 2 * harmonics + 1), complex)
    held = np.zeros((count, 3, longest, 4))
    answers = np.zeros((count, 3), np.bool_)
    _pieces(np.ascontiguousarray(u), alpha, grid((m - 1) // 2), moments, held, answers)
    components = np.flatnonzero(answers)
    held = held.reshape(-1, longest, 4)[components]
    most = int((held[..., 1] > held[..., 0]).sum(axis=1).max(initial=0))
    lag = np.subtract.outer(np.arange(2 * harmonics + 1), np.arange(2 * harmonics + 1)).T
    each = moments.reshape(-1, 2, 2 * harmonics + 1)[components][..., np.abs(lag)] / TURN
    along, across = np.moveaxis(np.where(lag < 0, each.conj(), each), 1, 0)
    return LawTransfer(components, along, across, held[:, :most])


@kernel
def _pieces(
    u: Floats,
    alpha: Floats,
    table: Floats,
    moments: Complex,
    held: Floats,
    answers: Booleans,
) -> None:
    """Moments ∫ e^{ikθ} of what follows u and v, pieces held, and whether a component answers."""
    m = u.shape[2]
    contact = np.empty(2 * m + 2)
    path = np.empty((6 * contact.size + 2, WIDTH))
    piece = np.empty(moments.shape[3], np.complex128)
    for c in range(u.shape[0]):
        v = u[c, 0]
        count = roots(v, table, contact)
        if count > 0 or v[0] <= 0.0:
            answers[c, 0] = True
            if count == 0:
                moments[c, 0, 0, 0] = TURN
            for i in range(0 if value(v, 0.0) >= 0.0 else 1, count, 2):
                last = contact[i + 1] if i + 1 < count else contact[0] + TURN
                add_integrals(contact[i], last, moments[c, 0, 0])
        for d in range(1, 3):
            size = slider_path(v, u[c, d], alpha[c, d - 1], contact, count, table, path)
            if size == 1 and path[0, KIND] == HELD:
                continue  # rests for good
            answers[c, d] = True
            pieces = 0
            for i in range(size):
                kind, begin, end = int(path[i, KIND]), path[i, BEGIN], path[i, END]
                if kind == HELD:
                    row = held[c, d, pieces]
                    row[0], row[1] = begin, end
                    row[2], row[3] = path[i, SOURCE], path[i, FACTOR]
                    pieces += 1
                    continue
                piece[:] = 0.0
                add_integrals(begin, end, piece)
                moments[c, d, 0] += piece
                if kind != FREE:
                    sign = 1.0 if kind == HIGH else -1.0
                    moments[c, d, 1] += sign * alpha[c, d - 1] * piece
