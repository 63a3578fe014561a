"""Over-resolved peaks of the scenes: more modes and harmonics until nothing changes.

The response of a fine reduced model is swept over the study's range with `SWEPT` harmonics, upwards
and downwards. Each high maximum of a sweep is then located exactly
(`nonlinear.peaks.peak`) with more and more harmonics, each from the last one, until the
amplitude no longer changes; the highest in the end is the peak. A study sweeps upwards, so that
this is the peak asked for; what a downward sweep finds beside it counts too, or Newton's iteration
from many disturbed starts where a branch is known to be (`BESIDE`).
"""

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.models import Prepared
from benchmarks.accuracy.scenes import Scene
from vanelock.nonlinear.balance.balance import Structure, structure
from vanelock.nonlinear.balance.receptance_tables import balances
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.families import Frequencies, fixed
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver
from vanelock.nonlinear.forced_response.options import _at_rest
from vanelock.nonlinear.fourier import TURN, resized
from vanelock.nonlinear.newton.newton import TOLERANCE, Solution, solve
from vanelock.nonlinear.peaks.peak import Resonance

Floats = NDArray[np.float64]

ACCURACY = 1e-4
"""Of the reduced model, a bound that its errors stay far below."""
SWEPT = 5
LADDER = (5, 9, 14, 20, 27, 38, 53)
ISOTROPIC = (5, 9, 14, 20)
"""Harmonics tried one after another; under isotropic friction, which takes many times as long."""
SETTLED = 1e-4
"""Relative change of amplitude, per step of the ladder, that ends it from the third step on."""
HIGH = 0.85
"""Maxima of a sweep below this share of its highest are not followed."""
JUMP = 0.25
"""Relative change of the amplitude between two neighbours that takes a fold."""
NEAR = 0.03
"""Of the frequency to either side: the range of the tables around a peak."""
BESIDE = {21: 309.0}
"""Hz, by scene: where a run by accuracy found a branch that neither sweep meets."""
DISTURBED, STARTS, STEPS, LEAP = 9, 40, 400, 0.03
"""Harmonics with which it is looked for, from how many starts, the most steps to either side, and
the relative change of amplitude in one that leaves the branch."""
SAME = 1e-4
"""Relative difference of two maxima below which the sweeps up and down found the same one."""


@dataclass(frozen=True)
class Top:
    """A peak and how sure it is.

    Attributes
    ----------
    amplitude, frequency : float
        m, Hz.
    edge : bool
        At an end of the range, not a maximum in itself.
    harmonics : int
    changes : list of (int, float, float)
        Harmonics, amplitude, frequency of each step.
    located : bool
        Whether the last step was located to the maximum itself.
    state : dict
        Share of the contacts of each joint that slip and that open.
    """

    amplitude: float
    frequency: float
    edge: bool
    harmonics: int
    changes: list[tuple[int, float, float]]
    located: bool
    state: dict[str, tuple[float, float]]

    @property
    def doubt(self) -> float:
        """Relative change of amplitude by the last step."""
        if len(self.changes) < 2:
            return float("inf")
        (_, a, _), (_, b, _) = self.changes[-2:]
        return abs(b / a - 1)


class Reference:
    """What finds the peaks of a scene.

    Parameters
    ----------
    scene : Scene
    given : Prepared
        Of a fine reduced model.
    settled : float
        Relative change of the amplitude, per step of the ladder, that ends it.
    """

    def __init__(self, scene: Scene, given: Prepared, settled: float = SETTLED) -> None:
        self.scene, self.given, self.settled = scene, given, settled
        study = scene.study()
        self.coupling, self.friction = study.response.coupling, study.response.friction
        self.jumped = False
        self.ladder = ISOTROPIC if self.friction == "isotropic" else LADDER
        self.full = structure(given.system, max(self.ladder))
        self.component = given.monitor.node, given.monitor.component
        self.mean = None
        if self.coupling != "coupled":
            rest = _at_rest(self.full, lambda h: self._law(h, False))
            self.mean = rest.u[:, :, 0]

    def _law(self, harmonics: int, constant: bool) -> Any:
        contacts = self.given.system.contacts
        return contact_law(contacts, harmonics, None, self.friction, constant)

    def prepared(self, harmonics: int) -> Structure:
        """The structure with fewer harmonics."""
        diameters = self.full.nodal_diameters[: harmonics + 1]
        return replace(self.full, harmonics=harmonics, nodal_diameters=diameters)

    def solver(self, harmonics: int, low: float, high: float) -> PointSolver:
        """What solves between two circular frequencies."""
        source = balances(self.prepared(harmonics), low, high, 1000)
        constant = self.coupling == "constant-load"
        family = Frequencies(source, self._law(harmonics, constant), self.mean)
        return PointSolver(family, lambda h: self._law(h, constant), TOLERANCE)

    def amplitude(self, solver: PointSolver, solution: Solution) -> float:
        """Of the monitored output, m."""
        shape = (-1, 3)
        return float(solver.amplitude(solution).reshape(shape)[self.component])

    def sweep(self, up: bool) -> tuple[PointSolver, list[Solution]]:
        """Converged solutions over the range, ascending in frequency, and their number lost."""
        low, high = (TURN * f for f in self.given.range)
        solver = self.solver(SWEPT, low, high)
        explored = list(solver.explore(*((low, high) if up else (high, low))))
        found = [each for each in explored if each.converged]
        return solver, sorted(found, key=lambda each: each.omega)

    def tops(self, up: bool, known: list[Top] | None = None) -> list[Top]:
        """The highest peaks of a sweep, each followed to many harmonics, the highest first.

        Nothing is followed where the sweep's highest point is `known` from another sweep.
        """
        solver, found = self.sweep(up)
        size = np.array([self.amplitude(solver, each) for each in found])
        self.jumped |= bool(np.any(abs(np.diff(size)) > JUMP * size[1:]))
        if any(abs(top.changes[0][1] / size.max() - 1) < 10 * SAME for top in known or []):
            return []
        inner = (size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])
        places = [int(i) + 1 for i in np.flatnonzero(inner) if size[i + 1] > HIGH * size.max()]
        places = sorted(places, key=lambda i: -size[i])[:3]
        tops = [self.followed(found, size, i) for i in places]
        for end in (0, len(found) - 1):
            if size[end] > HIGH * size.max() and size[end] >= size[[1, -2]].min():
                tops.append(self.at_end(found[end]))
        return sorted(tops, key=lambda each: -each.amplitude)

    def beside(self, hertz: float) -> Top | None:
        """The peak of the highest branch that disturbed starts at a frequency lead to."""
        omega, random = TURN * hertz, np.random.default_rng(0)
        solver = self.solver(DISTURBED, (1 - NEAR) * omega, (1 + NEAR) * omega)
        base = solver.point(omega, [])
        held = fixed(solver.family.at(omega), solver.family.friction)
        contacts = (len(base.w), 1, 1)
        tried = [solve(held, base.w * random.normal(1, 1, contacts), 0.0) for _ in range(STARTS)]
        solved = [replace(each, parameter=omega) for each in (base, *tried) if each.converged]
        start = max(solved, key=lambda each: self.amplitude(solver, each))
        branch = [start]
        for sign in (1, -1):  # as far as Newton's iteration stays on a curve
            history = [start]
            for k in range(1, STEPS):
                at = omega * (1 + sign * k * NEAR / STEPS)
                point = solver.easily(at, history)
                sizes = [self.amplitude(solver, each) for each in (history[-1], point or start)]
                if point is None or abs(sizes[1] / sizes[0] - 1) > LEAP:
                    break
                branch.append(point)
                history = [*history, point][-2:]
        branch.sort(key=lambda each: each.omega)
        size = np.array([self.amplitude(solver, each) for each in branch])
        top = int(size.argmax())
        if not 0 < top < len(branch) - 1:
            return None
        self.ladder = tuple(H for H in self.ladder if H >= DISTURBED)
        return self.followed(branch, size, top)

    def followed(self, found: list[Solution], size: Floats, top: int) -> Top:
        """A maximum of the sweep, located with more and more harmonics."""
        omega = np.array([found[i].omega for i in (top - 1, top, top + 1)]) - found[top].omega
        bend = 2 * np.polyfit(omega, size[top - 1 : top + 2], 2)[0] / size[top]
        at, w, bend = found[top].omega, found[top].w, min(bend, -1.0 / at_most(found) ** 2)
        steps: list[tuple[int, float, float]] = []
        located, last, ends = True, found[top], [TURN * f for f in self.given.range]
        for harmonics in self._steps(steps):
            solver = self.solver(harmonics, (1 - NEAR) * at, (1 + NEAR) * at)
            resonance = Resonance(solver.family, self.component, TOLERANCE)
            peak = resonance.peak(at, resized(w, harmonics), bend)
            if peak is None:
                point, reached, located = self._searched(solver, at, resized(w, harmonics), bend)
                if point is None:
                    located = False
                    break
            else:
                point, reached, bend, located = peak.solution, peak.amplitude, peak.bend, True
            at, w, last = point.omega, point.w, point
            steps.append((harmonics, reached, at / TURN))
        if not steps:
            steps = [(SWEPT, float(size[top]), found[top].omega / TURN)]
        harmonics, amplitude, hertz = steps[-1]
        if not ends[0] <= at <= ends[1]:  # this branch is highest where the range cuts it off
            end = self.solver(SWEPT, (1 - NEAR) * at, (1 + NEAR) * at).point(
                float(np.clip(at, *ends)), [found[top]]
            )
            return self.at_end(end)
        return Top(amplitude, hertz, False, harmonics, steps, located, self._state(last))

    def _steps(self, steps: list[tuple[int, float, float]]) -> Iterator[int]:
        """Harmonics one after another until the amplitude in `steps` has settled."""
        for harmonics in self.ladder:
            yield harmonics
            if len(steps) > 2 and abs(steps[-1][1] / steps[-2][1] - 1) < self.settled:
                break

    def _searched(
        self, solver: PointSolver, at: float, start: Floats, bend: float
    ) -> tuple[Solution | None, float, bool]:
        """The highest of a fine sweep around where a peak should be, then located if possible."""
        reach = min(6 / np.sqrt(-bend), NEAR * at)
        explored = list(solver.explore(at - reach, at + reach))
        found = [each for each in explored if each.converged]
        if not found:
            return None, 0.0, False
        size = [self.amplitude(solver, each) for each in found]
        top = int(np.argmax(size))
        resonance = Resonance(solver.family, self.component, TOLERANCE)
        peak = resonance.peak(found[top].omega, found[top].w, bend, found[top].reuse)
        if peak is None or peak.amplitude < size[top]:
            return found[top], size[top], False
        return peak.solution, peak.amplitude, True

    def at_end(self, end: Solution) -> Top:
        """The amplitude at an end of the range with more and more harmonics."""
        steps: list[tuple[int, float, float]] = []
        last, located = end, True
        for harmonics in self._steps(steps):
            solver = self.solver(harmonics, (1 - 1e-3) * end.omega, (1 + 1e-3) * end.omega)
            begun = replace(last, w=resized(last.w, harmonics), kept=None)
            last = solver.point(end.omega, [begun])
            if not last.converged:
                located = False
                break
            steps.append((harmonics, self.amplitude(solver, last), last.omega / TURN))
        if not steps:
            steps = [(SWEPT, 0.0, end.omega / TURN)]
        harmonics, amplitude, hertz = steps[-1]
        return Top(amplitude, hertz, True, harmonics, steps, located, self._state(last))

    def _state(self, solution: Solution) -> dict[str, tuple[float, float]]:
        """Share of each joint's contacts that slip, and that open, at a solution."""
        joint = np.array(self.given.system.contacts.joint)
        state = solution.deviation.state
        return {
            name: (
                float(np.isin(state[joint == name], (1, 3)).mean()),
                float(np.isin(state[joint == name], (2, 3)).mean()),
            )
            for name in dict.fromkeys(joint)
        }


def at_most(found: list[Solution]) -> float:
    """Width of a sweep, rad/s."""
    return found[-1].omega - found[0].omega


def found_again(down: list[Top], up: list[Top]) -> list[Top]:
    """Peaks of the downward sweep that the upward one does not have."""
    return [
        top for top in down if all(abs(top.amplitude / other.amplitude - 1) > SAME for other in up)
    ]


def reference(scene: Scene, given: Prepared, settled: float = SETTLED) -> dict[str, Any]:
    """The reference of a scene, as JSON holds it."""
    begin = time.process_time()
    finder = Reference(scene, given, settled)
    up = finder.tops(True)
    down = found_again(finder.tops(False, up), up)
    if scene.number in BESIDE:
        down += [top for top in [finder.beside(BESIDE[scene.number])] if top]
        down.sort(key=lambda top: -top.amplitude)
    best = up[0]
    return {
        "number": scene.number,
        "kind": scene.kind,
        "range": given.range,
        "monitor": given.monitor.name,
        **asdict(best),
        "doubt": best.doubt,
        "others": [asdict(top) for top in up[1:]],
        "down": asdict(down[0]) if down else None,
        "jumped": finder.jumped,
        "rom": len(given.system.at(given.system.nodal_diameter(1)).K),
        "contacts": given.system.contacts.count,
        "seconds": time.process_time() - begin,
    }
