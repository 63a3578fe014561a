"""The peak of a resonance itself: where the amplitude of an output is stationary in frequency.

With A half the peak-to-peak of an output q(θ) = Re Σ_h q^(h) e^{ihθ}, at its extrema θ₁ and θ₂,

    dA/dω = (q_ω(θ₁) - q_ω(θ₂)) / 2,      q_ω^(h) = dq^(h)/dω along the solutions,

since q is stationary at both angles. How far a frequency is from the peak is measured in
half-widths of the peak, δ = (-A/A'')^½ (half the half-power bandwidth, if the resonance is linear):
the condition is A' δ / A = 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.continuation.arc_length import locate
from vanelock.nonlinear.continuation.families import Frequencies, fixed
from vanelock.nonlinear.continuation.path import SolutionPath, Tangent, tangent_at
from vanelock.nonlinear.forced_response.response import amplitude_and_slope
from vanelock.nonlinear.fourier import to_complex
from vanelock.nonlinear.newton.newton import Solution, refined
from vanelock.nonlinear.newton.preconditioner import Kept

CONDITION = 1e-8
"""Distance from the peak, in its half-widths, that counts as converged."""
_LIMIT = 25
_LOWER = 1e-6  # how much lower, relatively, than its neighbours on the path a peak may be found
_HIGHEST = 1e3
"""How much higher than where it began a sharp peak may be: further up, nothing bounds it."""
_FALL = 1.0  # change of ln A between two frequencies beyond which they are not taken for one branch


@dataclass(frozen=True)
class CurvePoint:
    """A solved point of a resonance curve, by one output: A, m, and `slope` dA/dω, m s/rad.

    Of its peak also `bend` A''/A < 0, s²/rad², and `distance` A' δ / A that is left; `sharp` is
    one where a contact changes its state and the slope jumps over zero. The solution's
    `iterations` count all that led there, `readings` are frequencies solved. Along a parameter
    the peak is that at `value`, whose coordinate is `coordinate`.
    """

    solution: Solution
    amplitude: float
    bend: float = np.nan
    distance: float = np.inf
    readings: int = 1
    sharp: bool = False
    slope: float = np.nan
    tangent: Tangent | None = None
    coordinate: float = 0.0
    value: float = 0.0

    @property
    def exact(self) -> bool:
        """Whether the extremum condition is solved, or the peak is sharp."""
        return self.sharp or self.distance < CONDITION

    @property
    def omega(self) -> float:
        """rad/s."""
        return self.solution.omega

    @property
    def width(self) -> float:
        """Half-width δ of a peak, rad/s."""
        return float(1 / np.sqrt(-self.bend))

    def led_to_by(
        self, points: Sequence["CurvePoint"], swept: Sequence[Solution] = ()
    ) -> "CurvePoint":
        """The same with the cost of all points and solutions that led to it."""
        spent = sum(each.iterations for each in (*swept, *(point.solution for point in points)))
        readings = len(swept) + sum(point.readings for point in points)
        return replace(self, solution=replace(self.solution, iterations=spent), readings=readings)


@dataclass(frozen=True)
class Resonance:
    """The amplitude of one output, node and direction, by frequency.

    `tolerance` is of the solutions' residuals, `condition` of the distance from the peak.
    """

    family: Frequencies
    component: tuple[int, int]
    tolerance: float
    condition: float = CONDITION

    def measure(self, solution: Solution, tangent: Tangent) -> tuple[float, float]:
        """A and dA/dω at a solution."""
        prepared, omega = self.family.structure, solution.omega
        stiffness = prepared.stiffness
        moved = to_complex(tangent.z.reshape(-1, tangent.z.shape[2]))
        q = np.zeros((2, prepared.harmonics + 1), complex)
        for h, amplitude in enumerate(prepared.amplitudes(omega, solution.w)):
            modes = prepared.at(h)
            row = prepared.output_rows[h][self.component]
            changed = modes.pull @ (stiffness * moved[h])
            rate = prepared.push_rate(h, omega, amplitude)
            q[0, h] = row @ amplitude
            q[1, h] = row @ modes.solve(h * omega, changed if rate is None else changed + rate)
        return amplitude_and_slope(*q)

    def read(self, omega: float, start: Floats, reuse: Kept | None = None) -> CurvePoint | None:
        """Solve at a frequency, rad/s; None if that fails."""
        balance = self.family.at(omega)
        held = fixed(balance, self.family.friction)
        found = refined(held, start, 0.0, tolerance=self.tolerance, reuse=reuse)
        if not found.converged:
            return None
        return self.reading(replace(found, parameter=omega), balance)

    def reading(self, solution: Solution, balance: Balance | None = None) -> CurvePoint | None:
        """Amplitude and slope of a solution, its balance known or not; None where a path turns."""
        tangent = tangent_at(self.family, solution, balance)
        if tangent is None:
            return None
        amplitude, slope = self.measure(solution, tangent)
        return CurvePoint(solution, amplitude, slope=slope, tangent=tangent)

    def peak(
        self, omega: float, start: Floats, bend: float, reuse: Kept | None = None
    ) -> CurvePoint | None:
        """The peak near a frequency, by a safeguarded secant of the slope, from guesses.

        Of ω, of w there and of `bend`, A''/A; None where solutions are lost or no maximum is near.
        """
        first = self.read(omega, start, reuse)
        if first is None:
            return None
        found = self._secant(first, bend)
        if found is not None and not found.sharp:
            return found
        found = self._climb(first, bend) or found
        return found if found and found.amplitude < _HIGHEST * first.amplitude else None

    def _secant(self, begin: CurvePoint, bend: float) -> CurvePoint | None:
        here, known, omega_of = begin, [begin], attrgetter("omega")
        for _ in range(_LIMIT):
            if len(known) > 1:
                before = known[-2]
                span = here.omega - before.omega
                bend = (here.slope - before.slope) / span / here.amplitude
            width = 1 / np.sqrt(abs(bend))
            distance = here.slope * width / here.amplitude
            if abs(distance) < self.condition and bend < 0:
                found = replace(here, bend=bend, distance=abs(distance))
                return found.led_to_by(known)
            rising = max((r for r in known if r.slope > 0), key=omega_of, default=None)
            falling = min((r for r in known if r.slope < 0), key=omega_of, default=None)
            step = -here.slope / (here.amplitude * bend) if bend < 0 else np.sign(distance) * width
            omega = here.omega + float(np.clip(step, -2 * width, 2 * width))
            if rising is not None and falling is not None:
                low, high = rising.omega, falling.omega
                if not 0 < high - low:
                    return None  # two maxima with a minimum between them
                if high - low < max(1e-13 * high, self.condition**2 * width):
                    if abs(np.log(rising.amplitude / falling.amplitude)) > _LOWER:
                        return None  # not a kink but a fold
                    best = max(rising, falling, key=lambda reading: reading.amplitude)
                    found = replace(best, bend=bend, distance=abs(distance), sharp=True)
                    return found.led_to_by(known)
                slow = len(known) > 8 and len(known) % 2
                if slow or not low < omega < high:
                    omega = 0.5 * (low + high)
            assert here.tangent is not None
            along = here.tangent.z * (omega - here.omega)
            following = self.read(omega, here.solution.w + along, here.solution.reuse)
            if following is None or omega == here.omega:
                return None
            if abs(np.log(following.amplitude / here.amplitude)) > _FALL:
                return None
            here = following
            known.append(here)
        return None

    def _climb(self, begin: CurvePoint, bend: float) -> CurvePoint | None:
        """The peak uphill of a reading along the path of solutions, folds or not.

        The path climbs as long as dA/ds = dA/dω · dω/ds > 0.
        """
        width = 1 / np.sqrt(abs(bend))
        target = begin.omega + float(np.sign(begin.slope)) * 8 * width
        begun = replace(begin.solution, parameter=begin.omega)
        spent, before, last, course, highest = 0, None, 0.0, 0.0, 0.0

        def rise(solution: Solution, tangent: Tangent) -> float:
            """DA/ds but for a positive factor; s goes with the sign of det P on this course."""
            nonlocal highest
            highest, slope = self.measure(solution, tangent)
            size = np.hypot(np.linalg.norm(tangent.z) * scale, 1.0)
            return float(course * tangent.orientation * slope / size)

        scale = width / max(np.abs(begin.solution.u).max(initial=0.0), np.finfo(float).tiny)
        for count, step in enumerate(SolutionPath(self.family, begun, target, 0.2)):
            spent += step.solution.iterations
            turned = course
            course = float(np.sign(step.rate) * step.tangent.orientation)
            now = rise(step.solution, step.tangent)
            if before is not None and now <= 0:
                break
            before, last = step, now
            if count > 4 * _LIMIT or highest > _HIGHEST * begin.amplitude:
                return None
        else:
            return None
        if not last > 0 or course != turned:
            return None  # it never rose, or crossed another branch where it ceased to
        found = locate(self.family, before, step, rise, (last, now), self.tolerance)
        if found is None:
            return None
        amplitude, slope = self.measure(found.solution, found.tangent)
        ends = [self.measure(end.solution, end.tangent)[0] for end in (before, step)]
        if amplitude < (1 - _LOWER) * max(ends):
            return None
        for end in (before, step):  # a kink is no maximum as seen from its own side
            span = end.solution.omega - found.solution.omega
            beside = self.measure(end.solution, end.tangent)[1]
            bend = (beside - slope) / span / amplitude if span else np.nan
            if bend < 0:
                break
        else:
            return None
        distance = abs(slope) / np.sqrt(-bend) / amplitude
        total = replace(found.solution, iterations=spent + found.solution.iterations)
        return CurvePoint(total, amplitude, bend, distance, found.spent, distance > self.condition)
