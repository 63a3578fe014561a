"""One system balanced with any number of harmonics: what several H share is prepared once.

Nodal diameters are asked for when a harmonic needs them. Until then, where no more than an estimate
is wanted, the matrices of the nearest diameter stand for them, at the harmonic's own phase between
neighbours: parts change little from one to the next, if at all.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import cast

from vanelock.common.cyclic import folded
from vanelock.nonlinear.balance.balance import Balance, Structure, structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated, balances
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.contact.sampling import least_samples
from vanelock.nonlinear.continuation.families import Frequencies
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver, PointStore
from vanelock.nonlinear.forced_response.options import Options, PreparedSystem
from vanelock.nonlinear.newton.newton import Solution
from vanelock.nonlinear.newton.preconditioner import Kept
from vanelock.rom.system.system import System

_PATIENCE, _MANY = 100, 1000
"""Balances summed over all modes before tables are made, and those expected then."""


@dataclass
class _Deferred:
    """Balances by circular frequency in a range, rad/s, tabulated once many have been asked for."""

    structure: Structure
    limits: tuple[float, float]
    _asked: int = 0
    _source: Structure | Tabulated | None = None

    def balance(self, omega: float) -> Balance:
        """The balance at a circular frequency."""
        self._asked += 1
        if self._asked <= _PATIENCE:
            return self.structure.balance(omega)
        if self._source is None:
            self._source = balances(self.structure, *self.limits, _MANY)
        return self._source.balance(omega)


@dataclass
class HarmonicLevels:
    """Solvers by number of harmonics, whatever `options` say of it, in a range of rad/s.

    `systems` leads from H to one that has the nodal diameters of all harmonics up to H; `reached`
    is the largest H that one was asked for.
    """

    systems: Callable[[int], System]
    limits: tuple[float, float]
    options: Options
    searching: Callable[[float], None] = lambda _: None
    store: PointStore | None = None
    reached: int = -1
    _system: System | None = None
    _modes: dict[int, StuckModes] = field(default_factory=dict)
    _guessed: dict[tuple[int, int], StuckModes] = field(default_factory=dict)
    _ready: dict[int, PreparedSystem] = field(default_factory=dict)
    _structures: dict[int, Structure] = field(default_factory=dict)
    _extended: dict[int, Structure] = field(default_factory=dict)
    _kept: dict[int, Kept] = field(default_factory=dict)

    def structure(self, harmonics: int) -> Structure:
        """The structure with H harmonics, all at their own nodal diameters."""
        if harmonics > self.reached:
            self._system, self.reached = self.systems(harmonics), harmonics
            self._extended.clear()
        assert self._system is not None
        if harmonics not in self._structures:
            made = structure(self._system, harmonics, self.options.harmonic_diameters, self._modes)
            self._modes |= made.modes
            self._structures[harmonics] = made
        return self._structures[harmonics]

    def extended(self, harmonics: int) -> Structure:
        """The same for estimates, neighbours standing in for diameters that are not there."""
        if harmonics <= self.reached:
            return self.structure(harmonics)
        if harmonics not in self._extended:
            assert self._system is not None
            system, places = _stood_in(self._system, harmonics)
            guessed = {
                own: self._guessed[own, place]
                for own, place in places.items()
                if (own, place) in self._guessed
            }
            known = guessed | self._modes
            made = structure(system, harmonics, self.options.harmonic_diameters, known)
            for own, place in places.items():
                if own in made.modes:
                    self._guessed[own, place] = made.modes[own]
            self._extended[harmonics] = made
        return self._extended[harmonics]

    def law(self, harmonics: int, located: bool = False) -> Law:
        """The contact law for H harmonics; `located`: on no samples, though some are given."""
        assert self._system is not None
        options = self._options(harmonics)
        options = replace(options, samples=None) if located else options
        return options.law(self._system.contacts)(harmonics)

    def _options(self, harmonics: int) -> Options:
        """The options with H harmonics, and as many samples as these need."""
        samples = self.options.samples
        samples = None if samples is None else max(samples, least_samples(harmonics))
        return replace(self.options, harmonics=harmonics, samples=samples)

    @cached_property
    def _rest(self) -> Solution | None:
        """The static state that vibration is referred to; None where both are coupled."""
        coupled = self.options.coupling == "coupled"
        return None if coupled else PreparedSystem(self._options(1), self.structure(1)).rest

    def ready(self, harmonics: int) -> PreparedSystem:
        """The system ready to be solved with H harmonics."""
        if harmonics not in self._ready:
            source = cast(Tabulated, _Deferred(self.structure(harmonics), self.limits))
            made = PreparedSystem(self._options(harmonics), source, self.store)
            vars(made).update(law=self.law, rest=self._rest)  # all have the same
            vars(made)["solver"] = replace(made.solver, searching=self.searching)
            self._ready[harmonics] = made
        return self._ready[harmonics]

    def solver(self, harmonics: int) -> PointSolver:
        """What solves with H harmonics."""
        return self.ready(harmonics).solver

    def guessing(self, harmonics: int) -> Frequencies:
        """Problems with H harmonics, neighbours standing in for diameters that are not there."""
        mean = None if self._rest is None else self._rest.u[:, :, 0]
        return Frequencies(self.extended(harmonics), self.law(harmonics), mean)

    def kept(self, harmonics: int) -> Kept | None:
        """What preconditions balances of H harmonics, its matrix to be made anew."""
        return self._kept.get(harmonics)

    def keep(self, harmonics: int, reuse: Kept | None) -> None:
        """Have later balances of H harmonics start from this."""
        if reuse is not None:
            self._kept[harmonics] = replace(reuse, stale=True)


def _stood_in(system: System, harmonics: int) -> tuple[System, dict[int, int]]:
    """The system with the nearest diameter's matrices for those it lacks, and which they are."""
    N = system.sectors
    there = {folded(k, N) for k in system.diameters}
    wave = {folded(system.nodal_diameter(h), N) for h in range(harmonics + 1)}
    lacking = wave - there
    places = {own: min(there, key=lambda j: (abs(j - own), j)) for own in lacking}
    diameters = system.diameters | {own: system.at(place) for own, place in places.items()}
    return replace(system, diameters=diameters), places
