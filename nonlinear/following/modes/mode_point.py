"""One point of a damped nonlinear mode: motion, frequency and self-excitation at an amplitude.

The contacts' equations w = W(u(w)) are solved at given ω and ξ, the fundamental's amplitude a along
a shape held (`held_vibration`), or a free on a plane n·(w, a) = const across the path of points,
which passes where amplitudes turn back. The force Λ(ω, ξ) that holds it is then brought to zero by
Newton's method on two real equations, with

    dΛ = ∂Λ + (∂Λ/∂w) dw + (∂Λ/∂a) da,      [ P  -(dW/du) ∂u/∂a ] [ dw ]   [ (dW/du) ∂u ]
                                            [ n_w      n_a      ] [ da ] = [     0      ].
"""

from dataclasses import dataclass, replace

import numpy as np

from vanelock.nonlinear.balance.balance import Structure
from vanelock.nonlinear.balance.held_vibration import Array, Floats, HeldVibration
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.continuation.families import Loads
from vanelock.nonlinear.newton.law_jacobian import response_to
from vanelock.nonlinear.newton.linearised import Border, Linearised, linearise
from vanelock.nonlinear.newton.newton import CuttingPlane, Solution, active_rows, scales, solve
from vanelock.nonlinear.newton.preconditioner import Kept

FINE = 1e-13
"""Residual of contacts and of free vibration that a solution should have where rounding lets it."""
EXACT = 1e-9
"""Of derivatives where P is large and solved by iteration."""
LIMIT = 12
LONGEST = 0.1
"""Most that one step may change ω or ξ by, in parts of ω."""


@dataclass(frozen=True)
class ModePoint:
    """A point of a mode.

    Attributes
    ----------
    held : HeldVibration
        The structure at its ω and ξ.
    solution : Solution
        The contacts' equations, solved; its parameter is the amplitude that was held.
    amplitudes : list of (n_h,)
        Modal amplitudes of the harmonics 0 to H.
    left : float
        |Λ|/(a ω²), what is left of the fundamental's equation of motion.
    steps : int
        Pairs (ω, ξ) that were tried.
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
    def damping_ratio(self) -> float:
        """D = ξ/(2ω)."""
        return self.xi / (2 * self.omega)

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

    def along_own(self) -> "ModePoint":
        """The same point, held along its own shape, which takes no force either."""
        solution = replace(self.solution, parameter=self.amplitude)
        return replace(self, held=replace(self.held, shape=self.shape), solution=solution)


@dataclass(frozen=True)
class Change:
    """A change of what is solved for.

    Attributes
    ----------
    w : (c, 3, 2H + 1) float
    amplitude, omega, xi : float
    """

    w: Floats
    amplitude: float
    omega: float = 0.0
    xi: float = 0.0

    def __add__(self, other: "Change") -> "Change":
        return Change(
            self.w + other.w,
            self.amplitude + other.amplitude,
            self.omega + other.omega,
            self.xi + other.xi,
        )

    def __mul__(self, factor: float) -> "Change":
        return Change(
            factor * self.w, factor * self.amplitude, factor * self.omega, factor * self.xi
        )


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
    everywhere : bool
        Whether harmonics h > 1 are excited by themselves, too.
    """

    structure: Structure
    friction: Law
    tolerance: float
    mean: Floats | None = None
    everywhere: bool = True

    def held(self, shape: Array, omega: float, xi: float) -> HeldVibration:
        """The structure at ω and ξ, held along a shape VᴴMφ."""
        return HeldVibration(self.structure, shape, omega, xi, self.mean, self.everywhere)

    def family(self, held: HeldVibration) -> Loads:
        """The contacts' problems by amplitude."""
        return Loads(held.still, held.direction, self.friction)

    def given(self, amplitude: float) -> CuttingPlane:
        """The plane of an amplitude that is given."""
        contacts, m = self.structure.system.contacts.count, 2 * self.structure.harmonics + 1
        none = np.zeros((contacts, 3, m))
        return CuttingPlane(none, amplitude, none, 1 / amplitude)

    def point(
        self, held: HeldVibration, w: Floats, plane: CuttingPlane, kept: Kept | None = None
    ) -> ModePoint | None:
        """The free vibration on a plane, near a first guess; None if it is not found."""
        amplitude, best = plane.parameter, None
        for steps in range(1, LIMIT + 1):
            found = self._contacts(held, w, amplitude, plane, kept)
            if found is None:
                return best
            amplitude = found.parameter
            amplitudes, force = held.motion(amplitude, found.w)
            here = ModePoint(
                held, found, amplitudes, abs(force) / (amplitude * held.omega**2), steps
            )
            if best is not None and here.left >= best.left:
                return replace(best, steps=steps)  # rounding is reached
            if here.left < self.tolerance:
                best = here
            if here.left < FINE:
                return best
            step = self._step(here, plane, force)
            if step is None:
                return best
            kept, w, amplitude = found.kept, found.w + step.w, amplitude + step.amplitude
            held = replace(held, omega=held.omega + step.omega, xi=held.xi + step.xi)
        return best

    def _contacts(
        self,
        held: HeldVibration,
        w: Floats,
        amplitude: float,
        plane: CuttingPlane,
        kept: Kept | None,
    ) -> Solution | None:
        """The contacts' equations, solved better than to the tolerance where that is possible."""
        family = self.family(held)
        found = solve(family, w, amplitude, plane, self.tolerance, kept=kept)
        if not (found.converged and found.parameter > 0):
            return None
        if found.residual > FINE:
            again = solve(family, found.w, found.parameter, plane, FINE, 1, found.kept)
            if again.residual < found.residual:
                spent = found.iterations + again.iterations
                found = replace(again, converged=True, iterations=spent)
        return found

    def _step(self, here: ModePoint, plane: CuttingPlane, force: complex) -> Change | None:
        """Newton's step to where Λ vanishes, on the plane; None where there is none."""
        ways = self.ways(here, plane)
        if ways is None:
            return None
        (by_omega, by_xi), slopes = ways[:2], self._slopes(here, ways)
        step = _solved(slopes[:2], force)
        if step is None:
            return None
        longest = float(np.abs(step).max()) / (LONGEST * here.omega)
        shorter = 1 / max(1.0, longest)
        return by_omega * (shorter * float(step[0])) + by_xi * (shorter * float(step[1]))

    def tangent(self, here: ModePoint, plane: CuttingPlane) -> tuple[Change, float] | None:
        """Direction of the path, by 1 along the plane's normal, and the sign of the determinant.

        The determinant is that of all equations' derivatives, the normal as last row.
        """
        ways = self.ways(here, plane)
        if ways is None:
            return None
        slopes = self._slopes(here, ways)
        step = _solved(slopes[:2], slopes[2])
        if step is None:
            return None
        way = ways[2] + ways[0] * float(step[0]) + ways[1] * float(step[1])
        sign = np.sign(slopes[0].real * slopes[1].imag - slopes[1].real * slopes[0].imag)
        return way, float(sign) * self._orientation(here, plane)

    def _slopes(self, here: ModePoint, ways: list[Change]) -> list[complex]:
        """How Λ changes on each way."""
        changes = [change for _, change in here.held.rates(here.amplitudes)]
        by_w = [here.held.force(way.amplitude, way.w) for way in ways]
        return [direct + moved for direct, moved in zip([*changes, 0j], by_w, strict=True)]

    def ways(self, here: ModePoint, plane: CuttingPlane) -> list[Change] | None:
        """How w and a move by ω, by ξ, both on the plane, and by 1 along its normal."""
        found, held = here.solution, here.held
        size, rows = found.w.size, active_rows(found.w, found.deviation)
        pushed = [moved for moved, _ in held.rates(here.amplitudes)]
        rights = np.zeros((3, size + 1))
        rights[2, -1] = 1.0
        if not len(rows):
            moved = rights.copy()
            moved[2, -1] = 1 / plane.normal_parameter
        else:
            for right, each in zip(rights, pushed, strict=False):
                right[rows] = response_to(found.deviation, rows, each)
            rate = np.zeros(size)
            rate[rows] = response_to(found.deviation, rows, held.direction)
            border = Border(rate, plane.normal_w.reshape(-1), plane.normal_parameter)
            linear = self._linearised(here, border)
            solved = [linear.solve(right, EXACT) for right in rights]
            if any(each is None for each in solved):
                return None
            moved = np.array(solved)
        return [
            Change(each[:-1].reshape(found.w.shape), float(each[-1]), *by)
            for each, by in zip(moved, ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0)), strict=True)
        ]

    def _linearised(self, here: ModePoint, border: Border | None) -> Linearised:
        """P, bordered or not, ready to be solved."""
        found, balance = here.solution, here.held.balance(here.solution.parameter)
        rows = active_rows(found.w, found.deviation)
        weight = np.broadcast_to(1 / scales(balance.linear), found.w.shape).reshape(-1)
        if border is not None:
            weight = np.append(weight, 1.0)
        kept = None if found.kept is None else replace(found.kept, stale=True)
        stiffness = self.friction.stiffness.reshape(-1)
        return linearise(balance, found.deviation, rows, weight, border, kept, stiffness)

    def _orientation(self, here: ModePoint, plane: CuttingPlane) -> float:
        """Sign of det [P, -dW/da; n]."""
        found = here.solution
        rows = active_rows(found.w, found.deviation)
        along, sign = plane.normal_parameter, 1.0
        if len(rows):
            linear, right = self._linearised(here, None), np.zeros(found.w.size)
            right[rows] = response_to(found.deviation, rows, here.held.direction)
            moved = linear.solve(right, EXACT)
            if moved is not None:
                along += float(plane.normal_w.reshape(-1) @ moved)
            sign = linear.orientation()
        return sign * float(np.sign(along))


def _solved(slopes: list[complex], force: complex) -> Floats | None:
    """(ω, ξ) by which Λ changes from a value to zero."""
    matrix = np.array([[each.real for each in slopes], [each.imag for each in slopes]])
    try:
        return np.asarray(np.linalg.solve(matrix, [-force.real, -force.imag]))
    except np.linalg.LinAlgError:
        return None


def exact(solver: ModeSolver, point: ModePoint, amplitude: float) -> ModePoint | None:
    """The point at exactly a modal amplitude, near one that was held along another shape."""
    for _ in range(6):
        if abs(point.amplitude / amplitude - 1) < 1e-12:
            return point
        w = point.solution.w.copy()
        w[:, :, 1:] *= amplitude / point.amplitude
        held = replace(point.held, shape=point.shape)
        following = solver.point(held, w, solver.given(amplitude), point.solution.kept)
        if following is None:
            return None
        point = following
    return None
