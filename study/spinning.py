"""Natural frequencies of the joined parts against rotor speed, and where engine orders meet them.

    K(n) = s_vane(n) K_vane + s_casing(n) K_casing + Bᴴ K_c B,      s = E(T(n)) / E

at one nodal diameter, with the interlock's contacts in B or not. A line of engine order EO meets
mode j where f_j(n) = |EO| n / 60, which is solved on the modes themselves, not between points of a
drawn line. Lines are numbered by ascending frequency at every speed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray
from scipy.optimize import brentq

from vanelock.rom import Component, System
from vanelock.rom.joining import joined_dofs
from vanelock.study.limits import hooks

Floats = NDArray[np.float64]
Factors = Callable[[float], tuple[float, float]]
"""Moduli of vane and casing at a speed, rpm, over those of the parts given."""

FEWEST = 24
"""Speeds at least between which a crossing is looked for; bends of the temperatures add to them."""


@dataclass(frozen=True)
class Meeting:
    """Where a line of an engine order meets a mode: place of the mode from 0, rpm, Hz."""

    mode: int
    speed: float
    frequency: float


@dataclass
class Spinning:
    """Two joined parts at one nodal diameter.

    Parameters
    ----------
    system : System
        What joins them; friction and interference do not matter.
    vane, casing : Component
        The parts.
    nodal_diameter : int
        ND.
    factors : callable
        Their moduli against speed.
    """

    system: System
    vane: Component
    casing: Component
    nodal_diameter: int
    factors: Factors
    _pieces: tuple[NDArray[np.complex128], ...] = field(init=False)
    _known: dict[tuple[float, float, bool, int], Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Bring K of each part and of each group of contacts to coordinates of unit mass."""
        k, matrices = self.nodal_diameter, self.system.at(self.nodal_diameter)
        n = len(matrices.K)
        lower = sl.cholesky(matrices.M, lower=True)
        dofs = joined_dofs(self.vane, self.casing)
        shell, blade = np.zeros((2, n, n), complex)
        shell[: self.casing.size, : self.casing.size] = self.casing.at(k).K
        blade[np.ix_(dofs, dofs)] = self.vane.at(k).K
        rows, stays = self.system.contact_rows(k), hooks(self.system.contacts.joint)
        contacts = []
        for own in (stays, ~stays):
            B = rows[own].reshape(-1, n)
            stiffness = self.system.contacts.stiffness[own].ravel()
            contacts.append((B.conj().T * stiffness) @ B)
        self._pieces = tuple(_unit(each, lower) for each in (blade, shell, *contacts))

    def frequencies(self, speed: float, stuck: bool, count: int) -> Floats:
        """(count,) lowest natural frequencies at a rotor speed, rpm, Hz, ascending."""
        vane, casing = self.factors(speed)
        key = vane, casing, stuck, count
        if key not in self._known:
            blade, shell, hooked, locked = self._pieces
            A = vane * blade + casing * shell + hooked + (locked if stuck else 0)
            squared = sl.eigh(A, eigvals_only=True, subset_by_index=[0, min(count, len(A)) - 1])
            self._known[key] = np.sqrt(squared.clip(0)) / (2 * np.pi)
        return self._known[key]

    def line(self, speeds: Floats, stuck: bool, count: int) -> Floats:
        """(s, count) natural frequencies at rotor speeds (s,), rpm, Hz."""
        return np.array([self.frequencies(float(each), stuck, count) for each in speeds])

    def meetings(self, order: int, stuck: bool, count: int, speeds: Floats) -> list[Meeting]:
        """Where engine order `order` meets the lowest modes, within rotor speeds (s,), ascending.

        Parameters
        ----------
        order : int
            EO; its sign does not matter.
        stuck : bool
            Whether the interlock is.
        count : int
            Number of modes.
        speeds : (s,) float
            Between two neighbours no line is met twice, rpm.
        """
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


def _unit(K: NDArray[np.complex128], lower: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """L⁻¹ K L⁻ᴴ."""
    half = sl.solve_triangular(lower, K, lower=True)
    whole = sl.solve_triangular(lower, half.conj().T, lower=True)
    return np.asarray((whole + whole.conj().T) / 2)


def grid(low: float, high: float, bends: Sequence[float]) -> Floats:
    """Speeds from low to high, rpm, even, with those between where temperatures bend."""
    even = np.linspace(low, high, FEWEST + 1)
    within = [each for each in bends if low < each < high]
    return np.unique(np.concatenate([even, within]))
