"""The characteristic matrix of perturbations: singular at the Floquet exponents.

The contacts' deviations w = Γ(s) u, u = Σ b_r a_r + R(s) w, are eliminated: in the amplitudes a of
the modes told apart

    S(s) a = 0,      S = diag p(s) - G(s),      G = bᴴ K_c [I - Γ(s) R(s)]⁻¹ Γ(s) b.

Near the values of s of interest G has no poles, however little damped the modes are: on a circle
its Taylor series converges fast, by the coefficients of Cauchy's formula on a few points,

    G(s) = Σ_l g_l ((s - c)/ρ)^l,      g_l = 1/q Σ_i G(c + ρ e^{2πi·i/q}) e^{-2πi·il/q}.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.floquet.law_transfer import LawTransfer
from vanelock.nonlinear.floquet.perturbed_structure import PerturbedStructure

Array = NDArray[Any]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Characteristic:
    """S(s) of one nodal diameter of perturbations, evaluated in full.

    Attributes
    ----------
    structure : PerturbedStructure
    law : LawTransfer
    """

    structure: PerturbedStructure
    law: LawTransfer

    @property
    def size(self) -> int:
        """M."""
        return len(self.structure.chosen)

    @cached_property
    def _rows(self) -> tuple[Complex, Complex, Complex]:
        """(m, o) rows of the components and of their contacts' v, and modal forces."""
        law, stiffness = self.law, self.structure.stiffness
        own, normal = (self.structure.rows(rows) for rows in (law.components, law.normals))
        return own, normal, own.conj() * stiffness[law.components]

    @cached_property
    def _parts(self) -> tuple[NDArray[Any], list[Array], list[Array]]:
        """Where components and their v are among those moved, and R's factors, by harmonic."""
        law, each = self.law, self.structure.each
        onto, places = np.unique([law.components, law.normals], return_inverse=True)
        stiffness = self.structure.stiffness[law.components]
        moved = [modes.rows[onto] for modes in each]
        pull = [modes.pull[:, law.components] * stiffness for modes in each]
        return places.reshape(2, -1), moved, pull

    def deviations(self, s: complex) -> Complex:
        """(o, 2P + 1, m) deviations that go with unit amplitudes of the near modes."""
        law, structure = self.law, self.structure
        o, M = law.along.shape[:2]
        along, across = law.at(s)
        places, moved, pull = self._parts
        rest = structure.rest(s, moved, pull)
        own, normal = (rest[:, each].transpose(1, 2, 0)[:, None] for each in places)
        # Γ R: components answered, their harmonics, components that deviate, their harmonics.
        left = along[:, :, None] * own + across[:, :, None] * normal
        matrix = np.eye(o * M) - left.reshape(o * M, o * M)
        rows, normals, _ = self._rows
        place = structure.place
        right = along[:, :, place] * rows.T[:, None] + across[:, :, place] * normals.T[:, None]
        solved = np.linalg.solve(matrix, right.reshape(o * M, len(place)))
        return np.asarray(solved.reshape(o, M, len(place)))

    def coupling(self, s: complex) -> Complex:
        """(m, m) G(s)."""
        found: Complex = np.einsum(
            "mo,omn->mn", self._rows[2], self.deviations(s)[:, self.structure.place]
        )
        return found

    def __call__(self, s: complex) -> Complex:
        """(m, m) S(s)."""
        matrix: Complex = np.diag(self.structure.diagonal(s)) - self.coupling(s)
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
        found: Complex = np.diag(self.exact.structure.diagonal(s)) - np.tensordot(
            powers, self.terms, 1
        )
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
