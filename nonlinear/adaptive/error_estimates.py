"""Errors of a solution by what it leaves out, to first order, without a better solution.

Whatever is left out moves the contacts by some δu if their deviation w is held, or asks for a
deviation that differs by δw from the one that is there. The structure and the contacts answer as
they are linearised at the solution, with two more harmonics than it has,

    (I - W' R̂) dw = δw + W' δu,

and the amplitude A of the monitored output is taken once more with w + dw. Sources are

    harmonics   the contacts' own coefficients above H: the solution is no solution of the balance
                with H + 2 harmonics, and dw is Newton's step towards one,
    modes       the missing compliance of the reduced parts (`rom.neglected_forms`),
    mesh        natural frequencies that are too high by an estimated share,
    samples     the law evaluated with located events.

Pushing the coefficients above H through their receptances alone, without what the motion there does
to the contacts in turn, is not enough: a harmonic that meets a resonance of its nodal diameter
changes the others by many times that.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from vanelock.common.arrays import Complex, Floats
from vanelock.nonlinear.adaptive.harmonic_levels import HarmonicLevels
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.contact.law import Deviation
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.forced_response.options import options_of
from vanelock.nonlinear.forced_response.response import (
    Response,
    amplitude_and_slope,
    chosen_points,
    half_peak_to_peak,
)
from vanelock.nonlinear.fourier import TURN, one_thread, resized, to_complex, to_real
from vanelock.nonlinear.newton.linearised import linearise
from vanelock.nonlinear.newton.newton import Solution, active_rows, scales, solve
from vanelock.nonlinear.newton.preconditioner import Equations, response_to
from vanelock.nonlinear.peaks.amplitude_gradient import solution_at
from vanelock.rom.errors import Neglected
from vanelock.rom.system.system import System

SOURCES = ("harmonics", "modes", "mesh", "samples")
BEYOND = 2
"""Harmonics beyond H with which the error of a solution is estimated."""
_EXACT = 1e-3  # relative accuracy of the linear solutions behind an estimate
_FAINT = 1e-3
"""Of the largest modal amplitude, below which a harmonic's share in an error is left out."""


@dataclass(frozen=True)
class Estimate:
    """Amplitude A of a solution at the monitored output, m, its slope, and its errors by source.

    `slope` dA/dω is NaN at a fold; `change` (s,), by how much A is too small, m, where it is not
    known; `better` (c, 3, 2H + 5), m, is the deviation with two more harmonics.
    """

    amplitude: float
    slope: float
    change: Floats
    better: Floats | None


@dataclass(frozen=True)
class Estimator:
    """Estimates the errors of solutions at the output node and direction `monitored`.

    `neglected` is what the reduced parts leave out, by nodal diameter; `mesh_error` leads from one,
    and natural frequencies of the stuck system (n,), Hz, to their relative errors.
    """

    levels: HarmonicLevels
    monitored: tuple[int, int]
    neglected: Callable[[int], Neglected] | None = None
    mesh_error: Callable[[int, Floats], Floats] | None = None

    def estimate(self, solution: Solution, harmonics: int) -> Estimate:
        """Errors of a converged solution with H harmonics."""
        state = _Wide(self.levels, solution, harmonics + BEYOND)
        wide = state.structure
        amplitudes = wide.amplitudes(solution.omega, state.w)
        q = self._output(wide, amplitudes)
        A, slope = amplitude_and_slope(q, self._rates(state, amplitudes))
        step = state.answer_to_deviation(state.gap)
        better = None if step is None else state.w + step
        softer = partial(self._softer, state, amplitudes, harmonics)
        others = [
            None if better is None else self.output(wide, state.omega, better),
            softer(self._left_out) if self.neglected else None,
            softer(self._too_stiff) if self.mesh_error else None,
            self._samples(state, q),
        ]
        change = np.array([np.nan if other is None else half(other) - A for other in others])
        return Estimate(A, slope, change, better)

    def _output(self, wide: Structure, amplitudes: list[Complex]) -> Complex:
        """(H + 1,) coefficients of the monitored output."""
        pairs = zip(wide.output_rows, amplitudes, strict=True)
        return np.array([rows[self.monitored] @ a for rows, a in pairs])

    def output(self, prepared: Structure, omega: float, w: Floats) -> Complex:
        """(H + 1,) coefficients of the monitored output under a deviation (c, 3, 2H + 1), m."""
        return self._output(prepared, prepared.amplitudes(omega, w))

    def _rates(self, state: "_Wide", amplitudes: list[Complex]) -> Complex:
        """Their derivatives to ω along the solutions; NaN where the path turns back."""
        wide, omega = state.structure, state.omega
        moved = []
        for h, amplitude in enumerate(amplitudes):
            rate = wide.push_rate(h, omega, amplitude)
            still = np.zeros(len(amplitude), complex)
            moved.append(still if rate is None else wide.at(h).solve(h * omega, rate))
        answer = state.answer_to_motion(moved)
        if answer is None:
            return np.full(len(amplitudes), np.nan, complex)
        return self._output(wide, answer)

    def _left_out(self, wide: Structure, h: int, omega: float, amplitude: Complex) -> Complex:
        """Modal forces that the compliance missing from the reduced parts amounts to."""
        assert self.neglected is not None
        shapes, left_out = wide.at(h).shapes, self.neglected(wide.nodal_diameters[h])
        return np.asarray(shapes.conj().T @ left_out.force(h * omega, shapes @ amplitude))

    def _too_stiff(self, wide: Structure, h: int, omega: float, amplitude: Complex) -> Complex:
        """The same for the meshes."""
        assert self.mesh_error is not None
        modes = wide.at(h)
        with np.errstate(divide="ignore"):
            natural = np.sqrt(modes.static) / np.sqrt(modes.compliance) / (2 * np.pi)
        error = self.mesh_error(wide.nodal_diameters[h], natural)
        return np.asarray(2 * error * modes.static * amplitude)

    def _softer(
        self, state: "_Wide", amplitudes: list[Complex], harmonics: int, force: "_Force"
    ) -> Complex | None:
        """The monitored output if modal forces in the harmonics 1 ... H were added."""
        wide, omega = state.structure, state.omega
        moved = [np.zeros(len(amplitude), complex) for amplitude in amplitudes]
        largest = max(np.abs(amplitude).max(initial=0.0) for amplitude in amplitudes[1:])
        for h in range(1, harmonics + 1):
            if np.abs(amplitudes[h]).max(initial=0.0) < _FAINT * largest:
                continue
            added = force(wide, h, omega, amplitudes[h])
            moved[h] = wide.at(h).solve(h * omega, added)
        answer = state.answer_to_motion(moved)
        if answer is None:
            return None
        return self._output(wide, [a + da for a, da in zip(amplitudes, answer, strict=True)])

    def _samples(self, state: "_Wide", q: Complex) -> Complex | None:
        """The monitored output q without the error of samples."""
        if self.levels.options.samples is None:
            return q
        located = self.levels.law(state.structure.harmonics, located=True)
        step = state.answer_to_deviation(located(state.u, state.omega).w - state.deviation.w)
        if step is None:
            return None
        return self.output(state.structure, state.omega, state.w + step)


_Force = Callable[[Structure, int, float, Complex], Complex]


class _Wide:
    """A solution taken with more harmonics, and the balance linearised there once for all."""

    def __init__(self, levels: HarmonicLevels, solution: Solution, harmonics: int) -> None:
        family = levels.guessing(harmonics)
        self.structure, self.omega = family.structure, solution.omega
        self.w = resized(solution.w, harmonics)
        self.balance: Balance = family.at(solution.omega)
        self.u = self.balance.displacement(self.w)
        self.deviation: Deviation = family.friction(self.u, solution.omega)
        self.gap = self.deviation.w - self.w
        self.rows = active_rows(self.w, self.deviation)
        self._linear = None
        if len(self.rows):
            weight = np.broadcast_to(1 / scales(self.balance.linear), self.w.shape).reshape(-1)
            kept, stiffness = levels.kept(harmonics), self.structure.stiffness
            state = self.balance, self.deviation, self.rows, weight
            self._linear = linearise(Equations(*state, None, kept, stiffness))
            levels.keep(harmonics, self._linear.reuse)

    def answer_to_deviation(self, gap: Floats) -> Floats | None:
        """Change dw if the law asks for w + gap, (c, 3, m) m; None where P is singular."""
        if self._linear is None:
            return gap
        right = np.zeros(gap.size)
        right[self.rows] = gap.reshape(-1)[self.rows]
        step = self._linear.solve(right, _EXACT)
        return None if step is None else step.reshape(gap.shape)

    def answer_to_motion(self, moved: list[Complex]) -> list[Complex] | None:
        """Change of the modal amplitudes if they were moved so at fixed w."""
        if self._linear is None:
            return moved
        wide = self.structure
        rows = [wide.at(h).rows @ each for h, each in enumerate(moved)]
        seen = to_real(np.stack(rows)).reshape(self.w.shape)
        right = np.zeros(seen.size)
        right[self.rows] = response_to(self.deviation, self.rows, seen)
        step = self._linear.solve(right, _EXACT)
        if step is None:
            return None
        pulled = to_complex(step.reshape(-1, self.w.shape[2])) * wide.stiffness
        return [
            each + wide.at(h).solve(h * self.omega, wide.at(h).pull @ pulled[h])
            for h, each in enumerate(moved)
        ]


def half(q: Complex) -> float:
    """Half the peak-to-peak of coefficients (H + 1,)."""
    return float(half_peak_to_peak(q[:, None])[0])


_SMALL = 0.02
"""Relative change that first order is trusted with: near a fold a step may be of any length."""


@one_thread
def neglected_harmonics(
    system: System, response: Response, point: int, output: tuple[int, int]
) -> float:
    """Relative error of an amplitude by the harmonics above H.

    Of a Newton step towards the balance with H + 2 where that changes the amplitude by little, else
    of its solution. Nodal diameters of the further harmonics that the system lacks take the nearest
    one's matrices.

    Parameters
    ----------
    system : System
        The response's.
    response : Response
    point : int
        Which of its frequencies.
    output : (int, int)
        Place of the output node, and direction.

    Returns
    -------
    float
        NaN where the point has not converged, or does not as the system's own, or with H + 2.

    Raises
    ------
    InputError
        If the point does not exist.
    """
    (point,) = chosen_points(response, [point])
    options = options_of(system, response)
    if not response.converged[point] or not response.harmonics:
        return float("nan")
    omega = TURN * float(response.frequency[point])
    levels = HarmonicLevels(lambda _: system, (omega, omega), options)
    found = solution_at(levels.ready(response.harmonics), response, point)
    if not found.converged:
        return float("nan")
    estimator, more = Estimator(levels, output), response.harmonics + BEYOND
    estimate = estimator.estimate(found, response.harmonics)
    change = estimate.change[SOURCES.index("harmonics")]
    if not abs(change) <= _SMALL * estimate.amplitude:
        wide, start = levels.guessing(more), resized(found.w, more)
        held = fixed(wide.at(omega), wide.friction)
        again = solve(held, start, 0.0, tolerance=options.tolerance, reuse=None)
        reached = half(estimator.output(wide.structure, omega, again.w))
        change = reached - estimate.amplitude if again.converged else np.nan
    return float(np.abs(change) / estimate.amplitude) if estimate.amplitude > 0 else float("nan")
