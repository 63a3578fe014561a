"""Natural frequencies of the joined parts against rotor speed, and where engine orders meet them.

    K(n) = s_vane(n) K_vane + s_casing(n) K_casing + Bᴴ K_c B,      s = E(T(n)) / E

at one nodal diameter, with the interlock's contacts in B or not. The modes at a few speeds span
those at all speeds between (Ritz; the error goes as that of the interpolated shapes squared, below
1e-9 where moduli change by a third, as its test shows). A line of engine order EO meets mode j
where f_j(n) = |EO| n / 60, which is solved on the modes themselves, not between points of a drawn
line. Lines are numbered by ascending frequency at every speed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray
from scipy.optimize import brentq

from vanelock.common.arrays import Floats
from vanelock.rom import Component, MeshExcess, System

Factors = Callable[[float], tuple[float, float]]
"""Moduli of vane and casing at a speed, rpm, over those of the parts given."""

FEWEST = 24
"""Speeds at least between which a crossing is looked for; bends of the temperatures add to them."""
SPANNING = 5
"""Speeds whose modes span those of all others."""
MORE = 6
"""Modes beyond those asked for that help to."""


@dataclass(frozen=True)
class Meeting:
    """Where a line of an engine order meets a mode: place of the mode from 0, rpm, Hz."""

    mode: int
    speed: float
    frequency: float


@dataclass
class ModesOverSpeed:
    """Two joined parts at one nodal diameter."""

    system: System
    parts: Mapping[str, Component]
    nodal_diameter: int
    factors: Factors
    ends: tuple[float, float]
    excess: MeshExcess | None = None
    _pieces: tuple[NDArray[np.complex128], ...] = field(init=False)
    _spans: dict[tuple[bool, int], tuple[NDArray[np.complex128], ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Bring K of each part and of each group of contacts to coordinates of unit mass."""
        k, matrices = self.nodal_diameter, self.system.at(self.nodal_diameter)
        n = len(matrices.K)
        lower = sl.cholesky(matrices.M, lower=True)
        blade, shell = (matrices.joined(p, self.parts[p].at(k).K) for p in ("vane", "casing"))
        if self.excess is not None and k in self.excess.diameters:
            off = self.excess.diameters[k].stiffness
            blade, shell = blade - off[0], shell - off[1]
        rows, stays = self.system.contact_rows(k), ~self.system.contacts.opens
        contacts = []
        for own in (stays, ~stays):
            B = rows[own].reshape(-1, n)
            stiffness = self.system.contacts.stiffness[own].ravel()
            contacts.append((B.conj().T * stiffness) @ B)
        self._pieces = tuple(_unit(each, lower) for each in (blade, shell, *contacts))

    def frequencies(self, speed: float, stuck: bool, count: int) -> Floats:
        """(count,) lowest natural frequencies at a rotor speed, rpm, Hz, ascending."""
        if (stuck, count) not in self._spans:
            self._spans[stuck, count] = self._spanned(stuck, count)
        A = _at(self._spans[stuck, count], self.factors(speed), stuck)
        squared = sl.eigh(A, eigvals_only=True, subset_by_index=[0, min(count, len(A)) - 1])
        return np.asarray(np.sqrt(squared.clip(0)) / (2 * np.pi))

    def _spanned(self, stuck: bool, count: int) -> tuple[NDArray[np.complex128], ...]:
        """K of each part and group of contacts in the modes at a few speeds together."""
        low, high = self.ends
        nodes = np.polynomial.chebyshev.chebpts2(SPANNING)
        moduli = [self.factors(float(n)) for n in low + (high - low) * (1 + nodes) / 2]
        shapes = []
        for each in dict.fromkeys(moduli):
            A = _at(self._pieces, each, stuck)
            last = min(count + MORE, len(A)) - 1
            shapes.append(sl.eigh(A, subset_by_index=[0, last])[1])
        basis = sl.orth(np.hstack(shapes), rcond=1e-10)
        return tuple(_hermitian(basis.conj().T @ each @ basis) for each in self._pieces)

    def line(self, speeds: Floats, stuck: bool, count: int) -> Floats:
        """(s, count) natural frequencies at rotor speeds (s,), rpm, Hz."""
        return np.array([self.frequencies(float(each), stuck, count) for each in speeds])

    def meetings(self, order: int, stuck: bool, count: int, speeds: Floats) -> list[Meeting]:
        """Where an engine order meets the lowest modes, within rotor speeds (s,), ascending."""
        slope = abs(order) / 60
        above = self.line(speeds, stuck, count) - slope * speeds[:, None]
        found = []
        for j in range(above.shape[1]):

            def gap(speed: float, j: int = j) -> float:
                return float(self.frequencies(speed, stuck, count)[j]) - slope * speed

            for i in np.flatnonzero((above[:-1, j] > 0) != (above[1:, j] > 0)):
                low, high = float(speeds[i]), float(speeds[i + 1])
                met = float(brentq(gap, low, high, xtol=1e-7 * high, rtol=1e-12))
                found.append(Meeting(j, met, slope * met))
        return found


def _at(
    pieces: tuple[NDArray[np.complex128], ...], moduli: tuple[float, float], stuck: bool
) -> NDArray[np.complex128]:
    """Stiffness with these moduli of vane and casing, the interlock stuck or free."""
    blade, shell, hooked, locked = pieces
    return np.asarray(moduli[0] * blade + moduli[1] * shell + hooked + (locked if stuck else 0))


def _unit(K: NDArray[np.complex128], lower: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """L⁻¹ K L⁻ᴴ."""
    half = sl.solve_triangular(lower, K, lower=True)
    return _hermitian(sl.solve_triangular(lower, half.conj().T, lower=True))


def _hermitian(A: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return np.asarray((A + A.conj().T) / 2)


def grid(low: float, high: float, bends: Sequence[float]) -> Floats:
    """Speeds from low to high, rpm, even, with those between where temperatures bend."""
    even = np.linspace(low, high, FEWEST + 1)
    within = [each for each in bends if low < each < high]
    return np.unique(np.concatenate([even, within]))
