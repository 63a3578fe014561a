"""What the reductions of joined parts leave out, as arrays."""

from dataclasses import dataclass

import numpy as np

from vanelock.common.arrays import Integers
from vanelock.rom.system.system import Matrix

NEAR = 0.1
"""Least distance 1 - θ/Ω² from a left-out mode that estimates count with."""


@dataclass(frozen=True)
class Neglected:
    """By how much a joined model at one nodal diameter is too stiff, see `errors.frequency_errors`.

    Attributes
    ----------
    parts : tuple of ((m,) int, (3, m, m), float)
        For each part its place among the joined coordinates, its forms G, and the circular
        frequency up to which it keeps all fixed-interface modes, rad/s.
    """

    parts: tuple[tuple[Integers, Matrix, float], ...]

    def force(self, omega: float, x: Matrix) -> Matrix:
        """Forces (n,) that the missing compliance amounts to at the joined coordinates (n,), N.

        Beyond a part's own limit the estimate is a guess: the nearest ten per cent stand for it.
        """
        total = np.zeros(len(x), complex)
        for dofs, (G0, G1, G2), complete in self.parts:
            q = x[dofs]
            pushed = G0 @ q - omega**2 * (G1 @ q) + omega**4 * (G2 @ q)
            near = max(abs(1 - (omega / complete) ** 2), NEAR) if complete else NEAR
            total[dofs] += pushed / near
        return total
