"""Receptances over a range of frequencies, from tables."""

from dataclasses import dataclass
from math import ceil, log, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance import Balance, Structure

Floats = NDArray[np.float64]
Array = NDArray[Any]

MARGIN = 0.02  # how far, relatively, an arc may leave the range of frequencies


@dataclass(frozen=True)
class Tabulated:
    """Balances by circular frequency, rad/s, in a range: a few modes summed, the others tabulated.

    Those whose poles are further than three times hω from zero, natural frequencies or decays of
    overdamped modes, vary smoothly in the range, and Chebyshev interpolation of their sum is exact
    to rounding; the summation over hundreds of modes is paid at the nodes only.

    Attributes
    ----------
    structure : Structure
    limits : (float, float)
        The range, rad/s; outside it all modes are summed.
    nodes : (k,) float
        Chebyshev nodes, rad/s.
    weights : (k,) float
        Barycentric weights.
    low : tuple of int
        Number of modes summed, by harmonic.
    tables : tuple of (k, 3c, 3c)
        R̂_h of the other modes at the nodes, h = 1 ... H.
    """

    structure: Structure
    limits: tuple[float, float]
    nodes: Floats
    weights: Floats
    low: tuple[int, ...]
    tables: tuple[Array, ...]

    def balance(self, omega: float) -> Balance:
        """The balance at a circular frequency."""
        inner = self.structure
        if not self.limits[0] <= omega <= self.limits[1]:
            return inner.balance(omega)
        distance = omega - self.nodes
        if np.any(distance == 0):
            shares = (distance == 0).astype(float)
        else:
            shares = self.weights / distance
            shares /= shares.sum()
        receptance = [inner.receptance(0, omega)]
        for h in range(1, inner.harmonics + 1):
            modes, low = inner.at(h), self.low[h]
            near = modes.rows[:, :low]
            summed = (near / modes.dynamic(h * omega)[:low]) @ near.conj().T
            table = self.tables[h - 1]
            rest = (shares @ table.reshape(len(shares), -1)).reshape(table.shape[1:])
            receptance.append(rest + summed * inner.stiffness)
        return Balance(omega, inner.linear(omega), tuple(receptance))


def balances(
    structure: Structure, lowest: float, highest: float, points: int
) -> Structure | Tabulated:
    """What gives the balances of some points in a range of ω, rad/s: tables where cheaper."""
    low, high = (1 - MARGIN) * lowest, (1 + MARGIN) * highest
    coupled = any(modes.coupled_damping is not None for modes in structure.modes.values())
    # A pole is at least three times the highest frequency from zero, worst on the real axis;
    # Bernstein's ellipse through it.
    x = (3 * high - 0.5 * (high + low)) / (0.5 * (high - low))
    count = ceil(log(1e16) / log(x + sqrt(x * x - 1))) + 1
    if coupled or structure.harmonics == 0 or points <= count:
        return structure
    summed = [0]
    for h in range(1, structure.harmonics + 1):
        near = np.flatnonzero(structure.at(h).poles() < 3 * h * high)
        summed.append(int(near.max(initial=-1)) + 1)
    if all(n == len(structure.at(h).compliance) for h, n in enumerate(summed) if h):
        return structure  # nothing left to tabulate
    k = np.arange(count)
    cosine = np.cos(np.pi * (2 * k + 1) / (2 * count))
    nodes = 0.5 * (low + high) + 0.5 * (high - low) * cosine
    weights = np.asarray((-1.0) ** k * np.sin(np.pi * (2 * k + 1) / (2 * count)), float)
    tables = []
    for h in range(1, structure.harmonics + 1):
        modes, number = structure.at(h), summed[h]
        far = modes.rows[:, number:]
        table = [
            (far / modes.dynamic(h * omega)[number:]) @ far.conj().T * structure.stiffness
            for omega in nodes
        ]
        tables.append(np.array(table))
    return Tabulated(structure, (low, high), nodes, weights, tuple(summed), tuple(tables))
