"""A mode followed from small to large amplitudes, through folds where amplitudes turn back.

Each point is held along the shape of the one before, and looked for on a plane across the path, a
step away in units of what a drawn curve forgives. The direction of the path follows from the sign
of the determinant of all equations' derivatives, the path's own tangent as the last row: it is
constant along the path, through folds and across the kinks of the law. A step that fails is made
shorter; where even the shortest fails, a contact changes its state right there, and the path goes
on as the other state has it, or, where that has no derivative, as the law itself does.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from vanelock.nonlinear.balance.held_vibration import Floats
from vanelock.nonlinear.following.modes.mode_point import Change, ModePoint, ModeSolver, exact
from vanelock.nonlinear.fourier.trigonometric import TURN
from vanelock.nonlinear.newton.newton import CuttingPlane

UNIT = 0.2
"""What a step of length 1 is: of ln a, of the contacts' vibration as a whole, and of the damping
ratio by its largest."""
FASTER = 0.02
"""The same of the frequency."""
SHORTEST = 1e-5
SAME = 1e-11
"""Relative difference of two amplitudes that are one."""
SURE = 0.95
"""Of the amplitude, what lies along the shape of the point before at least."""
NEAR = 0.3
"""How far a point may lie from where its tangent led, in steps."""
EASY = 4
"""Pairs (ω, ξ) tried for a point up to which the next step is longer."""
ACROSS = 1e-3
"""Of the amplitude: how far beyond an onset that has no tangent a point is looked for ..."""
ROUNDS = 60
"""... after so many rounds of the law, half a step each."""
MOST = 1000
"""Points of a path."""


@dataclass(frozen=True)
class StepUnits:
    """Inverse of what counts as a step of length 1; of w by harmonic, (2H + 1,)."""

    w: Floats
    amplitude: float
    omega: float
    xi: float

    def length(self, change: Change) -> float:
        """Length of a change."""
        parts = (
            float(np.linalg.norm(change.w * self.w)),
            change.amplitude * self.amplitude,
            change.omega * self.omega,
            change.xi * self.xi,
        )
        return float(np.linalg.norm(parts))

    def plane(self, w: Floats, amplitude: float, change: Change) -> CuttingPlane:
        """The plane through (w, a) across a change of length 1."""
        return CuttingPlane(
            w, amplitude, change.w * self.w**2, change.amplitude * self.amplitude**2
        )


@dataclass
class ModePath:
    """Points of a mode, one after another.

    Attributes
    ----------
    solver : ModeSolver
    last : ModePoint
        Where the path is.
    floor : float
        Amplitude below which no contact slips or opens in the mode, kg^½ m: a path that turns back
        to less has left it.
    length : float
        Of the next step.
    failed : int
        Steps that failed.
    damped : float
        Largest damping ratio so far, 0.01 at least.
    count : int
        Points found.
    arrived : bool
        Whether the amplitude that it went to last was reached.
    highest : float
        Largest amplitude so far, kg^½ m.
    """

    solver: ModeSolver
    last: ModePoint
    floor: float = 0.0
    length: float = 1.0
    failed: int = 0
    damped: float = 0.01
    count: int = 0
    arrived: bool = False
    highest: float = 0.0
    _sign: float = field(default=0.0, repr=False)
    _before: Change | None = field(default=None, repr=False)

    def onward(self, end: float) -> Iterator[ModePoint]:
        """Points until an amplitude, kg^½ m, is passed, which the last one has exactly.

        It ends before where the path is lost.
        """
        self.arrived = abs(self.last.amplitude / end - 1) < SAME
        while not self.arrived and not self._stops:
            ahead = self._ahead()
            if ahead is None:
                return
            if ahead.amplitude >= end:
                landed = self._landed(ahead, end)
                if landed is None:
                    self.failed += 1
                    self.length *= 0.5
                    if self.length < SHORTEST:
                        return
                    continue
                ahead, self.arrived = landed, True
            self.last, self.count = ahead, self.count + 1
            self.highest = max(self.highest, ahead.amplitude)
            yield ahead

    @property
    def _stops(self) -> str:
        """Why it goes no further though it could; empty where it may."""
        if self.count >= MOST:
            return f"{MOST} points are the most"
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
            found = exact(self.solver, near, end)
            if found is not None:
                low, high = sorted((self.last.omega, ahead.omega))
                margin = 0.5 * (high - low) + 1e-6 * high
                if low - margin <= found.omega <= high + margin:
                    return found
        return None

    def _ahead(self) -> ModePoint | None:
        """The next point, its step made shorter until it is found."""
        here = self.last.along_own()
        units = self._units(here)
        tangent = self._tangent(here, units)
        if tangent is None:
            return None
        while self.length >= SHORTEST:
            found = self._step(here, tangent, units, self.length)
            if found is not None:
                self._before = tangent
                self.length *= float(np.clip((EASY / found.steps) ** 2, 0.5, 2.0))
                self.length = min(self.length, 1.0)
                return found
            self.failed += 1
            self.length *= 0.5
        for push in (2.0, 8.0, 32.0):
            turned = self._beyond(here, tangent * (push * SHORTEST), units)
            if turned is None:
                continue
            for longer in (1, 4, 16, 64):
                length = longer * push * SHORTEST
                found = self._step(here, turned, units, length)
                if found is not None:
                    self._before, self.length = turned, length
                    return found
                self.failed += 1
        return self._across(here, units)

    def _across(self, here: ModePoint, units: StepUnits) -> ModePoint | None:
        """The point a little beyond an amplitude at which sliders begin to move all the way round.

        On a circle |w| grows there as a root, to which no derivative leads, but the law itself.
        """
        amplitude, w = (1 + ACROSS) * here.amplitude, here.solution.w
        balance = here.held.balance(amplitude)
        for _ in range(ROUNDS):
            w = 0.5 * (w + self.solver.friction(balance.displacement(w), here.omega).w)
        plane = self.solver.given(amplitude)
        found = self.solver.point(here.held, w, plane, here.solution.kept)
        if found is None:
            return None
        moved, aside = found.solution.w - here.solution.w, found.omega - here.omega
        change = Change(moved, found.amplitude - here.amplitude, aside)
        self.length = units.length(change)
        self._before = change * (1 / self.length)
        return found if self.length < 1.0 else None

    def _units(self, here: ModePoint) -> StepUnits:
        """What a step is measured by at a point."""
        self.damped = max(self.damped, abs(here.damping_ratio))
        u = here.solution.u
        moving = max(float(np.linalg.norm(u[:, :, 1:])), np.finfo(float).tiny)
        w = np.full(u.shape[2], 1 / (UNIT * moving))
        w[0] = 0.0  # friction at rest may leave sliders' mean places open
        return StepUnits(
            w=w,
            amplitude=1 / (UNIT * here.amplitude),
            omega=1 / (FASTER * here.omega),
            xi=1 / (2 * here.omega * UNIT * self.damped),
        )

    def _tangent(self, here: ModePoint, units: StepUnits) -> Change | None:
        """Direction of the path at a point, of length 1."""
        before = self._before
        if before is None:
            plane = self.solver.given(here.amplitude)
        else:
            before = before * (1 / units.length(replace(before, omega=0.0, xi=0.0)))
            plane = units.plane(here.solution.w, here.amplitude, before)
        found = self.solver.tangent(here, plane)
        if found is None:
            return None
        tangent, sign = found
        self._sign = self._sign or sign
        return tangent * (self._sign * sign / units.length(tangent))

    def _beyond(self, here: ModePoint, change: Change, units: StepUnits) -> Change | None:
        """Direction of the path as the state of the contacts a little further has it."""
        w, amplitude = here.solution.w + change.w, here.amplitude + change.amplitude
        held = replace(here.held, omega=here.omega + change.omega, xi=here.xi + change.xi)
        u = held.balance(amplitude).displacement(w)
        solution = replace(
            here.solution,
            w=w,
            u=u,
            parameter=amplitude,
            deviation=self.solver.friction(u, held.omega),
        )
        amplitudes = held.motion(amplitude, w)[0]
        further = replace(here, held=held, solution=solution, amplitudes=amplitudes)
        return self._tangent(further, units)

    def _step(
        self, here: ModePoint, tangent: Change, units: StepUnits, length: float
    ) -> ModePoint | None:
        """The point a step away, if one is found near there."""
        way = tangent * length
        start, amplitude = here.solution.w + way.w, here.amplitude + way.amplitude
        omega, xi = here.omega + way.omega, here.xi + way.xi
        if not (omega > 0 and amplitude > 0):
            return None
        held = replace(here.held, omega=omega, xi=xi)
        plane = units.plane(start, amplitude, tangent)
        found = self.solver.point(held, start, plane, here.solution.kept)
        if found is None:
            return None
        aside = Change(
            found.solution.w - start,
            found.solution.parameter - amplitude,
            found.omega - omega,
            found.xi - xi,
        )
        sure = found.amplitude * SURE < found.solution.parameter
        return found if sure and units.length(aside) < NEAR * length else None
