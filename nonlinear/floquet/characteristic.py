"""The characteristic matrix of perturbations: singular at the Floquet exponents.

The contacts' deviations w = Γ(s) u, u = Σ b_r a_r + R(s) w, are eliminated: in the amplitudes a of
the modes told apart

    S(s) a = 0,      S = diag p(s) - G(s),      G = bᴴ K_c [I - Γ(s) R(s)]⁻¹ Γ(s) b.

Values z that contacts remember over a period (`law_transfer`) are amplitudes, too, their p being
1 - κ e^{-2πs}.

Near the values of s of interest G has no poles, however little damped the modes are: on a circle
its Taylor series converges fast, by the coefficients of Cauchy's formula on a few points,

    G(s) = Σ_l g_l ((s - c)/ρ)^l,      g_l = 1/q Σ_i G(c + ρ e^{2πi·i/q}) e^{-2πi·il/q}.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.floquet.law_transfer import Transfer, Transferred
from vanelock.nonlinear.floquet.perturbed_structure import PerturbedStructure
from vanelock.nonlinear.fourier.trigonometric import TURN

Array = NDArray[Any]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Characteristic:
    """S(s) of one nodal diameter of perturbations, evaluated in full.

    Attributes
    ----------
    structure : PerturbedStructure
    law : Transfer
    """

    structure: PerturbedStructure
    law: Transfer

    @property
    def size(self) -> int:
        """M, remembered values included."""
        return len(self.structure.chosen) + len(self.law.kept)

    @cached_property
    def _rows(self) -> tuple[list[Complex], Complex]:
        """(m, o) rows of the components' partners, each, and modal forces of the components."""
        law, stiffness = self.law, self.structure.stiffness
        own = self.structure.rows(law.components)
        partners = [self.structure.rows(rows) for rows in law.partners]
        return partners, own.conj() * stiffness[law.components]

    @cached_property
    def _parts(self) -> tuple[NDArray[Any], list[Array], list[Array]]:
        """Where the partners are among those moved, and R's factors, by harmonic."""
        law, each = self.law, self.structure.each
        onto, places = np.unique(law.partners, return_inverse=True)
        stiffness = self.structure.stiffness[law.components]
        moved = [modes.rows[onto] for modes in each]
        pull = [modes.pull[:, law.components] * stiffness for modes in each]
        return places.reshape(law.partners.shape), moved, pull

    @cached_property
    def _unit(self) -> NDArray[np.float64]:
        """(q,) of z, so that it counts as amplitudes do, by the energy of its spring."""
        law = self.law
        return 1 / np.sqrt(self.structure.stiffness[law.components[law.remembering]])

    def _answer(self, s: complex) -> tuple[Transferred, Complex, Complex]:
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

    def deviations(self, s: complex) -> Complex:
        """(o, 2P + 1, m) deviations that go with unit amplitudes of the near modes and of z."""
        return self._answer(s)[2]

    def coupling(self, s: complex) -> Complex:
        """(m, m) G(s)."""
        found, rest, w = self._answer(s)
        partners, forces = self._rows
        place, first = self.structure.place, self.law.remembering
        near = np.einsum("mo,omn->mn", forces, w[:, place])
        read = np.zeros((len(first), self.size), complex)
        for e, (each, own) in enumerate(zip(self._parts[0], partners, strict=True)):
            of = found.read[:, e] / self._unit[:, None]
            read[:, : len(place)] += of[:, place] * own.T[first]
            read += np.einsum("qk,kqo,okn->qn", of, rest[:, each[first]], w, optimize=True)
        both: Complex = np.concatenate([near, read])
        return both

    def diagonal(self, s: complex) -> Complex:
        """(m,) p, of z too."""
        kept = 1 - self.law.kept * np.exp(-TURN * s)
        return np.concatenate([self.structure.diagonal(s), kept])

    def __call__(self, s: complex) -> Complex:
        """(m, m) S(s)."""
        matrix: Complex = np.diag(self.diagonal(s)) - self.coupling(s)
        return matrix

    def series(self, centre: complex, radius: float, count: int) -> "Series":
        """S by the Taylor series of G in a circle, from G at `count` points."""
        points = centre + radius * np.exp(2j * np.pi * np.arange(count) / count)
        values = np.array([self.coupling(s) for s in points])
        return Series(self, centre, radius, np.fft.fft(values, axis=0) / count)


@dataclass(frozen=True)
class Series:
    """S(s) in a circle.

    Attributes
    ----------
    exact : Characteristic
        S in full.
    centre : complex
    radius : float
    terms : (q, m, m) complex
        g_l.
    """

    exact: Characteristic
    centre: complex
    radius: float
    terms: Complex

    def __call__(self, s: complex) -> Complex:
        """(m, m) S(s)."""
        powers = ((s - self.centre) / self.radius) ** np.arange(len(self.terms))
        found: Complex = np.diag(self.exact.diagonal(s)) - np.tensordot(powers, self.terms, 1)
        return found

    def slope(self, s: complex) -> Complex:
        """(m, m) dS/ds, by a difference."""
        step = 1e-5 * self.radius
        found: Complex = (self(s + step) - self(s - step)) / (2 * step)
        return found

    def polished(self, s: complex, steps: int = 2) -> complex:
        """A zero of S in full, by Newton's method from one of the series."""
        for _ in range(steps):
            left, size, right = np.linalg.svd(self.exact(s))
            s -= complex(size[-1] / (left[:, -1].conj() @ self.slope(s) @ right[-1].conj()))
        return s

    @property
    def error(self) -> float:
        """The last terms of the series over the largest: small where it converges."""
        size = np.abs(self.terms).max(axis=(1, 2), initial=0.0)
        return float(size[-2:].max() / max(size.max(), np.finfo(float).tiny))
