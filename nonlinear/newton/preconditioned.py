"""A linearised balance solved by GMRES, preconditioned, in the norm that weights make.

On the entries of the contacts that deviate, and of a border's parameter behind them; the others are
their own solution.
"""

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.newton.gmres import gmres
from vanelock.nonlinear.newton.preconditioner import Kept

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


class Preconditioned(ABC):
    """P and what it is preconditioned by.

    Attributes
    ----------
    weight : (n,) float
        Of each component in the norm.
    places : (k,) int
        Components that P is of.
    kept : Kept or None
        What preconditions; None where P is singular.
    hessenberg : (j, j) float
        P M⁻¹ in the subspace of the last solution.
    """

    LIMIT: ClassVar[int]
    """Dimension of GMRES' subspace, at most."""
    STALE: ClassVar[int]
    """Iterations for each digit after which what is kept is made anew."""
    weight: Floats
    places: Rows
    kept: Kept | None
    hessenberg: Floats

    @abstractmethod
    def _operator(self, y: Floats) -> Floats:
        """P y, (k,)."""

    @abstractmethod
    def _precondition(self, y: Floats) -> Floats:
        """M⁻¹ y, (k,), M close to P."""

    def solve(self, gap: Floats, tolerance: float) -> Floats | None:
        """(dw, dp); None where the iteration does not get there."""
        inner: Floats = gap[self.places]
        weight: Floats = self.weight[self.places]

        def scaled(z: Floats) -> Floats:
            return self._operator(self._precondition(z / weight)) * weight

        with np.errstate(all="ignore"):
            reached = gmres(scaled, inner * weight, tolerance, self.LIMIT)
        self.hessenberg = reached.hessenberg
        if not reached.residual < max(tolerance, 0.1):
            return None
        if reached.iterations > self.STALE * max(1.0, -np.log10(tolerance)):
            assert self.kept is not None
            self.kept = replace(self.kept, stale=True)
        step = np.zeros_like(gap)
        step[self.places] = self._precondition(reached.solution / weight)
        return step

    def merit(self, gap: Floats) -> float:
        """Preconditioned size of a gap."""
        outside = gap * self.weight
        outside[self.places] = 0.0  # components outside P count as they are
        inside = self._precondition(gap[self.places]) * self.weight[self.places]
        return float(np.hypot(np.linalg.norm(inside), np.linalg.norm(outside)))

    def _turned(self) -> float:
        """Sign of det P M⁻¹, after a solution.

        P M⁻¹ is close to the identity: what eigenvalues have crossed zero lie apart from the
        others, and GMRES has found those to solve with them.
        """
        values = np.linalg.eigvals(self.hessenberg)
        real = np.abs(values.imag) <= 1e-8 * np.abs(values)
        return (-1.0) ** int(np.count_nonzero(real & (values.real < 0)))
