"""A dwell, at a frequency or at the peak of a range, and its vibration as interference changes.

At a peak the peak itself is followed from one interference to the next; where it is lost, the
highest one of the range goes on. At a frequency held the solution is followed along the straight
way between both interferences, through folds too; where that leads nowhere, one is looked for
afresh.

A step of wear over cycles is by Heun's rule. With r(v0) the depth worn in a cycle, the interference
after h cycles is

    v* = v0 - h r(v0),      v0(h) = v0 - h/2 (r(v0) + r(v*)),

whose error over a given number of cycles falls with the square of h. Between both ends the
interference is the parabola of these slopes. A step changes the interference of no contact by more
than a share of it, or of its largest normal displacement where that is larger; and it is halved
where rates change by more than five times that share, at most a quarter, as near a fold, where
friction begins to slip or where a peak is lost.

The rate r is Archard's law, what a contact loses in a period of its vibration,

    dv0/dN = -(k / A) ∮ n |dw|,

v0 the interference, n the normal force, w the path of the friction slider, A the contact's area, k
the wear coefficient of both surfaces together (J. F. Archard, J. Appl. Phys. 24 (1953) 981-988).
The friction work of the contact law is μ ∮ n |dw|: of the path in the tangential plane where
friction is isotropic; where it is orthogonal, of both directions one by one, |dw| = |dw₁| + |dw₂|,
which is up to √2 of the path in the plane.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Floats, as_array
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.stuck_modes import stuck_modes
from vanelock.nonlinear.contact.law import Deviation
from vanelock.nonlinear.forced_response.frequency_response import static_response
from vanelock.nonlinear.forced_response.options import (
    Options,
    PreparedSystem,
    checked_frequencies,
    checked_range,
)
from vanelock.nonlinear.forced_response.parameter_response import Parameter, traced
from vanelock.nonlinear.fourier import TURN, to_complex
from vanelock.nonlinear.newton.newton import Solution
from vanelock.nonlinear.peaks.peak import CurvePoint
from vanelock.nonlinear.peaks.peak_tracking import PeakTrack
from vanelock.rom.system.system import Contacts, System


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
        return self == replace(before, cycles=self.cycles)


def _positive(value: object, name: str) -> float:
    """A number > 0."""
    found = as_array(value, name)
    if found.shape != () or not (np.isfinite(found) and found > 0):
        raise InputError(f"{name}: given {value!r}: must be one number > 0 and finite")
    return float(found)


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
        """(c,) the interference, or the largest normal displacement if that is larger, m.

        A change of each contact's interference is compared with it.
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
        solution = traced(family, 1.0, [begun], partial(at, 1.0), tolerance)
        return self._held(v0, at(1.0), solution, last.component)

    def at(self, v0: Floats) -> PreparedSystem:
        """The system at an interference, ready to be solved."""
        return self._way(v0, v0).at(self.ready, 1.0)

    def _way(self, begin: Floats, end: Floats) -> Parameter:
        """The way from one interference, 0, to another, 1."""
        return Parameter("worn", np.ones(len(end), bool), False, np.array([begin, end]))

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
    if peak is None or track.component is None or not (peak.solution.converged and peak.exact):
        return None
    return Vibration(v0, peak, track.component, swept)


Law: TypeAlias = Callable[[Deviation], Floats]
"""(c,) depth worn in a period, both surfaces together, m, by how contacts deviate."""


def archard(contacts: Contacts, coefficient: ArrayLike, area: ArrayLike) -> Law:
    """The law of wear of these contacts."""
    k = _of_contacts(coefficient, "coefficient", "m²/N", contacts.count)
    A = _of_contacts(area, "area", "m²", contacts.count)
    if (k < 0).any():
        raise InputError(f"coefficient: given {k.min():g} m²/N: must be >= 0")
    if not (A > 0).all():
        raise InputError(f"area: given {A.min():g} m²: must be > 0")
    k = np.where(contacts.springs, k, 0.0)
    if (smooth := (k > 0) & (contacts.mu == 0)).any():
        i = int(np.argmax(smooth))
        raise InputError(
            f"coefficient: given {k[i]:g} m²/N of contact {i}, whose mu is 0: "
            "wear follows from friction work; needs mu > 0 or a coefficient of 0"
        )
    depth, wears = k / A, k > 0

    def rate(deviation: Deviation) -> Floats:
        slid = np.zeros(len(depth))
        np.divide(deviation.dissipation, contacts.mu, out=slid, where=wears)
        return np.where(wears, depth * np.maximum(slid, 0.0), 0.0)

    return rate


def _of_contacts(values: ArrayLike, name: str, unit: str, count: int) -> Floats:
    """A finite number of each contact."""
    found = as_array(values, name)
    if found.shape not in ((), (count,)):
        raise InputError(
            f"{name}: given shape {found.shape}: needs a number in {unit}, or one of each of the "
            f"{count} contacts"
        )
    if not np.isfinite(found).all():
        raise InputError(f"{name}: given {found[~np.isfinite(found)][0]}: must be finite")
    return np.broadcast_to(found, count).astype(float)


class Rest(NamedTuple):
    """Joints at rest: by joint (j,) the sum of the normal forces of its contacts in a sector, N.

    `approach` (j,), m, is the largest normal displacement among them; none is closed below zero.
    """

    load: Floats
    approach: Floats
    converged: bool


def preload(system: System, options: Options) -> tuple[tuple[str, ...], Callable[[Floats], Rest]]:
    """The joints that consist of contacts, and what finds them at rest by the interference of all.

    Stuck modes do not change with wear.
    """
    contacts, modes = system.contacts, {0: stuck_modes(system, 0)}
    named = zip(contacts.joints, contacts.springs, strict=True)
    joints = tuple(dict.fromkeys(joint for joint, spring in named if spring))
    members = [contacts.of(joint) & contacts.springs for joint in joints]

    def at(v0: Floats) -> Rest:
        found = static_response(replace(system, contacts=replace(contacts, v0=v0)), options, modes)
        v = found.contact[0, 0, :, 0].real
        n = contacts.kn * np.maximum(v, 0.0)
        load = np.array([n[each].sum() for each in members])
        approach = np.array([v[each].max() for each in members])
        return Rest(load, approach, bool(found.converged[0]))

    return joints, at


_CHANGE = 0.25
"""Of the largest rate: how far rates may change in a step, and beyond which they jump."""
_FINER = 5.0
"""How far rates may change at most, over the share of the interference that a step may: near a fold
rates change fast while the interference hardly does, and a smaller share alone takes no smaller
steps there."""
_SHORTEST = 1 / 64  # of the step that the interference allows


@dataclass(frozen=True)
class WearStep:
    """A step of h `cycles` to the vibration `end`; `solved` vibrations were looked for.

    `begin` (c,), m, is the interference before it, `rates` (2, c), m, the depth worn in a cycle
    before it and at its first guess; `jumped`: the vibration changed at once, rates by more than a
    quarter in the shortest step, or to another peak.
    """

    cycles: float
    begin: Floats
    rates: Floats
    end: Vibration
    jumped: bool
    solved: int

    def interference(self, share: float) -> Floats:
        """(c,) interference after a share of the step, m."""
        before, after = self.rates
        worn = share * before + 0.5 * share**2 * (after - before)
        return np.asarray(self.begin - self.cycles * worn)


def stepped(
    begin: Vibration,
    law: Law,
    cycles: float,
    share: float,
    following: Callable[[Vibration, Floats], Vibration | None],
) -> WearStep | None:
    """One step of so many cycles or fewer; None where no vibration is found after the shortest."""
    rate, solved, h = law(begin.solution.deviation), 0, cycles
    enough = min(_CHANGE, _FINER * share)
    while True:
        last = h <= _SHORTEST * cycles
        guess = following(begin, begin.v0 - h * rate)
        solved += 1
        if guess is not None:
            other = law(guess.solution.deviation)
            largest = max(rate.max(initial=0.0), other.max(initial=0.0))
            change = np.abs(other - rate).max(initial=0.0)
            if last or change <= enough * largest:
                end = following(guess, begin.v0 - 0.5 * h * (rate + other))
                solved += 1
                if end is not None:
                    jumped = change > _CHANGE * largest or guess.swept or end.swept
                    return WearStep(h, begin.v0, np.array([rate, other]), end, jumped, solved)
        if last:
            return None
        h *= 0.5
