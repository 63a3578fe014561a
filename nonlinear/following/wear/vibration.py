"""A dwell, at a frequency or at the peak of a range, and its vibration as interference changes.

At a peak the peak itself is followed from one interference to the next; where it is lost, the
highest one of the range goes on. At a frequency held the solution is followed along the straight
way between both interferences, through folds too; where that leads nowhere, one is looked for
afresh.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from vanelock.common.arrays import Floats, as_array
from vanelock.common.errors import InputError
from vanelock.nonlinear.following.parameter_response import Parameter, Tracer
from vanelock.nonlinear.following.peak import CONDITION, CurvePoint
from vanelock.nonlinear.following.peak_tracking import PeakTrack
from vanelock.nonlinear.forced_response.options import (
    Options,
    PreparedSystem,
    checked_frequencies,
    checked_range,
)
from vanelock.nonlinear.fourier import TURN, to_complex
from vanelock.nonlinear.newton.newton import Solution
from vanelock.rom.system.system import System


@dataclass(frozen=True)
class Dwell:
    """Vibration that stays at one frequency, or at the peak of a resonance wherever that moves.

    Attributes
    ----------
    cycles : float
        Periods of the excitation.
    frequency : float, optional
        Hz; or else:
    near : (float, float), optional
        Range of frequencies, Hz, whose highest peak is dwelt at.
    force : float
        Factor of the excitation of all harmonics h >= 1; the static load stays.

    Raises
    ------
    InputError
        If a number is impossible, or not one of frequency and range is given.
    """

    cycles: float
    frequency: float | None = None
    near: tuple[float, float] | None = None
    force: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        for name in ("cycles", "force"):
            object.__setattr__(self, name, _positive(getattr(self, name), f"Dwell.{name}"))
        if (self.frequency is None) == (self.near is None):
            given = "none" if self.near is None else "both"
            raise InputError(f"Dwell: given {given} of frequency and near: needs one of them")
        if self.frequency is not None:
            object.__setattr__(self, "frequency", _positive(self.frequency, "Dwell.frequency"))
        if self.near is not None:
            ends = as_array(self.near, "Dwell.near")
            if ends.shape != (2,) or not (np.isfinite(ends).all() and 0 < ends[0] < ends[1]):
                raise InputError(
                    f"Dwell.near: given {self.near!r}: a range is (low, high), 0 < low < high, Hz"
                )
            object.__setattr__(self, "near", tuple(ends.tolist()))

    @property
    def at_peak(self) -> bool:
        """Whether it is dwelt at a peak."""
        return self.near is not None

    @property
    def hertz(self) -> Floats:
        """The frequency or the range, Hz."""
        if self.near is not None:
            return checked_range(self.near)
        assert self.frequency is not None
        return checked_frequencies(self.frequency)

    def continues(self, before: "Dwell") -> bool:
        """Whether the vibration goes on as in the dwell before."""
        return (self.frequency, self.near, self.force) == (
            before.frequency,
            before.near,
            before.force,
        )


def _positive(value: object, name: str) -> float:
    """A number > 0."""
    found = as_array(value, name)
    if found.shape != () or not (np.isfinite(found) and found > 0):
        raise InputError(f"{name}: given {value!r}: must be one number > 0 and finite")
    return float(found)


def checked_dwells(dwells: Dwell | Sequence[Dwell]) -> tuple[Dwell, ...]:
    """One dwell or several as a tuple."""
    given = (dwells,) if isinstance(dwells, Dwell) else dwells
    if not given:
        raise InputError(f"dwells: given {dwells!r}: needs a Dwell, or a list of them")
    return tuple(given)


_POINTS = 1000  # about how many frequencies are solved while the peak of a range is followed


@dataclass(frozen=True)
class Vibration:
    """Periodic vibration at one interference of the contacts, `v0` (c,), m.

    `point` is of the output node and direction `component`, its peak where it is dwelt at one;
    `swept`: that peak was found by a sweep, not by following another.
    """

    v0: Floats
    point: CurvePoint
    component: tuple[int, int]
    swept: bool = False

    @property
    def solution(self) -> Solution:
        """Its solution."""
        return self.point.solution

    @property
    def frequency(self) -> float:
        """Of the excitation, Hz."""
        return self.point.omega / TURN

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
    """Finds the vibration of one dwell by interference; the system has the dwell's force."""

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
        if self.dwell.at_peak:
            track = PeakTrack.along(self.ready, way, self.dwell.hertz, last.component)
            peaks = track.follow([track.placed(last.point, 0.0)], 1.0)
            found = _at_peak(v0, track, peaks[-1] if peaks else None, False)
            if found is not None:
                return found
            return _at_peak(v0, *track.begun(1.0), True)
        at, omega = lru_cache(4)(partial(way.at, self.ready)), last.point.omega
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
        self,
        v0: Floats,
        ready: PreparedSystem,
        solution: Solution,
        component: tuple[int, int] | None,
    ) -> Vibration | None:
        """A solution at a frequency held as a vibration."""
        if not solution.converged:
            return None
        size = ready.solver.amplitude(solution).reshape(-1, 3)
        node, direction = component or np.unravel_index(size.argmax(), size.shape)
        named = (int(node), int(direction))
        return Vibration(v0, CurvePoint(solution, float(size[named])), named)


def vibrations(system: System, dwell: Dwell, options: Options) -> Vibrations:
    """What finds the vibration of a dwell."""
    unscaled = Parameter("force", np.zeros(system.contacts.count, bool), True)
    loaded = unscaled.system(system, dwell.force)
    points = _POINTS if dwell.at_peak else 1
    return Vibrations(options.prepare(loaded, dwell.hertz, points), dwell)


def _at_peak(
    v0: Floats, track: PeakTrack, peak: CurvePoint | None, swept: bool
) -> Vibration | None:
    """A peak as a vibration; None where it is not solved."""
    if peak is None or track.component is None or not peak.solution.converged:
        return None
    if not (peak.distance < CONDITION or peak.sharp):
        return None
    return Vibration(v0, peak, track.component, swept)
