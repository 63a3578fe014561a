"""The options that responses share, and a system prepared to be solved with them.

Coupled, all harmonics are solved together. Otherwise the static problem is solved first, with
friction and lift-off, and its mean displacement is held while the others vibrate about it:

    n(t) = max(n₀ + kn ṽ, 0)     uncoupled,
    n(t) = n₀ + kn ṽ             with constant load, friction bounded by μ n₀ for good,

and a contact that is open at rest stays open under constant load. What friction and the normal
springs do to the mean in either case is not put back into the static balance: harmonic 0 of the
response is the static problem's.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arguments import OfKind
from vanelock.common.arrays import Floats, as_array, as_whole
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Structure, structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated, balances
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import Law, contact_law
from vanelock.nonlinear.contact.sampling import FRICTIONS, least_samples
from vanelock.nonlinear.continuation.families import Frequencies
from vanelock.nonlinear.continuation.globalisation import EFFORT, from_nothing
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver, PointStore
from vanelock.nonlinear.forced_response.response import Amplitudes, Response, assemble_response
from vanelock.nonlinear.fourier import TURN
from vanelock.nonlinear.newton.newton import TOLERANCE, Solution
from vanelock.rom.system.system import Contacts, System, wider_band

COUPLINGS = ("coupled", "uncoupled", "constant-load")


def _at_rest(structure: Structure, law: Callable[[int], Law], tolerance: float) -> Solution:
    """The static state that vibration is referred to, m = 1 coefficient."""
    force = structure.system.force.get(0)
    if force is not None and force.omega_power and force.vector.any():
        raise InputError(
            "coupling: the system's force/0 grows with the frequency: only 'coupled' is possible"
        )
    return from_nothing(static_part(structure).balance(0.0), law, tolerance)


def static_part(structure: Structure) -> Structure:
    """The same structure with harmonic 0 alone."""
    return replace(structure, harmonics=0, nodal_diameters=structure.nodal_diameters[:1])


def _with_static_mean(solution: Solution, rest: Solution) -> Solution:
    """A solution about a state of rest, its harmonic 0 that of the static problem."""
    w, u = solution.w.copy(), solution.u.copy()
    w[:, :, 0], u[:, :, 0] = rest.w[:, :, 0], rest.u[:, :, 0]
    return replace(
        solution,
        w=w,
        u=u,
        residual=max(solution.residual, rest.residual),
        converged=solution.converged and rest.converged,
    )


_ROUND_OFF = 1e-9  # by which a frequency may exceed a band


def checked_frequencies(frequencies: ArrayLike) -> Floats:
    """(p,) Hz, positive and finite."""
    hertz = np.atleast_1d(as_array(frequencies, "frequencies"))
    if hertz.ndim != 1 or not len(hertz):
        raise InputError(f"frequencies: given shape {hertz.shape}: needs a list of at least one")
    if not np.all(np.isfinite(hertz)) or np.any(hertz <= 0):
        raise InputError(f"frequencies: given {hertz.min()} Hz: must be > 0 and finite")
    return hertz


def checked_range(frequencies: ArrayLike, name: str = "frequencies") -> Floats:
    """(2,) Hz, a range."""
    hertz = checked_frequencies(frequencies)
    if len(hertz) != 2 or hertz[0] >= hertz[1]:
        raise InputError(f"{name}: given {tuple(hertz)}: a range is (low, high), low < high")
    return hertz


def check_band(system: System, hertz: ArrayLike) -> None:
    """Refuse frequencies beyond those that a system's reduced parts answer."""
    highest = float(np.max(hertz))
    if system.band is not None and highest > system.band * (1 + _ROUND_OFF):
        raise InputError(
            f"frequencies: given {highest:.6g} Hz: the system's reduced parts answer up to "
            f"{system.band:.6g} Hz (its band): reduce them with band = {wider_band(highest):g}"
        )


_HARMONICS = 3  # default of H, where it is not chosen point by point


@dataclass(frozen=True)
class Options(OfKind):
    """How a response is solved; the same for all that solve one.

    Functions that take them as `options` take each by its name as well, `harmonics=3` for
    `Options(harmonics=3)`, but for names that a function has itself.

    Attributes
    ----------
    harmonics : int, optional
        H; harmonic 0 is the mean. By default 3; in `adaptive_response` as many as a point needs.
    coupling : {"coupled", "uncoupled", "constant-load"}
        Whether static and dynamic balance are solved together. If not, the static one is solved
        first and harmonic 0 of the response is its solution: normal forces then vary about those
        at rest, or are held there for friction's sake, the normal springs linear for good.
    friction : {"orthogonal", "isotropic"}
        Whether friction in the two tangential directions is independent, |t1| <= μ n and
        |t2| <= μ n, or bounded in their plane, |t| <= μ n.
    harmonic_diameters : {"wave", "sector"}
        Nodal diameter of harmonic h: (h·EO) mod N, or that of the first one for all h >= 1.
    direction : {"up", "down"}, optional
        Whether frequencies, in `parameter_response` the parameter's values, are passed upwards or
        downwards, which chooses the branch where several solutions exist. By default upwards; in
        `adaptive_response` both ways, and the largest solution counts.
    samples : int, optional
        Evaluate the contact law on this many samples of the period instead of locating its
        events.
    static_beyond : float, optional
        Let modes whose natural frequency is more than this multiple of a harmonic's count by their
        static part alone; the response's `truncation` says what that left out. All modes count in
        full otherwise.
    tolerance : float
        Relative residual at which a point counts as converged.
    effort : int
        Newton steps that a point may take, all ways to it together, before it counts as not found.

    Raises
    ------
    InputError
        If one is not possible.
    """

    harmonics: int | None = None
    coupling: str = "coupled"
    friction: str = "orthogonal"
    harmonic_diameters: str = "wave"
    direction: str | None = None
    samples: int | None = None
    static_beyond: float | None = None
    tolerance: float = TOLERANCE
    effort: int = EFFORT

    def __post_init__(self) -> None:
        """Check each by itself, and samples against harmonics."""
        super().__post_init__()
        check_option("coupling", self.coupling, COUPLINGS)
        check_option("friction", self.friction, FRICTIONS)
        check_option("harmonic_diameters", self.harmonic_diameters, ("wave", "sector"))
        if self.direction is not None:
            check_option("direction", self.direction, ("up", "down"))
        harmonics = 1 if self.harmonics is None else as_whole(self.harmonics, "harmonics")
        if harmonics < 0:
            raise InputError(f"harmonics: given {harmonics}: must be >= 0")
        if self.samples is not None:
            shown = f"samples: given {self.samples}"
            if self.friction == "isotropic":
                raise InputError(
                    f"{shown}: isotropic friction has its events located: leave it out"
                )
            if self.samples < (least := least_samples(harmonics)):
                raise InputError(f"{shown}: needs at least {least}")
        if self.static_beyond is not None and not self.static_beyond > 1:
            raise InputError(f"static_beyond: given {self.static_beyond}: must be > 1")
        if not self.tolerance > 0:
            raise InputError(f"tolerance: given {self.tolerance}: must be > 0")
        if as_whole(self.effort, "effort") < 1:
            raise InputError(f"effort: given {self.effort}: must be >= 1")

    @property
    def highest(self) -> int:
        """H, as it is by default where it is not given."""
        return _HARMONICS if self.harmonics is None else self.harmonics

    def law(self, contacts: Contacts) -> Callable[[int], Law]:
        """The law of vibrating contacts by number of harmonics."""
        constant = self.coupling == "constant-load"
        samples, friction = self.samples, self.friction
        return lru_cache(lambda h: contact_law(contacts, h, samples, friction, constant))

    def prepare(
        self,
        system: System,
        hertz: ArrayLike,
        points: int,
        modes: Mapping[int, StuckModes] | None = None,
        store: PointStore | None = None,
    ) -> "PreparedSystem":
        """A system ready to be solved.

        Parameters
        ----------
        system : System
        hertz : (p,) array_like
            Frequencies, Hz, of which the lowest and the highest count.
        points : int
            About how many are solved between these.
        modes : dict of int to StuckModes, optional
            Stuck modes that were computed before.
        store : PointStore, optional
            Where solved points are written down.

        Raises
        ------
        InputError
            If the system's parts do not fit together, a nodal diameter is missing, a harmonic
            above H is excited, or a frequency lies beyond the system's band.
        """
        H = self.highest
        options = replace(self, harmonics=H)
        made = structure(system, H, self.harmonic_diameters, modes)
        check_forces(system, H)
        check_band(system, hertz)
        omegas = TURN * as_array(hertz, "frequencies")
        low, high = float(omegas.min()), float(omegas.max())
        if self.static_beyond is not None:
            made = replace(made, cutoff=self.static_beyond * high)
        return PreparedSystem(options, balances(made, low, high, points), store)


@dataclass(frozen=True)
class PreparedSystem:
    """A system ready to be solved.

    `options`: harmonics and samples as they are by default, where they were not given; `source`:
    gives the balances by frequency; `store`: where solved points are written down.
    """

    options: Options
    source: Structure | Tabulated
    store: PointStore | None = None

    @property
    def structure(self) -> Structure:
        """The structure behind the balances."""
        return self.source.structure

    @cached_property
    def law(self) -> Callable[[int], Law]:
        """The law of vibrating contacts by number of harmonics."""
        return self.options.law(self.structure.system.contacts)

    @cached_property
    def law_at_rest(self) -> Callable[[int], Law]:
        """That of contacts at rest."""
        return replace(self.options, coupling="coupled").law(self.structure.system.contacts)

    @cached_property
    def rest(self) -> Solution | None:
        """The static state that vibration is referred to; None where both are coupled."""
        if self.options.coupling == "coupled":
            return None
        return _at_rest(self.structure, self.law_at_rest, self.options.tolerance)

    @cached_property
    def solver(self) -> PointSolver:
        """What solves one frequency after another."""
        mean = None if self.rest is None else self.rest.u[:, :, 0]
        family = Frequencies(self.source, self.law(self.structure.harmonics), mean)
        options = self.options
        return PointSolver(family, self.law, options.tolerance, self.store, options.effort)

    def response(
        self,
        solutions: Sequence[Solution],
        amplitudes: Amplitudes | None = None,
        driven: bool = True,
        **more: Any,
    ) -> Response:
        """Solved points as a response, see `assemble_response`, with `more` of its attributes."""
        if np.isfinite(self.structure.cutoff):
            solutions = [self.solver.with_truncation(each) for each in solutions]
        if self.rest is not None:
            solutions = [_with_static_mean(each, self.rest) for each in solutions]
        found = assemble_response(self.structure, solutions, amplitudes, driven)
        options = self.options
        return replace(
            found,
            coupling=options.coupling,
            friction=options.friction,
            samples=options.samples or 0,
            **more,
        )


def options_of(system: System, response: Response) -> Options:
    """The options that a response of a system was solved with."""
    given = response.harmonic_diameters.tolist()
    wave = given == [system.nodal_diameter(h) for h in range(len(given))]
    return Options(
        response.harmonics,
        response.coupling,
        response.friction,
        "wave" if wave else "sector",
        samples=response.samples or None,
    )


def check_option(name: str, value: str, allowed: Iterable[str]) -> None:
    """Refuse an option that is not among those allowed."""
    if value not in allowed:
        raise InputError(f"{name}: given {value!r}: allowed: {', '.join(allowed)}")


def check_forces(system: System, harmonics: int) -> None:
    """Refuse a system that is excited at a harmonic beyond those of the balance."""
    if (most := max(excited(system), default=0)) > harmonics:
        raise InputError(
            f"harmonics: given {harmonics}: the system has force/{most}; needs at least {most}"
        )


def excited(system: System) -> list[int]:
    """Harmonics that a force acts at."""
    return [h for h, force in sorted(system.force.items()) if np.any(force.vector)]
