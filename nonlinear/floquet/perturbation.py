"""The stuck structure, and the contact law, under a small perturbation of a periodic motion.

Harmonic k of a perturbation of nodal diameter n has the diameter (n + k EO) mod N and moves as
e^{zt}, z = (s + ik)ω. In the modes V of that diameter (`stuck_modes`)

    p_r a_r = b_rᴴ K_c w_k,      p_r = A_r + z²Λ_r + z d_r,      u_k = Σ_r b_r a_r,

w - u instead of w for contacts that are open in the modes. Modes with a pole near the values of s
of interest are told apart, and all lower ones where contacts are open, whose closing raises them:
what all others add, R_k(s) w_k, is smooth in s there.

The contact law is linearised with sliders' memory. To perturbed displacements Re[e^{λt} Σ_k u_k
e^{ikθ}], s = λ/ω, θ = ωt, the deviation w answers with harmonics w_j = Σ_k Γ_jk(s) u_k. Between two
events of the motion

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

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from vanelock.common.arrays import Array, Booleans, Complex, Floats, Integers
from vanelock.nonlinear.balance.stuck_modes import StuckModes
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
from vanelock.nonlinear.fourier import TURN, add_integrals, grid, kernel, roots, value
from vanelock.rom.system.system import System

LEFT, RIGHT, HALF = -0.1, 1.0, 0.52
"""Of s = λ/ω, a window of -0.1 <= Re s <= 1 and |Im s| <= 0.52: motions that shrink to no less than
0.53 a period and grow to no more than 500, a little higher than the half harmonics at which
diameters meet."""


def outside(s: Complex | complex) -> Floats:
    """How far values lie outside the window."""
    s = np.asarray(s)
    beside = np.maximum(np.maximum(LEFT - s.real, s.real - RIGHT), 0.0)
    return np.hypot(beside, np.maximum(np.abs(s.imag) - HALF, 0.0))


@dataclass(frozen=True)
class PerturbedStructure:
    """One nodal diameter of perturbations of a motion.

    `modes`: of all diameters 0 ... N - 1; `diameter`: n; `omega`: of the motion, rad/s;
    `harmonics`: P; `near`: how far from the window the poles of modes told apart may lie.
    """

    system: System
    modes: Mapping[int, StuckModes]
    diameter: int
    omega: float
    harmonics: int
    near: float

    @cached_property
    def each(self) -> list[StuckModes]:
        """Modes of the harmonics -P ... P."""
        N, order = self.system.sectors, self.system.engine_order
        harmonics = range(-self.harmonics, self.harmonics + 1)
        return [self.modes[(self.diameter + k * order) % N] for k in harmonics]

    @cached_property
    def poles(self) -> list[Complex]:
        """(2, n) values of s at which p of each mode vanishes, by harmonic."""
        pairs = enumerate(self.each, -self.harmonics)
        return [_complex_poles(modes) / self.omega - 1j * k for k, modes in pairs]

    @cached_property
    def chosen(self) -> list[tuple[int, int]]:
        """Place of the harmonic and number of the mode of the m near ones."""
        near = [(outside(s) < self.near).any(axis=0) for s in self.poles]
        for k, modes in enumerate(self.each, -self.harmonics):
            if modes.springs is not None:
                reach = self.omega * (abs(k) + HALF + self.near)
                near[k + self.harmonics] |= modes.poles() < reach
        return [(place, int(r)) for place, one in enumerate(near) for r in np.flatnonzero(one)]

    @cached_property
    def place(self) -> Integers:
        """(m,) place of the harmonic of each near mode."""
        return np.array([place for place, _ in self.chosen], np.int64)

    @cached_property
    def number(self) -> Integers:
        """(m,) number of each near mode among its diameter's."""
        return np.array([r for _, r in self.chosen], np.int64)

    @cached_property
    def stiffness(self) -> Floats:
        """K_c, (3c,) N/m."""
        return self.system.contacts.stiffness.reshape(-1)

    @cached_property
    def _quadratic(self) -> Floats:
        """(3, m) A, d and Λ of the near modes."""
        found = np.empty((3, len(self.chosen)))
        for i, (k, r) in enumerate(self.chosen):
            modes = self.each[k]
            found[:, i] = modes.static[r], modes.damping[r], modes.compliance[r]
        return found

    def diagonal(self, s: complex) -> Complex:
        """(m,) p of the near modes."""
        z = self.omega * (s + 1j * (self.place - self.harmonics))
        static, damping, compliance = self._quadratic
        return np.asarray(static + z * (z * compliance + damping))

    def rows(self, components: Integers) -> Complex:
        """(m, k) relative displacements of k components in the near modes."""
        found = [self.each[k].rows[components, r] for k, r in self.chosen]
        return np.array(found, complex).reshape(len(found), len(components))

    def rest(self, s: complex, rows: list[Array], pull: list[Array]) -> Complex:
        """(2P + 1, k, o) R_k(s) of all modes but the near ones."""
        found = np.empty((len(rows), len(rows[0]), pull[0].shape[1]), complex)
        for place, modes in enumerate(self.each):
            z = self.omega * (s + 1j * (place - self.harmonics))
            answer = 1 / (modes.static + z * (z * modes.compliance + modes.damping))
            answer[self.number[self.place == place]] = 0.0
            found[place] = (rows[place] * answer) @ pull[place]
        return found

    def output_rows(self, index: int) -> Complex:
        """(d, n) displacements of the outputs, or of the contacts without any, in all modes."""
        modes = self.each[index]
        diameter = self.diameter + (index - self.harmonics) * self.system.engine_order
        output = self.system.at(diameter % self.system.sectors).output
        if output is None or not len(output):
            return modes.rows
        return np.asarray(output.reshape(-1, len(modes.shapes)) @ modes.shapes)


def _complex_poles(modes: StuckModes) -> Complex:
    """(2, n) values of z, rad/s, at which p of each mode vanishes; infinity is a large one."""
    d = modes.damping
    root = np.sqrt(d**2 - 4 * modes.static * modes.compliance.astype(complex))
    inverse = -np.stack([d + root, d - root]) / 2
    return np.asarray(modes.static / np.where(np.abs(inverse) > 1e-150, inverse, -1e-150))


class Transferred(NamedTuple):
    """The linearised law at one s.

    `parts` tuple of (o, M, M) complex: Γ from each of the rows of `partners`; `shown` (q, 2, M):
    harmonics of w that a unit of each remembered value z adds to w of its plane; `read` (q, 3, M):
    what perturbations of its partners add to z in a period.
    """

    parts: tuple[Complex, ...]
    shown: Complex
    read: Complex


@dataclass(frozen=True)
class Transfer(ABC):
    """Γ(s) of the components of w that a perturbation changes, 2P + 1 = M harmonics.

    Values z that contacts remember over a period are unknowns beside w,

        w = Γ u + Y z,      (1 - κ e^{-2πs}) z = C u.

    `components` (o,): which, counted through (c, 3); `static` (n, o, M, M): what does not depend on
    s, from each of their partners.
    """

    components: Integers
    static: Complex

    @property
    def harmonics(self) -> int:
        """P."""
        return int(self.static.shape[2]) // 2

    @property
    def partners(self) -> Integers:
        """(n, o) components of u that each answers to: its own, v, and what else."""
        return np.array([self.components, self.components // 3 * 3])

    @property
    def remembering(self) -> Integers:
        """(q,) places among `components` of the first of the two that z belongs to."""
        return np.zeros(0, np.int64)

    @property
    def memory(self) -> Floats:
        """(q,) κ."""
        return np.zeros(0)

    @abstractmethod
    def at(self, s: complex) -> Transferred:
        """Γ, Y and C at one s."""

    def onto_open(self, opened: Integers) -> Self:
        """The law of w - u instead of w in the (m,) components of contacts open in the modes."""
        components = np.union1d(self.components, opened)
        place = np.searchsorted(components, self.components)
        static = np.zeros((len(self.static), len(components), *self.static.shape[2:]), complex)
        static[:, place] = self.static
        static[0, np.searchsorted(components, opened)] -= np.eye(2 * self.harmonics + 1)
        return self._among(components, static, place)

    @abstractmethod
    def _among(self, components: Integers, static: Complex, places: Integers) -> Self:
        """The law of more components, `places` (o,) those of this one's among them."""


@dataclass(frozen=True)
class _LawTransfer(Transfer):
    """That of orthogonal friction, all that is remembered set anew in every period.

    `held` (o, h, 4): where sliders are held: from, to, since when, and the factor c; zeros: none.
    """

    held: Floats

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
        along = self.static[0] + kept.swapaxes(1, 2) @ begun
        across = self.static[1] + (kept * factor).swapaxes(1, 2) @ begun
        none = np.zeros((0, 3, 2 * self.harmonics + 1), complex)
        return Transferred((along, across), none[:, :2], none)

    def _among(self, components: Integers, static: Complex, places: Integers) -> "_LawTransfer":
        held = np.zeros((len(components), *self.held.shape[1:]))
        held[places] = self.held
        return _LawTransfer(components, static, held)


def law_transfer(u: Floats, alpha: Floats, harmonics: int) -> _LawTransfer:
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
    static = np.moveaxis(np.where(lag < 0, each.conj(), each), 1, 0)
    return _LawTransfer(components, static, held[:, :most])


@kernel
def _pieces(
    u: Floats, alpha: Floats, table: Floats, moments: Complex, held: Floats, answers: Booleans
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
