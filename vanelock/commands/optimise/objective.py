"""The peaks of a study's response by the values of some keys, with their gradients.

The smallest largest of several functions with gradients, within bounds.

Sequential quadratic programming (Powell; Vardi, "New minimax algorithm", J. Optim. Theory Appl. 75
(1992) 613): of functions f_j with gradients g_j at x, the step d solves

    minimise t + ½ dᵀ B d,      f_j + g_jᵀ d <= t,      within the bounds,      |d| <= Δ,

B an estimate of the curvature of Σ λ_j f_j (damped BFGS), λ the multipliers. Where the largest is
smooth this is a quasi-Newton method; where several are equal it goes along their ridge, without a
derivative that does not exist. Δ follows how well the steps are predicted.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize, nnls

from vanelock.commands.fit.parameters import FitParameter, by_key, values_of
from vanelock.commands.fit.refit_model import Rejoined
from vanelock.common.arrays import Floats
from vanelock.nonlinear import amplitude_gradient
from vanelock.nonlinear.forced_response.options import PreparedSystem
from vanelock.nonlinear.forced_response.parameter_response import Parameter
from vanelock.nonlinear.fourier import TURN, one_thread
from vanelock.nonlinear.newton.preconditioner import Kept
from vanelock.nonlinear.peaks.peak import CONDITION, CurvePoint, Resonance
from vanelock.nonlinear.peaks.peak_tracking import PeakTrack
from vanelock.quantities.sensitivities import effects

WIDEST, FIRST, LEAST = 1.0, 0.5, 1e-4
"""Of the step: at most, at first, and where the search ends."""
NEARLY = 0.25
"""Of the predicted fall, what is less than expected."""
EQUAL = 1e-6
"""Relative difference of functions that bind alike."""


class Functions(NamedTuple):
    """Values (j,) of several functions at x, and their gradients (j, p)."""

    value: Floats
    gradient: Floats

    @property
    def largest(self) -> float:
        """The largest value."""
        return float(self.value.max())


class Minimax(NamedTuple):
    """Where (p,) the largest function is smallest, the functions there, and whether it is sure.

    That is, whether no step promised more than the tolerance.
    """

    x: Floats
    functions: Functions
    settled: bool


def minimax(
    evaluate: Callable[[Floats], Functions | None],
    start: Floats,
    bounds: tuple[Floats, Floats],
    tolerance: float,
    most: int = 40,
) -> Minimax | None:
    """Find it from a start; None where there is no value at the start."""
    low, high = bounds
    x, here = np.asarray(start, float), evaluate(np.asarray(start, float))
    if here is None:
        return None
    B, reach = here.largest * np.eye(len(x)), FIRST
    settled = False
    for _ in range(most - 1):
        d, fall = _step(here, B, np.maximum(low - x, -reach), np.minimum(high - x, reach))
        if fall < tolerance * here.largest:
            settled = True
            break
        there = evaluate(x + d)
        gained = -np.inf if there is None else here.largest - there.largest
        length = float(np.abs(d).max())
        if there is not None:
            B = _updated(B, here, there, d)
        if gained > 0:
            assert there is not None
            x, here = x + d, there
        if gained > 3 * NEARLY * fall and length > 0.99 * reach:
            reach = min(2 * reach, WIDEST)
        elif gained < NEARLY * fall:
            reach = 0.4 * length
        if reach < LEAST:
            settled = True
            break
    return Minimax(x, here, settled)


def _step(here: Functions, B: Floats, low: Floats, high: Floats) -> tuple[Floats, float]:
    """The step, and by how much the largest value falls as predicted."""
    top, p = here.largest, len(low)
    value, gradient = here.value / top - 1, here.gradient / top
    curve = B / top

    def model(z: Floats) -> float:
        return float(z[p] + 0.5 * z[:p] @ curve @ z[:p])

    found = minimize(
        model,
        np.zeros(p + 1),
        jac=lambda z: np.append(curve @ z[:p], 1.0),
        bounds=[*zip(low, high, strict=True), (None, None)],
        constraints={
            "type": "ineq",
            "fun": lambda z: z[p] - value - gradient @ z[:p],
            "jac": lambda z: np.column_stack([-gradient, np.ones(len(value))]),
        },
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 200},
    )
    d = np.clip(found.x[:p], low, high)
    reached = float((value + gradient @ d).max() + 0.5 * d @ curve @ d)
    return d, -top * reached


def _updated(B: Floats, here: Functions, there: Functions, d: Floats) -> Floats:
    """The curvature after a step, by damped BFGS; as it was where functions come and go."""
    count = len(here.value)
    if count != len(there.value):
        return B
    model = here.value + here.gradient @ d
    binds = np.flatnonzero(model > model.max() - EQUAL * here.largest)
    rows = np.vstack([here.gradient[binds].T, np.full(len(binds), here.largest)])
    weight = np.zeros(count)
    weight[binds] = nnls(rows, np.append(-B @ d, here.largest))[0]
    if not weight.sum() > 0:
        return B
    weight /= weight.sum()
    y, Bd = weight @ (there.gradient - here.gradient), B @ d
    curved = float(d @ Bd)
    if not curved > 0:
        return B
    share = 1.0
    if d @ y < 0.2 * curved:
        share = 0.8 * curved / (curved - float(d @ y))
    y = share * y + (1 - share) * Bd
    return np.asarray(B - np.outer(Bd, Bd) / curved + np.outer(y, y) / float(d @ y))


LOWEST = 0.5
"""Of the highest peak, below which others do not count."""
SAME = 0.1
"""Distance in half-widths below which two peaks are one."""
NEAR = 1.0
"""Distance in x, of logarithms mostly, from where a peak was met within which it is looked for."""
HALVINGS = 2
"""Of a step on which a peak is lost, before the range is swept."""
LOOSE = 4.0
"""Steps of that sweep, beside those of a curve that is drawn: its tops are refined."""
ENOUGH = 1e-4
"""Distance from a peak, in half-widths: its amplitude is right to the square of that."""
_Rate = tuple[float, Floats]
"""What a peak's circular frequency, rad/s, and w, m, change by over a step."""


@dataclass(frozen=True)
class _CountedResonance(Resonance):
    """A resonance that keeps where it was solved, rad/s, whether a peak was found or lost."""

    read_at: list[float] = field(default_factory=list)

    def read(self, omega: float, start: Floats, fields: Kept | None = None) -> CurvePoint | None:
        """Solve at a frequency, rad/s; None if that fails."""
        self.read_at.append(omega)
        return super().read(omega, start, fields)


@dataclass
class Peaks:
    """The peaks of one output over a range of frequencies.

    Attributes
    ----------
    model : Rejoined
        The study.
    parameters : sequence of FitParameter
        What varies.
    near : (float, float)
        The range, Hz.
    slider : (c, 2) float, optional
        Where sliders are assembled, m; those that stick for good are held there.
    followed : list of CurvePoint
        Those of the last values, which the next ones are looked for from.
    followed_x : (p,) float
        The last values, x.
    met : list of ((p,) float, CurvePoint)
        Places at which the range had a peak that none had followed, and that peak.
    solved : int
        Frequencies solved.
    """

    model: Rejoined
    parameters: Sequence[FitParameter]
    near: tuple[float, float]
    slider: Floats | None = None
    followed: list[CurvePoint] = field(default_factory=list)
    followed_x: Floats = field(default_factory=lambda: np.zeros(0))
    met: list[tuple[Floats, CurvePoint]] = field(default_factory=list)
    solved: int = 0

    def values(self, x: Floats) -> dict[str, float]:
        """Values by key."""
        return by_key(self.parameters, values_of(self.parameters, x))

    def with_one_harmonic(self) -> "Peaks":
        """The same study with one harmonic."""
        return Peaks(replace(self.model, harmonics=1), self.parameters, self.near)

    def assembled_at(self, slider: Floats) -> "Peaks":
        """The same study with its sliders, (c, 2) m, assembled elsewhere."""
        return Peaks(self.model, self.parameters, self.near, slider)

    def _ready(self, x: Floats) -> PreparedSystem:
        return self.model.prepared(self.values(x), self.near, self.slider)

    @property
    def component(self) -> tuple[int, int]:
        """Output node and direction."""
        return self.model.monitor.node, self.model.monitor.component

    def led_by(self, peaks: Sequence[CurvePoint], x: Floats) -> None:
        """Begin with peaks of fewer harmonics at x, the others zero."""
        self.followed, self.followed_x = [], x
        length = 2 * self.model.harmonics + 1
        for peak in peaks:
            w = np.zeros((*peak.solution.w.shape[:2], length))
            w[:, :, : peak.solution.w.shape[2]] = peak.solution.w
            self.followed.append(replace(peak, solution=replace(peak.solution, w=w, reuse=None)))

    @one_thread
    def __call__(self, x: Floats, afresh: bool = False) -> Functions | None:
        """Amplitudes of the peaks, m, and their gradients; None where no peak is found.

        They are followed from the place before; `afresh`, those of the whole range, and of the
        known ones those that a sweep leaves out. A peak that is low here may be the highest a step
        away; one that is met here alone is looked for again wherever the search comes near.
        """
        ready = self._ready(x)
        known = self._followed(self.followed_x, x, ready, self.followed)
        if afresh:
            swept = self._swept(ready)
            self.met += [(x, each) for each in swept if _is_new(each, known)]
            others = [each for each in known if _is_new(each, swept)]
            return self._functions(ready, x, [*swept, *others])
        found = known or self._swept(ready)
        for place, peak in self.met:
            if np.abs(x - place).max() < NEAR:
                again = self._followed(place, x, ready, [peak])
                found += [each for each in again if _is_new(each, found)]
        return self._functions(ready, x, found)

    def moved(self, x: Floats) -> list[CurvePoint]:
        """The known peaks at x, which is close; none where one is lost."""
        return self._followed(self.followed_x, x, self._ready(x), self.followed)

    def _functions(
        self, ready: PreparedSystem, x: Floats, curve_points: list[CurvePoint]
    ) -> Functions | None:
        sizes, gradients = [], []
        values, held = self.values(x), self.slider is not None
        stretch = [each.stretch(values[each.key]) for each in self.parameters]
        for peak in curve_points:
            gradient = amplitude_gradient(ready, peak.solution, self.component, held)
            if gradient is not None:
                known = effects(gradient, "joints", {})
                sizes.append(peak.amplitude)
                gradients.append([known[each.key] for each in self.parameters])
        if not sizes:
            return None
        self.followed, self.followed_x = curve_points, x
        return Functions(np.array(sizes), np.array(gradients) * stretch)

    def _followed(
        self,
        begin: Floats,
        end: Floats,
        ready: PreparedSystem,
        curve_points: Sequence[CurvePoint],
        rates: Sequence[_Rate] = (),
        halvings: int = HALVINGS,
    ) -> list[CurvePoint]:
        """Known peaks at the end of a step, halved where one is lost; none if one stays lost."""
        found = self._stepped(ready, curve_points, rates)
        if found or not curve_points or not halvings:
            return found
        middle = (begin + end) / 2
        between = self._ready(middle)
        slower = [(omega / 2, w / 2) for omega, w in rates]
        half = self._followed(begin, middle, between, curve_points, slower, halvings - 1)
        if not half:
            return []
        gone = [
            (b.solution.omega - a.solution.omega, b.solution.w - a.solution.w)
            for a, b in zip(curve_points, half, strict=True)
        ]
        return self._followed(middle, end, ready, half, gone, halvings - 1)

    def _stepped(
        self, ready: PreparedSystem, curve_points: Sequence[CurvePoint], rates: Sequence[_Rate]
    ) -> list[CurvePoint]:
        """Peaks near known ones, or where their rates lead; none where one is lost."""
        family, tolerance = ready.solver.family, ready.options.tolerance
        resonance = _CountedResonance(family, self.component, tolerance, ENOUGH)
        still: list[_Rate] = [(0.0, np.zeros(1))]
        found: list[CurvePoint] = []
        for i, last in enumerate(curve_points):
            omega, w = last.solution.omega, last.solution.w
            peak = None
            for faster, moved in [*rates[i : i + 1], *still]:
                peak = resonance.peak(omega + faster, w + moved, last.bend, last.solution.reuse)
                if peak is not None:
                    break
            beyond = peak is None or not self.near[0] < peak.solution.omega / TURN < self.near[1]
            if peak is None or beyond or not _is_new(peak, found):
                found = []  # lost, or fallen onto another one
                break
            found.append(peak)
        self.solved += len(resonance.read_at)
        return found

    def _swept(self, ready: PreparedSystem) -> list[CurvePoint]:
        """All peaks of the range that may count."""
        system = ready.structure.system
        unvaried = Parameter("force", np.zeros(system.contacts.count, bool), False)
        low, high = (TURN * each for each in self.near)
        track = PeakTrack(lambda _: ready, unvaried, (low, high), self.component, 1.0, CONDITION)
        swept = track.sweep(1.0, LOOSE)
        found = track.tops(1.0, swept, 1 - LOWEST)
        self.solved += len(swept) + sum(each.readings for each in found)
        return found


def _is_new(peak: CurvePoint, others: Sequence[CurvePoint]) -> bool:
    """Whether a peak is none of the others of the same response."""
    omega = peak.solution.omega
    apart = (abs(omega - each.solution.omega) / min(peak.width, each.width) for each in others)
    return all(each > SAME for each in apart)
