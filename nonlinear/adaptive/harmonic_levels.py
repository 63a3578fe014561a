"""One system balanced with any number of harmonics: what several H share is prepared once.

Nodal diameters are asked for when a harmonic needs them. Until then, where no more than an estimate
is wanted, the matrices of the nearest diameter stand for them, at the harmonic's own phase between
neighbours: parts change little from one to the next, if at all.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from vanelock.common.arrays import Floats
from vanelock.common.cyclic import folded
from vanelock.nonlinear.balance.balance import Balance, Structure, structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated, balances
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.contact.sampling import least_samples
from vanelock.nonlinear.continuation.families import Frequencies
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver, PointStore
from vanelock.nonlinear.forced_response.options import Options, at_rest
from vanelock.nonlinear.newton.linearised import KeptBasis
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
    _solvers: dict[int, PointSolver] = field(default_factory=dict)
    _structures: dict[int, Structure] = field(default_factory=dict)
    _extended: dict[int, Structure] = field(default_factory=dict)
    _rest: Solution | None = None
    _kept: dict[int, KeptBasis] = field(default_factory=dict)

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
        samples = None if located else self.samples_of(harmonics)
        assert self._system is not None
        options = replace(self.options, harmonics=harmonics, samples=samples)
        return options.law(self._system.contacts)(harmonics)

    def samples_of(self, harmonics: int) -> int | None:
        """Samples of a period for H harmonics, None where events are located."""
        if self.options.samples is None:
            return None
        return max(self.options.samples, least_samples(harmonics))

    @property
    def rest(self) -> Solution | None:
        """The static state that vibration is referred to; None where both are coupled."""
        if self.options.coupling != "coupled" and self._rest is None:
            # Constant load holds vibration alone.
            still = replace(self, options=replace(self.options, coupling="coupled"))
            self._rest = at_rest(self.structure(1), still.law, self.options.tolerance)
        return self._rest

    def mean(self) -> Floats | None:
        """Mean displacement that is held, (c, 3) m."""
        return None if self.rest is None else self.rest.u[:, :, 0]

    def solver(self, harmonics: int) -> PointSolver:
        """What solves with H harmonics."""
        if harmonics not in self._solvers:
            source = _Deferred(self.structure(harmonics), self.limits)
            family = Frequencies(source, self.law(harmonics), self.mean())
            tolerance, effort = self.options.tolerance, self.options.effort
            self._solvers[harmonics] = PointSolver(
                family, self.law, tolerance, self.store, effort, self.searching
            )
        return self._solvers[harmonics]

    def guessing(self, harmonics: int) -> Frequencies:
        """Problems with H harmonics, neighbours standing in for diameters that are not there."""
        return Frequencies(self.extended(harmonics), self.law(harmonics), self.mean())

    def kept(self, harmonics: int) -> Kept | None:
        """What preconditions balances of H harmonics, its matrix to be made anew."""
        return self._kept.get(harmonics)

    def keep(self, harmonics: int, reuse: Kept | None) -> None:
        """Have later balances of H harmonics start from this."""
        if isinstance(reuse, KeptBasis):
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
