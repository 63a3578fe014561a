"""Zeros of the characteristic matrix in a window: all of them, and counted another way.

Beyn's contour integrals (Linear Algebra Appl. 436 (2012) 3839-3863) turn them into eigenvalues,

    A_p = 1/2πi ∮ s^p S(s)⁻¹ ds,      B_p = [A_p, A_p+1; A_p+1, A_p+2],      B_0 = V Σ Wᴴ,
    zeros: eigenvalues of Vᴴ B_1 W Σ⁻¹

(blocks of two, as both poles of a mode may lie in the contour), and they are as many as det S turns
round zero along the window's edge.

The characteristic matrix of perturbations: singular at the Floquet exponents.

The contacts' deviations w = Γ(s) u, u = Σ b_r a_r + R(s) w, are eliminated: in the amplitudes a of
the modes told apart

    S(s) a = 0,      S = diag p(s) - G(s),      G = bᴴ K_c [I - Γ(s) R(s)]⁻¹ Γ(s) b.

Values z that contacts remember over a period (`perturbation`) are amplitudes, too, their p being
1 - κ e^{-2πs}.

Near the values of s of interest G has no poles, however little damped the modes are: on a circle
its Taylor series converges fast, by the coefficients of Cauchy's formula on a few points,

    G(s) = Σ_l g_l ((s - c)/ρ)^l,      g_l = 1/q Σ_i G(c + ρ e^{2πi·i/q}) e^{-2πi·il/q}.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vanelock.common.arrays import Array, Complex, Floats
from vanelock.nonlinear.floquet.perturbation import (
    HALF,
    LEFT,
    RIGHT,
    PerturbedStructure,
    Transfer,
    Transferred,
    outside,
)
from vanelock.nonlinear.fourier import TURN


@dataclass(frozen=True)
class _Characteristic:
    """S(s) of one nodal diameter of perturbations, evaluated in full."""

    structure: PerturbedStructure
    law: Transfer

    @property
    def size(self) -> int:
        """M, remembered values included."""
        return len(self.structure.chosen) + len(self.law.memory)

    @cached_property
    def _rows(self) -> tuple[list[Complex], Complex]:
        """(m, o) rows of the components' partners, each, and modal forces of the components."""
        law, stiffness = self.law, self.structure.stiffness
        own = self.structure.rows(law.components)
        partners = [self.structure.rows(rows) for rows in law.partners]
        return partners, own.conj() * stiffness[law.components]

    @cached_property
    def _parts(self) -> tuple[Array, list[Array], list[Array]]:
        """Where the partners are among those moved, and R's factors, by harmonic."""
        law, each = self.law, self.structure.each
        onto, places = np.unique(law.partners, return_inverse=True)
        stiffness = self.structure.stiffness[law.components]
        moved = [modes.rows[onto] for modes in each]
        pull = [modes.pull[:, law.components] * stiffness for modes in each]
        return places.reshape(law.partners.shape), moved, pull

    @cached_property
    def _unit(self) -> Floats:
        """(q,) of z, so that it counts as amplitudes do, by the energy of its spring."""
        law = self.law
        return 1 / np.sqrt(self.structure.stiffness[law.components[law.remembering]])

    def answer(self, s: complex) -> tuple[Transferred, Complex, Complex]:
        """The law, R, and (o, 2P + 1, m) deviations that go with unit amplitudes."""
        law, structure = self.law, self.structure
        found = law.at(s)
        o, M = found.parts[0].shape[:2]
        places, moved, pull = self._parts
        rest = structure.rest(s, moved, pull)
        rows, place = self._rows[0], structure.place
        # Γ R: components answered, their harmonics, components that deviate, their harmonics.
        left = np.zeros((o, M, o, M), complex)
        right = np.zeros((o, M, self.size), complex)
        for part, each, own in zip(found.parts, places, rows, strict=True):
            left += part[:, :, None] * rest[:, each].transpose(1, 2, 0)[:, None]
            right[:, :, : len(place)] += part[:, :, place] * own.T[:, None]
        for i, first in enumerate(law.remembering):
            right[first : first + 2, :, len(place) + i] = found.shown[i] * self._unit[i]
        matrix = np.eye(o * M) - left.reshape(o * M, o * M)
        solved = np.linalg.solve(matrix, right.reshape(o * M, self.size))
        return found, rest, np.asarray(solved.reshape(o, M, self.size))

    def coupling(self, s: complex) -> Complex:
        """(m, m) G(s)."""
        found, rest, w = self.answer(s)
        partners, forces = self._rows
        place, first = self.structure.place, self.law.remembering
        near = np.einsum("mo,omn->mn", forces, w[:, place])
        read = np.zeros((len(first), self.size), complex)
        for e, (each, own) in enumerate(zip(self._parts[0], partners, strict=True)):
            of = found.read[:, e] / self._unit[:, None]
            read[:, : len(place)] += of[:, place] * own.T[first]
            read += np.einsum("qk,kqo,okn->qn", of, rest[:, each[first]], w, optimize=True)
        return np.asarray(np.concatenate([near, read]))

    def diagonal(self, s: complex) -> Complex:
        """(m,) p, of z too."""
        kept = 1 - self.law.memory * np.exp(-TURN * s)
        return np.concatenate([self.structure.diagonal(s), kept])

    def __call__(self, s: complex) -> Complex:
        """(m, m) S(s)."""
        return np.asarray(np.diag(self.diagonal(s)) - self.coupling(s))

    def series(self, centre: complex, radius: float, count: int) -> "Series":
        """S by the Taylor series of G in a circle, from G at `count` points."""
        points = centre + radius * np.exp(2j * np.pi * np.arange(count) / count)
        values = np.array([self.coupling(s) for s in points])
        return Series(self, centre, radius, np.fft.fft(values, axis=0) / count)


@dataclass(frozen=True)
class Series:
    """S(s) in a circle.

    `exact`: S in full; `terms` (q, m, m): g_l.
    """

    exact: _Characteristic
    centre: complex
    radius: float
    terms: Complex

    def __call__(self, s: complex) -> Complex:
        """(m, m) S(s)."""
        powers = ((s - self.centre) / self.radius) ** np.arange(len(self.terms))
        return np.asarray(np.diag(self.exact.diagonal(s)) - np.tensordot(powers, self.terms, 1))

    def slope(self, s: complex) -> Complex:
        """(m, m) dS/ds, by a difference."""
        step = 1e-5 * self.radius
        return np.asarray((self(s + step) - self(s - step)) / (2 * step))

    def polished(self, s: complex) -> complex:
        """A zero of S in full, by two of Newton's steps from one of the series."""
        for _ in range(2):
            left, size, right = np.linalg.svd(self.exact(s))
            s -= complex(size[-1] / (left[:, -1].conj() @ self.slope(s) @ right[-1].conj()))
        return s

    @property
    def error(self) -> float:
        """The last terms of the series over the largest: small where it converges."""
        size = np.abs(self.terms).max(axis=(1, 2), initial=0.0)
        return float(size[-2:].max() / max(size.max(), np.finfo(float).tiny))


_Matrix = Callable[[complex], Complex]

_NODES = 64
_RANK = 1e-11  # singular values of B_0, to the largest
_SPURIOUS = 1e-4  # what is left of S a, to the norms of both
_ATTEMPTS = ((3.0, 12), (3.0, 24), (8.0, 32), (20.0, 64))
"""How near poles of modes are told apart, and points of the series, until it converges."""
_CONVERGED = 1e-5  # last terms of the series, to the largest
_LARGEST = 500  # modes told apart


def zeros(
    structure: Callable[[float], PerturbedStructure], law: Transfer
) -> tuple[Series, list[tuple[complex, Complex]], bool]:
    """All zeros of S in the window: what S is approximated by, pairs of s and a, and if complete.

    The amplitudes a (m,) have unit norm, S(s) a = 0. They are complete where the winding of det S
    counts as many; not where the series does not converge.
    """
    centre = (LEFT + RIGHT) / 2
    radius = float(np.hypot(RIGHT - centre, HALF))  # through the corners
    series: Series | None = None
    for near, points in _ATTEMPTS:
        characteristic = _Characteristic(structure(near), law)
        if series is not None and characteristic.size > _LARGEST:
            break
        series = characteristic.series(centre, radius, points)
        if series.error < _CONVERGED:
            break
    assert series is not None
    found = [_improved(series, s, a) for s, a in _beyn(series, centre, radius)]
    each = [pair for pair in found if pair is not None]
    known = np.array([s for s, _ in each], complex)
    inside = [pair for pair in each if outside(pair[0]) == 0]
    complete = series.error < _CONVERGED and _missed(series, known) == 0
    return series, inside, complete


def _beyn(matrix: _Matrix, centre: float, radius: float) -> Iterator[tuple[complex, Complex]]:
    """Zeros in a circle and their vectors (m,); some beyond it and spurious ones among them."""
    turn = np.exp(2j * np.pi * (np.arange(_NODES) + 0.5) / _NODES)
    inverse = np.array([np.linalg.inv(matrix(centre + radius * each)) for each in turn])
    moments = [np.tensordot(turn**p, inverse, 1) / _NODES for p in range(1, 5)]
    first, second = (np.block([moments[p : p + 2], moments[p + 1 : p + 3]]) for p in (0, 1))
    left, size, right = np.linalg.svd(first)
    rank = int((size > _RANK * size.max(initial=0.0)).sum())
    left, right = left[:, :rank], right[:rank].conj().T
    values, vectors = np.linalg.eig(left.conj().T @ second @ right / size[:rank])
    amplitudes = left[: inverse.shape[1]] @ vectors
    for value, a in zip(values, amplitudes.T, strict=True):
        yield complex(centre + radius * value), a


def _improved(series: Series, s: complex, a: Complex) -> tuple[complex, Complex] | None:
    """A zero and its vector of unit norm by two of Newton's steps for both; None if spurious."""
    matrix = series(s)
    if np.linalg.norm(matrix @ a) > _SPURIOUS * np.linalg.norm(matrix) * np.linalg.norm(a):
        return None
    for _ in range(2):
        moved = np.linalg.solve(series(s), series.slope(s) @ a)
        s -= complex(np.vdot(a, a) / np.vdot(a, moved))
        a = np.asarray(moved / np.linalg.norm(moved))
    return s, a


def _missed(matrix: _Matrix, zeros: Complex) -> int:
    """Zeros in the window beside the known ones: turns of det S / Π(s - known) along its edge.

    Without the known zeros it varies slowly; steps are halved until none turns it by a radian.
    """
    low, high = LEFT + 1j * HALF * np.array([-1, 1]), RIGHT + 1j * HALF * np.array([-1, 1])
    corners = np.array([low[0], high[0], high[1], low[1], low[0]])

    def direction(t: float) -> complex:
        s = complex(np.interp(t, np.arange(5), corners))
        away = np.where(s == zeros, 1, s - zeros)
        turned = (away.conj() / np.abs(away)).prod()
        return complex(np.linalg.slogdet(matrix(s))[0] * turned)

    total, left_over = 0.0, list(np.linspace(4, 0, 97))
    t = left_over.pop()
    here = direction(t)
    while left_over:
        there = direction(left_over[-1])
        turned = float(np.angle(there * here.conjugate()))
        if abs(turned) > 1 and left_over[-1] - t > 1e-9:
            left_over.append((t + left_over[-1]) / 2)
            continue
        total += turned
        t, here = left_over.pop(), there
    return round(total / (2 * np.pi))
