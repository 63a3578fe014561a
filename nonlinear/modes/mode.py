"""A damped nonlinear mode as a path of solutions, from small to large amplitudes and through folds.

The contacts' equations w = W(u(w)) are solved with the fundamental's amplitude a along a shape held
(`held_vibration`), and with them, ω and ξ unknown, that no force Λ holds it:

    [ P      -(dW/du) ∂u/∂(ω, ξ) ] [ dw      ]   [ (dW/du) ∂u/∂a ]
    [ ∂Λ/∂w   ∂Λ/∂(ω, ξ)         ] [ d(ω, ξ) ] = [ -∂Λ/∂a        ] da.

Each point is held along the shape of the one before, a step away in units of what a drawn curve
forgives.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.balance.held_vibration import HeldVibration
from vanelock.nonlinear.contact.law import STUCK, Deviation, Law
from vanelock.nonlinear.continuation.arc_length import polished
from vanelock.nonlinear.continuation.path import SolutionPath
from vanelock.nonlinear.fourier import TURN
from vanelock.nonlinear.newton.newton import Bordered, Solution, StepUnits, refined
from vanelock.nonlinear.newton.preconditioner import Border, response_to

_UNIT = 0.2
"""What a step of length 1 is: of ln a, of the contacts' vibration as a whole, and of the damping
ratio, 0.01 at least."""
_FASTER = 0.02  # the same of the frequency
_LONGEST = 0.1  # most that one step of Newton's iteration may change ω or ξ by, in parts of ω
_SHORTEST = 1e-5
_NEAR = 0.3  # how far a point may lie from where its tangent led, in steps
_SAME = 1e-11  # relative difference of two amplitudes that are one
_SURE = 0.95  # of the amplitude, what lies along the shape of the point before at least
_MOST = 1000  # points of a path
_BEYOND = 100.0
"""Where a mode ends, of the amplitude at which the last contact of those that may open slips."""
_FARTHEST = 1e5
"""Where it ends at the latest, of the amplitude at which the first contact slips or opens."""


@dataclass(frozen=True)
class Mode(Bordered):
    """Free vibration by amplitude, kg^½ m, along a shape held; unknown beside w: ω and ξ."""

    held: HeldVibration
    friction: Law

    @property
    def beside(self) -> Floats:
        """Ω, rad/s, and ξ, 1/s."""
        return np.array([self.held.omega, self.held.xi])

    @property
    def longest(self) -> Floats:
        """Most that a step of Newton's iteration may change them by."""
        return np.full(2, _LONGEST * self.held.omega)

    def with_beside(self, beside: Floats) -> Self:
        """The same at another ω and ξ."""
        omega, xi = beside.tolist()
        return replace(self, held=replace(self.held, omega=omega, xi=xi))

    def at(self, parameter: float) -> Balance:
        """The balance of the contacts at an amplitude."""
        return self.held.balance(parameter)

    def law(self, parameter: float) -> Law:
        """The law, the same at every amplitude."""
        return self.friction

    def rate(self, parameter: float, w: Floats, deviation: Deviation, rows: Integers) -> Floats:
        """dW/da at fixed w, on the given components of w."""
        return response_to(deviation, rows, self.held.direction)

    def left(self, parameter: float, w: Floats) -> Floats:
        """The force Λ by a ω²."""
        force = self.held.motion(parameter, w)[1] / self._size(parameter)
        return np.array([force.real, force.imag])

    def border(
        self, parameter: float, w: Floats, deviation: Deviation, rows: Integers
    ) -> tuple[Border, Floats]:
        """Derivatives of W by ω and ξ, and of Λ by w, by ω and ξ, and by a."""
        rates = self.held.rates(self.held.motion(parameter, w)[0])
        rate = np.zeros((2, w.size))
        for row, (pushed, _) in zip(rate, rates, strict=True):
            row[rows] = response_to(deviation, rows, pushed)
        changes = np.array([change for _, change in rates]) / self._size(parameter)
        by_w, by_amplitude = (each / self._size(parameter) for each in self.held.force_rates)
        normal = np.array([by_w.real, by_w.imag]).reshape(2, -1)
        corner = np.array([changes.real, changes.imag])
        return Border(rate, normal, corner), np.array([by_amplitude.real, by_amplitude.imag])

    def units(self, solution: Solution) -> StepUnits:
        """What a step is measured by at a solution."""
        omega, xi = solution.beside
        moving = max(float(np.linalg.norm(solution.u[:, :, 1:])), np.finfo(float).tiny)
        w = np.full(solution.u.shape[2], 1 / (_UNIT * moving))
        w[0] = 0.0  # friction at rest may leave sliders' mean places open
        damped = max(2 * omega * 0.01, abs(xi))
        beside = np.array([1 / (_FASTER * omega), 1 / (_UNIT * damped)])
        return StepUnits(w, 1 / (_UNIT * solution.parameter), beside)

    def carried(self, solution: Solution) -> tuple["Mode", Solution]:
        """Held along the shape of a solution itself, which takes no force either."""
        point = ModePoint(self, solution)
        held = replace(point.held, shape=point.shape)
        return replace(self, held=held), replace(solution, parameter=point.amplitude)

    def holds(self, solution: Solution) -> bool:
        """Whether most of a solution lies along the shape held."""
        return _SURE * ModePoint(self, solution).amplitude < solution.parameter

    def _size(self, amplitude: float) -> float:
        """A ω²."""
        return abs(amplitude) * self.held.omega**2


@dataclass(frozen=True)
class ModePoint:
    """A point of a mode: a solution of its problems, `mode` those at any ω and ξ."""

    mode: Mode
    solution: Solution

    @cached_property
    def held(self) -> HeldVibration:
        """The structure at its ω and ξ."""
        return self.mode.with_beside(np.array(self.solution.beside)).held

    @cached_property
    def amplitudes(self) -> list[Array]:
        """Modal amplitudes (n_h,) of the harmonics 0 to H."""
        return self.held.motion(self.solution.parameter, self.solution.w)[0]

    @property
    def omega(self) -> float:
        """ω, rad/s."""
        return self.held.omega

    @property
    def damping_ratio(self) -> float:
        """D = ξ/(2ω)."""
        return self.held.xi / (2 * self.held.omega)

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

    @property
    def left(self) -> float:
        """|Λ|/(a ω²), what is left of the fundamental's equation of motion."""
        mode = replace(self.mode, held=self.held)
        return float(np.hypot(*mode.left(self.solution.parameter, self.solution.w)))


@dataclass
class ModePath:
    """Points of a mode, one after another, from the first one, `begun`.

    `tolerance`: relative residual that counts as converged; `floor`: amplitude below which no
    contact slips or opens in the mode, kg^½ m: a path that turns back to less has left it; `count`:
    points found; `arrived`: whether the amplitude that it went to last was reached; `highest`:
    largest amplitude so far, kg^½ m.
    """

    begun: ModePoint
    tolerance: float
    floor: float = 0.0
    count: int = 0
    arrived: bool = False
    highest: float = 0.0
    last: ModePoint = field(init=False)

    def __post_init__(self) -> None:
        """Begin."""
        self.last, first = self.begun, self.begun.solution
        mode, end = self.begun.mode, 2 * first.parameter
        self._path = SolutionPath(mode, first, end, longest=1.0, shortest=_SHORTEST, near=_NEAR)

    @property
    def failed(self) -> int:
        """Steps that failed."""
        return self._path.failed

    def onward(self, end: float) -> Iterator[ModePoint]:
        """Points until an amplitude, kg^½ m, is passed, which the last one has exactly.

        It ends before where the path is lost.
        """
        path = self._path
        self.arrived = abs(self.last.amplitude / end - 1) < _SAME
        while not (self.arrived or self._stops or path.here is None):
            ahead = path.ahead()
            if ahead is None:
                return
            point = _point(path, ahead)
            if point.amplitude < end:
                path.go(ahead)
                if path.here is None:
                    return
                point = _point(path, polished(path.family, path.here, self.tolerance))
            elif (landed := self._landed(point, end)) is not None:
                point, self.arrived, path.family = landed, True, landed.mode
                path.go(landed.solution, stepped=False)
            else:
                path.failed += 1
                path.length = 0.5 * path.taken
                if path.length < _SHORTEST:
                    return
                continue
            self.last, self.count = point, self.count + 1
            self.highest = max(self.highest, point.amplitude)
            yield point

    @property
    def _stops(self) -> str:
        """Why it goes no further though it could; empty where it may."""
        if self.count >= _MOST:
            return f"{_MOST} points are the most"
        if self.last.amplitude < min(self.floor, self.highest):
            return "it has turned back to where nothing slips in the mode: it is another one's"
        return ""

    @property
    def where(self) -> str:
        """Where the path is and why it ends there, in words."""
        last, why = self.last, self._stops or "no next point was found"
        return f"at the modal amplitude {last.amplitude:g}, {last.omega / TURN:g} Hz: {why}"

    def _landed(self, ahead: ModePoint, end: float) -> ModePoint | None:
        """The point at an amplitude, between the last one and the one ahead."""
        for near in (ahead, self.last):
            found = _exact(near, end, self.tolerance)
            if found is not None:
                low, high = sorted((self.last.omega, ahead.omega))
                margin = 0.5 * (high - low) + 1e-6 * high
                if low - margin <= found.omega <= high + margin:
                    return found
        return None

    def through(
        self, amplitudes: Floats | None, is_range: bool, onset: float
    ) -> Iterator[ModePoint]:
        """Points that are asked for, as the path passes them; it may end before the last one."""
        if amplitudes is None:
            yield self.last
            contacts, farthest = self.begun.held.structure.system.contacts, _FARTHEST * onset
            may = contacts.opens & (contacts.mu > 0)
            for point in self.onward(farthest):
                yield point
                # Well beyond where the last contact of those that may slip does.
                if not np.any(point.solution.deviation.state[may] == STUCK):
                    yield from self.onward(min(_BEYOND * point.amplitude, farthest))
                    return
            return
        for i, amplitude in enumerate(amplitudes.tolist()):
            if is_range and i:
                yield from self.onward(amplitude)
                return
            for _ in self.onward(amplitude):
                pass
            if not self.arrived:
                return
            yield self.last


def _point(path: SolutionPath, solution: Solution) -> ModePoint:
    """A solution as a point of the mode that a path is of."""
    assert isinstance(path.family, Mode)
    return ModePoint(path.family, solution)


def _exact(point: ModePoint, amplitude: float, tolerance: float) -> ModePoint | None:
    """The point at exactly a modal amplitude, near one that was held along another shape."""
    for _ in range(6):
        if abs(point.amplitude / amplitude - 1) < 1e-12:
            return point
        w = point.solution.w.copy()
        w[:, :, 1:] *= amplitude / point.amplitude
        mode = replace(point.mode, held=replace(point.held, shape=point.shape))
        found = refined(mode, w, amplitude, tolerance=tolerance, reuse=point.solution.reuse)
        if not found.converged:
            return None
        point = ModePoint(mode, found)
    return None
