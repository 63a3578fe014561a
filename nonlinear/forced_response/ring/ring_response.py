"""Forced response of a ring whose sectors are not alike."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Booleans, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.continuation.families import Frequencies, fixed
from vanelock.nonlinear.forced_response.frequency_response import swept
from vanelock.nonlinear.forced_response.frequency_sweep import PointSolver, Progress, counted
from vanelock.nonlinear.forced_response.options import (
    Options,
    check_band,
    check_forces,
    checked_frequencies,
    checked_range,
)
from vanelock.nonlinear.forced_response.response import STATES, half_peak_to_peak
from vanelock.nonlinear.forced_response.ring.mistuning import Mistuning
from vanelock.nonlinear.forced_response.ring.ring_source import (
    RingSource,
    ring_contacts,
    ring_source,
)
from vanelock.nonlinear.fourier import TURN, one_thread, to_complex
from vanelock.nonlinear.newton.newton import Solution, solve
from vanelock.rom.system.system import System

_SMALLEST = 1 / 64  # of the deviations: the smallest step from the alike ring to the mistuned one


@dataclass(frozen=True, kw_only=True)
class _RingSolver(PointSolver):
    """What solves one point of a ring after another.

    `parts`: problems by circular frequency whose deviations are a part, 0 to 1, of those given;
    `alike`: converged ones of one sector of the alike ring, by which a point may begin.
    """

    parts: Callable[[float], Frequencies]
    alike: Sequence[Solution] = field(default_factory=list)

    def sweep(self, omegas: Floats) -> Iterator[Solution]:
        """Solve at each frequency; what the next ones start from goes when they are done."""
        return (replace(each, reuse=None) for each in super().sweep(omegas))

    def explore(self, begin: float, end: float, loose: float = 1.0) -> Iterator[Solution]:
        """Solve from `begin` to `end`; what the next points start from goes when they are done."""
        return (replace(each, reuse=None) for each in super().explore(begin, end, loose))

    def _point(self, omega: float, history: list[Solution]) -> Solution:
        tried = self._newton(omega, history) if history else []
        if tried and tried[-1].converged:
            return counted(tried, omega)
        if tried:
            self.searching(omega)
        tried += self._from_alike(omega)
        if tried and tried[-1].converged:
            return replace(counted(tried, omega), continued=not history)
        last = super()._point(omega, history)
        return counted([*tried, last], omega)

    def _from_alike(self, omega: float) -> Iterator[Solution]:
        """From the alike ring, at once or by parts of the deviations."""
        if not self.alike:
            return
        nearest = min(self.alike, key=lambda solution: abs(solution.omega - omega))
        ahead = self.family.at(omega).linear
        sectors = self.family.structure.system.sectors
        w = np.zeros((sectors, len(ahead) // sectors, *ahead.shape[1:]))
        w[:, : len(nearest.w)] = nearest.w  # modes have rows behind the contacts
        w = w.reshape(ahead.shape)
        found = self._solved(omega, 1.0, w)
        yield found
        if found.converged:
            return
        begun = self._solved(omega, 0.0, w)
        part, step, last = 0.0, 0.25, begun
        while begun.converged and part < 1.0 and step >= _SMALLEST:
            following = self._solved(omega, min(part + step, 1.0), last.w, last)
            if not following.converged:
                step *= 0.5
                continue
            part, last = min(part + step, 1.0), following
            step *= 2.0 if following.iterations < 5 else 1.0
        if part == 1.0:
            yield last

    def _solved(
        self, omega: float, part: float, start: Floats, last: Solution | None = None
    ) -> Solution:
        family = self.parts(part)
        reuse = None if last is None else last.reuse
        problem = fixed(family.at(omega), family.friction)
        found = solve(problem, start, 0.0, tolerance=self.tolerance, reuse=reuse)
        return replace(found, parameter=omega)


@dataclass(frozen=True)
class RingResponse(Product):
    """Periodic response of all N sectors at p frequencies.

    Attributes
    ----------
    frequency : (p,) float
        Hz.
    contact : (p, H + 1, N, c, 3) complex
        Relative displacements (v, u1, u2), interference included in the mean of v, m; one-sided
        coefficients, q_j(t) = Re Σ_h q_j^(h) e^{ihωt} in every sector j.
    force : (p, H + 1, N, c, 3) complex
        Contact forces (n, t1, t2), N.
    state : (p, N, c) int
        STUCK, SLIP, OPEN or SLIP_OPEN; ELEMENT for what follows a law of its own.
    dissipation : (p, N, c) float
        Friction work in a period, J.
    output : (p, H + 1, N, o, 3) complex
        Displacement of the output nodes, m.
    amplitude : (p, N, o, 3) float
        Half the peak-to-peak of each output over a period, m.
    alike : (o, 3) float
        Largest amplitude of each output over the frequencies, were all sectors alike, m; NaN if
        none of those points converged.
    converged : (p,) bool
        Whether the residual is below the tolerance; if not, nothing here is to be trusted.
    residual : (p,) float
        Relative residual of the balance.
    iterations : (p,) int
        Newton steps spent.
    seconds : (p,) float
        Processor time spent on each point.
    """

    frequency: Floats = field(metadata={"unit": "Hz"})
    contact: Complex = field(metadata={"unit": "m"})
    force: Complex = field(metadata={"unit": "N"})
    state: Integers = field(metadata={"codes": STATES})
    dissipation: Floats = field(metadata={"unit": "J"})
    output: Complex = field(metadata={"unit": "m"})
    amplitude: Floats = field(metadata={"unit": "m"})
    alike: Floats = field(metadata={"unit": "m"})
    converged: Booleans
    residual: Floats
    iterations: Integers
    seconds: Floats = field(metadata={"unit": "s"})

    @property
    def amplification(self) -> Floats:
        """(N, o, 3) largest amplitude over the frequencies, over that were all sectors alike.

        Points that are not converged do not count; NaN where none is or nothing moves.
        """
        amplitude = self.amplitude[self.converged]
        if not len(amplitude):
            return np.full(self.amplitude.shape[1:], np.nan)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(self.alike > 0, amplitude.max(axis=0) / self.alike, np.nan)


def whitehead(sectors: int) -> float:
    """Largest amplification (1 + √N)/2 of one linear mode a sector (Whitehead, 1966)."""
    return float((1 + np.sqrt(sectors)) / 2)


@one_thread
def ring_response(
    system: System,
    frequencies: ArrayLike | tuple[float, float],
    mistuning: Mistuning,
    options: Options = Options(),
    progress: Progress | None = None,
    modes: Mapping[int, StuckModes] | None = None,
    shared: Mapping[int, StuckModes] | None = None,
) -> RingResponse:
    """Steady vibration of a mistuned ring with friction: all sectors' balances at once.

    Parameters
    ----------
    system : System
        With the nodal diameters 0 to N/2: what all sectors are compared with.
    frequencies : (p,) array_like or (float, float)
        Hz, as of `frequency_response`.
    mistuning : Mistuning
    options : Options
        Coupled, harmonics at the diameters of a wave, all modes in full.
    progress : callable, optional
        As of `frequency_response`; once for each point of the alike ring and of the mistuned one.
    modes : dict of int to StuckModes, optional
        As of `frequency_response`.
    shared : dict of int to StuckModes, optional
        Those of `ring_modes`, where several rings of a system are solved.

    Returns
    -------
    RingResponse
        `converged` says for each point whether it is to be trusted.

    Notes
    -----
    Each point is solved from the points before it, then from the alike ring at its frequency,
    directly or with the deviations growing from none to all, then by the ways that a response of
    alike sectors has. Where several solutions exist it is one of them, and stability is not judged.

    Raises
    ------
    InputError
        If deviations or options do not fit, a frequency is not positive, a nodal diameter is
        missing, or a harmonic above H is excited.
    """
    hertz = (checked_range if isinstance(frequencies, tuple) else checked_frequencies)(frequencies)
    allowed = {"coupling": "coupled", "harmonic_diameters": "wave", "static_beyond": None}
    for name, wanted in allowed.items():
        if (given := getattr(options, name)) != wanted:
            raise InputError(f"{name}: given {given!r}: mistuned rings have {wanted!r}")
    H = options.highest
    whole = mistuning.of(system)
    check_forces(system, H)
    check_band(system, hertz)
    omegas = TURN * hertz
    points = 100 if isinstance(frequencies, tuple) else len(hertz)
    limits = (float(omegas.min()), float(omegas.max()))
    source = ring_source(system, H, limits, points, whole.modes, shared or modes)

    @lru_cache
    def family(part: float, harmonics: int = H) -> Frequencies:
        own = ring_contacts(system.contacts, whole.share(part))
        law = own.law(harmonics, options.samples, options.friction)
        return Frequencies(replace(source, offset=own.offset), law)

    def law(harmonics: int) -> Law:
        return family(1.0, harmonics).friction

    solver = _RingSolver(family(1.0), law, options.tolerance, effort=options.effort, parts=family)
    first = options.prepare(system, hertz, points, modes)
    alike, _ = swept(first.solver, frequencies, options.direction, progress)
    alike = [each for each in alike if each.converged]
    found, _ = swept(replace(solver, alike=alike), frequencies, options.direction, progress)
    largest = np.full((len(system.output_names), 3), np.nan)
    for each in alike:
        moved = first.structure.output(first.structure.amplitudes(each.omega, each.w))
        largest = np.fmax(largest, half_peak_to_peak(moved))
    source = replace(source, offset=ring_contacts(system.contacts, whole).offset)
    return _assembled(source, system, found, largest)


def _assembled(
    source: RingSource, system: System, solutions: list[Solution], alike: Floats
) -> RingResponse:
    """Solved points as a response, the first sector's instant for all."""
    N, c, H = system.sectors, system.contacts.count, source.harmonics
    turn = np.outer(np.arange(H + 1), np.arange(N)) * system.engine_order / N
    lag = np.exp(-2j * np.pi * turn)[:, :, None, None]
    stiffness = np.repeat(source.each[0].stiffness.reshape(1, -1, 3), N, axis=0)[:, :c]

    def of_contacts(values: Floats) -> Complex:
        """(H + 1, N, c, 3)."""
        shaped = to_complex(values).reshape(H + 1, N, -1, 3)[:, :, :c]
        return np.asarray(lag * shaped)

    states = [each.deviation.state.reshape(N, -1)[:, :c] for each in solutions]
    outputs = [lag * source.output(source.amplitudes(each.omega, each.w)) for each in solutions]
    return RingResponse(
        frequency=np.array([each.omega for each in solutions]) / TURN,
        contact=np.array([of_contacts(each.u) for each in solutions]),
        force=np.array([of_contacts(each.u - each.w) * stiffness for each in solutions]),
        state=np.array(states),
        dissipation=np.array([e.deviation.dissipation.reshape(N, -1)[:, :c] for e in solutions]),
        output=np.array(outputs),
        amplitude=half_peak_to_peak(np.array(outputs).swapaxes(0, 1)),
        alike=alike,
        converged=np.array([each.converged for each in solutions]),
        residual=np.array([each.residual for each in solutions]),
        iterations=np.array([each.iterations for each in solutions]),
        seconds=np.array([each.seconds for each in solutions]),
    )
