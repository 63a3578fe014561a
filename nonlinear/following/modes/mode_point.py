"""One point of a damped nonlinear mode: motion, frequency and self-excitation at an amplitude.

The contacts' equations w = W(u(w)) are solved at given ω and ξ, the fundamental's amplitude along a
shape held (`held_vibration`). The force Λ(ω, ξ) that this takes is then brought to zero by Newton's
method, two real equations for ω and ξ, with

    dΛ/dω = ∂Λ/∂ω + (∂Λ/∂w) dw/dω,      P dw/dω = (dW/du) ∂u/∂ω,

and the same for ξ.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.balance import Structure
from vanelock.nonlinear.balance.held_vibration import Array, Floats, HeldVibration
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.continuation.arc_length import tangent_at
from vanelock.nonlinear.continuation.families import Loads, fixed
from vanelock.nonlinear.newton.newton import Solution, solve
from vanelock.nonlinear.newton.preconditioner import Kept

FINE = 1e-13
"""Residual of contacts and of free vibration that a solution should have where rounding lets it."""
LIMIT = 12
LONGEST = 0.1
"""Of ω: most that one step may change ω or ξ by."""


@dataclass(frozen=True)
class ModePoint:
    """A point of a mode.

    Attributes
    ----------
    held : HeldVibration
        The structure at its ω and ξ.
    solution : Solution
        The contacts' equations, solved.
    amplitudes : list of (n_h,)
        Modal amplitudes of the harmonics 0 to H.
    left : float
        |Λ|/(a ω²), what is left of the fundamental's equation of motion.
    steps : int
        Pairs of ω and ξ that were tried.
    """

    held: HeldVibration
    solution: Solution
    amplitudes: list[Array]
    left: float
    steps: int

    @property
    def omega(self) -> float:
        """ω, rad/s."""
        return self.held.omega

    @property
    def xi(self) -> float:
        """ξ, 1/s."""
        return self.held.xi

    @property
    def amplitude(self) -> float:
        """Modal amplitude (q₁ᴴ M q₁)^½, kg^½ m."""
        compliance = self.held.structure.at(1).compliance
        return float(np.sqrt((compliance * np.abs(self.amplitudes[1]) ** 2).sum()))

    @property
    def shape(self) -> Array:
        """VᴴMφ of its own shape φ, phase and all."""
        compliance = self.held.structure.at(1).compliance
        return np.asarray(compliance * self.amplitudes[1] / self.amplitude)


@dataclass(frozen=True)
class ModeSolver:
    """What solves one point after another.

    Attributes
    ----------
    structure : Structure
        Of which only the static force acts.
    friction : Law
    tolerance : float
        Relative residual that counts as converged, of contacts and of free vibration.
    mean : (c, 3) float, optional
        Mean displacement that is held whatever the contacts do, m.
    """

    structure: Structure
    friction: Law
    tolerance: float
    mean: Floats | None = None

    def held(self, shape: Array, amplitude: float, omega: float, xi: float) -> HeldVibration:
        """The structure at ω and ξ, held along a shape VᴴMφ at an amplitude."""
        return HeldVibration(self.structure, shape, amplitude, omega, xi, self.mean)

    def point(self, held: HeldVibration, w: Floats, kept: Kept | None = None) -> ModePoint | None:
        """The free vibration near a first guess of (ω, ξ) and w; None where it is not found."""
        best: ModePoint | None = None
        for steps in range(1, LIMIT + 1):
            found = self._contacts(held, w, kept)
            if found is None:
                return best
            amplitudes, force = held.motion(found.w)
            left = abs(force) / (held.amplitude * held.omega**2)
            if best is not None and left >= best.left:
                return replace(best, steps=steps)  # rounding is reached
            if left < self.tolerance:
                best = ModePoint(held, found, amplitudes, left, steps)
            if left < FINE:
                return best
            moved = self._step(held, found, amplitudes, force)
            if moved is None:
                return best
            kept, (held, w) = found.kept, moved
            if not held.omega > 0:
                return best
        return best

    def _contacts(self, held: HeldVibration, w: Floats, kept: Kept | None) -> Solution | None:
        """The contacts' equations at (ω, ξ), better than to the tolerance where that is possible."""
        problem = fixed(held.balance, self.friction)
        found = solve(problem, w, 0.0, tolerance=self.tolerance, kept=kept)
        if not found.converged:
            return None
        if found.residual > FINE:
            again = solve(problem, found.w, 0.0, None, FINE, 1, found.kept)
            if again.residual < found.residual:
                spent = found.iterations + again.iterations
                found = replace(again, converged=True, iterations=spent)
        return found

    def _step(
        self, held: HeldVibration, found: Solution, amplitudes: list[Array], force: complex
    ) -> tuple[HeldVibration, Floats] | None:
        """Newton's step of (ω, ξ), and w there to first order."""
        matrix, ways = np.empty((2, 2)), []
        for column, (pushed, change) in enumerate(held.rates(amplitudes)):
            family = Loads(held.balance, pushed, self.friction)
            tangent = tangent_at(family, replace(found, parameter=0.0))
            if tangent is None:
                return None
            total = change + held.moved(tangent.z)
            matrix[:, column] = total.real, total.imag
            ways.append(tangent.z)
        try:
            by_omega, by_xi = np.linalg.solve(matrix, [-force.real, -force.imag])
        except np.linalg.LinAlgError:
            return None
        longest = max(abs(by_omega), abs(by_xi)) / (LONGEST * held.omega)
        by_omega, by_xi = (float(each / max(longest, 1.0)) for each in (by_omega, by_xi))
        w = found.w + by_omega * ways[0] + by_xi * ways[1]
        return held.at(held.omega + by_omega, held.xi + by_xi), w


def exact(solver: ModeSolver, point: ModePoint, amplitude: float) -> ModePoint | None:
    """The point at exactly a modal amplitude, near one that was held along another shape."""
    for _ in range(6):
        if abs(point.amplitude / amplitude - 1) < FINE ** (2 / 3):
            return point
        held = solver.held(point.shape, amplitude, point.omega, point.xi)
        scale = amplitude / point.amplitude
        w: NDArray[np.float64] = point.solution.w.copy()
        w[:, :, 1:] *= scale
        following = solver.point(held, w, point.solution.kept)
        if following is None:
            return None
        point = following
    return None
