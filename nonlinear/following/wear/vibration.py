"""The vibration of a dwell as the interference of all contacts changes.

At a peak the peak itself is followed from one interference to the next; where it is lost, the
highest one of the range goes on. At a frequency held the solution is followed along the straight
way between both interferences, through folds too; where that leads nowhere, one is looked for
afresh.
"""

from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.following.parameter_response import Tracer
from vanelock.nonlinear.following.parameters import Parameter
from vanelock.nonlinear.following.peak import CONDITION, PeakPoint
from vanelock.nonlinear.following.peak_tracking import Mark, PeakTrack
from vanelock.nonlinear.following.wear.dwell import Dwell
from vanelock.nonlinear.forced_response.options import Options, PreparedSystem
from vanelock.nonlinear.fourier.trigonometric import TURN, to_complex
from vanelock.nonlinear.newton.newton import Solution
from vanelock.rom.system.system import System

Floats = NDArray[np.float64]

POINTS = 1000
"""About how many frequencies are solved while the peak of a range is followed."""


@dataclass(frozen=True)
class Vibration:
    """Periodic vibration at one interference of the contacts.

    Attributes
    ----------
    v0 : (c,) float
        The interference, m.
    solution : Solution
    component : (int, int)
        Output node and direction whose amplitude is given.
    amplitude : float
        Half the peak-to-peak of that output, m.
    peak : PeakPoint or None
        Where it is dwelt at one.
    swept : bool
        Whether that peak was found by a sweep, not by following another.
    """

    v0: Floats
    solution: Solution
    component: tuple[int, int]
    amplitude: float
    peak: PeakPoint | None = None
    swept: bool = False

    @property
    def frequency(self) -> float:
        """Of the excitation, Hz."""
        return self.solution.omega / TURN

    @property
    def size(self) -> Floats:
        """(c,) what a change of each contact's interference is compared with, m.

        The interference or the largest normal displacement that the harmonics allow, whichever is
        larger.
        """
        v = np.abs(to_complex(self.solution.u[:, 0])).sum(axis=0)
        return np.asarray(np.maximum(np.abs(self.v0), v))


@dataclass(frozen=True)
class Vibrations:
    """Finds the vibration of one dwell by interference.

    Attributes
    ----------
    ready : PreparedSystem
        With the dwell's force.
    dwell : Dwell
    """

    ready: PreparedSystem
    dwell: Dwell

    def first(self, v0: Floats, component: tuple[int, int] | None) -> Vibration | None:
        """The vibration that the dwell begins with; None where there is none.

        Without an output and direction, that of the largest amplitude.
        """
        if self.dwell.at_peak:
            track = PeakTrack.along(self.ready, self._way(v0, v0), self.dwell.hertz, component)
            return _at_peak(v0, *track.begun(1.0), True)
        omega = TURN * float(self.dwell.hertz[0])
        at = self.at(v0)
        return self._held(v0, at, at.solver.point(omega, []), component)

    def following(self, last: Vibration, v0: Floats) -> Vibration | None:
        """The vibration at another interference; None where there is none."""
        way = self._way(last.v0, v0)
        if last.peak is not None:
            track = PeakTrack.along(self.ready, way, self.dwell.hertz, last.component)
            marks = track.follow([Mark(0.0, 0.0, last.peak)], 1.0)
            found = _at_peak(v0, track, marks[-1].peak if marks else None, False)
            if found is not None:
                return found
            return _at_peak(v0, *track.begun(1.0), True)
        at, omega = lru_cache(4)(partial(way.at, self.ready)), last.solution.omega
        family, tolerance = way.family(self.ready, omega), self.ready.options.tolerance
        begun = replace(last.solution, parameter=0.0)
        solution = Tracer(at, way, family, tolerance).point(1.0, [begun])
        return self._held(v0, at(1.0), solution, last.component)

    def at(self, v0: Floats) -> PreparedSystem:
        """The system at an interference, ready to be solved."""
        return self._way(v0, v0).at(self.ready, 1.0)

    def _way(self, begin: Floats, end: Floats) -> Parameter:
        """The way from one interference, 0, to another, 1."""
        return Parameter(
            "worn", np.ones(len(end), bool), False, interferences=np.array([begin, end])
        )

    def _held(
        self, v0: Floats, ready: PreparedSystem, found: Solution, component: tuple[int, int] | None
    ) -> Vibration | None:
        """A solution at a frequency held as a vibration."""
        if not found.converged:
            return None
        size = ready.solver.amplitude(found).reshape(-1, 3)
        node, direction = component or np.unravel_index(size.argmax(), size.shape)
        named = (int(node), int(direction))
        return Vibration(v0, found, named, float(size[named]))


def vibrations(system: System, dwell: Dwell, options: Options) -> Vibrations:
    """What finds the vibration of a dwell."""
    unscaled = Parameter("force", np.zeros(system.contacts.count, bool), True)
    loaded = unscaled.system(system, dwell.force)
    points = POINTS if dwell.at_peak else 1
    return Vibrations(options.prepare(loaded, dwell.hertz, points), dwell)


def _at_peak(v0: Floats, track: PeakTrack, peak: PeakPoint | None, swept: bool) -> Vibration | None:
    """A peak as a vibration; None where it is not solved."""
    if peak is None or track.component is None or not peak.solution.converged:
        return None
    if not (peak.distance < CONDITION or peak.sharp):
        return None
    return Vibration(v0, peak.solution, track.component, peak.amplitude, peak, swept)
