"""One solution after another: a list of frequencies, or a range sampled as the curve needs it.

Solved points are written down as they come: a response that was stopped takes them up again. A
point is known by what is asked: the number of harmonics, the frequency, and where the neighbours
lie. Where it was solved before, its unknowns are put into the equations, which say whether they
solve them; so the points of a response do not depend on what was written down.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol, TypeAlias, TypeVar, cast

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import Frequencies, fixed
from vanelock.nonlinear.continuation.globalisation import EFFORT, Effort, at_once, from_nothing
from vanelock.nonlinear.forced_response.response import half_peak_to_peak
from vanelock.nonlinear.fourier import TURN, to_complex
from vanelock.nonlinear.newton.newton import Solution, sensitivity, solve

_BEND = 0.06
"""How far, relatively, the amplitude may leave the line through the last two points. The curve then
leaves the chord between two points by about an eighth of that."""

_FAR = 8.0
"""How far back, in steps of the sweep, a path is followed behind a fold. What lies beyond is sooner
found afresh, as the structure does that jumps."""

_JUMP = 400  # of the range: how closely a jump of the response is located
_ELSEWHERE = (0.8, 1.25, 0.5, 2.0, 3.0)  # frequencies to come from where nothing else helps
_WAY, _CLOSE = 600, 1e-4  # Newton steps and shortest step on the way from there


S = TypeVar("S", bound=Solution | None)


class PointStore(Protocol):
    """Points by label: some numbers, and the unknowns of each."""

    def get(self, label: str) -> tuple[Sequence[float], Floats] | None:
        """What was written of a point; None where nothing was."""

    def add(self, label: str, numbers: Sequence[float], unknowns: Floats) -> None:
        """Write a point down."""


def once(
    store: PointStore | None,
    question: str,
    harmonics: int,
    omega: float,
    history: Sequence[Solution],
    check: Callable[[Floats], Solution],
    compute: Callable[[], S],
) -> S:
    """The solution at a frequency, rad/s: checked where it was written down, else computed."""
    if store is None:
        return compute()
    about = [omega, *(x for each in history for x in (each.omega, np.linalg.norm(each.w)))]
    label = f"{question} {harmonics} " + " ".join(f"{x:.9g}" for x in about)
    if (written := store.get(label)) is not None:
        (iterations, continued, seconds), w = written
        if not w.size:
            return cast(S, None)  # it was not found, nor is it now
        checked = check(w)
        if checked.converged:
            known = replace(checked, parameter=omega, seconds=seconds)
            known = replace(known, iterations=int(iterations), continued=bool(continued))
            return cast(S, known)
    solution = compute()
    if solution is None:
        store.add(label, (0, 0, 0), np.empty(0))
    elif solution.converged:
        numbers = solution.iterations, solution.continued, solution.seconds
        store.add(label, numbers, solution.w)
    return solution


Progress: TypeAlias = Callable[[int, int, float, float], None]


@dataclass
class PointsDone:
    """Passes on how many points are done of how many, and which one takes long."""

    progress: Progress | None
    done: int = 0
    total: int = 1

    def __call__(self, omega: float, amplitude: float, expected: int) -> None:
        """One more is done, of so many that are expected in all."""
        self.done += 1
        self.total = max(expected, self.done)
        self._say(omega, amplitude, self.total)

    def searching(self, omega: float) -> None:
        """One is looked for by ways that may take long."""
        self._say(omega, float("nan"), max(self.total, self.done + 1))

    def _say(self, omega: float, amplitude: float, total: int) -> None:
        if self.progress is not None:
            self.progress(self.done, total, omega / TURN, amplitude)


@dataclass
class StepControl:
    """Steps along a curve from `here` to `end`, by how far each leaves where the last ones led.

    That error is 1 where it is as large as a step should allow; one of up to `forgiven` is taken.
    `change` are the least and the most that a step changes by at once.
    """

    here: float
    end: float
    step: float
    finest: float
    longest: float
    change: tuple[float, float]
    forgiven: float = 1.0

    @property
    def ahead(self) -> float:
        """Where the next step leads."""
        left = self.end - self.here
        whole = self.step >= 0.999 * abs(left)
        return self.end if whole else self.here + float(np.sign(left)) * self.step

    def shortened(self, least: float, shortest: float | None = None) -> bool:
        """Whether a step that failed can be shorter, which then is the next one."""
        if self.step <= least:
            return False
        self.step = max(shortest or self.finest, self.change[0] * self.step)
        return True

    def taken(self, ahead: float, error: float) -> bool:
        """Whether a step is taken; if not it is shortened, else the next one follows the error."""
        if error > self.forgiven and self.step > self.forgiven * self.finest:
            self.step = max(self.finest, self.step * max(self.change[0], 0.8 / np.sqrt(error)))
            return False
        self.here, share = ahead, np.clip(0.9 / np.sqrt(max(error, 1e-9)), *self.change)
        self.step = float(np.clip(self.step * share, self.finest, self.longest))
        return True


@dataclass(frozen=True)
class PointSolver:
    """What solves one point after another.

    `law`: the contact law for a number of harmonics; `tolerance`: relative residual that counts as
    converged; `store`: where solved points are written down; `effort`: Newton steps that a point
    may take before it counts as not found; `searching`: called with a circular frequency, rad/s,
    whose solution is looked for by other ways than Newton's iteration from its neighbours, which
    may take long.
    """

    family: Frequencies
    law: Callable[[int], Law]
    tolerance: float
    store: PointStore | None = None
    effort: int = EFFORT
    searching: Callable[[float], None] = lambda _: None
    _amplitudes: dict[float, tuple[Floats, Floats]] = field(default_factory=dict, repr=False)
    """By circular frequency: w of the solution asked about last, and its amplitudes."""

    def sweep(self, omegas: Floats) -> Iterator[Solution]:
        """Solve at each frequency, rad/s, from its predecessors."""
        history: list[Solution] = []
        for omega in omegas:
            found = self.point(float(omega), history)
            yield found
            if found.converged:
                history = [*history, found][-2:]

    def explore(self, begin: float, end: float, loose: float = 1.0) -> Iterator[Solution]:
        """Solve from `begin` to `end`, rad/s, at steps that follow the curve.

        Steps are at most a fortieth of the range, at least an 80th of the half-power bandwidth;
        `loose` of them where tops are looked for that are refined afterwards.
        """
        bend = _BEND * loose
        span = abs(end - begin)
        ratio = self.family.structure.system.damping_ratio or 0.0
        finest = max(2 * ratio * min(begin, end) / 80 * loose, span / 5000)
        history = [self.point(begin, [])]
        yield history[0]
        steps = StepControl(begin, end, loose * span / 200, finest, loose * span / 40, (0.3, 1.5))
        closest = max(finest, loose * span / _JUMP)
        while steps.here != end:
            omega = steps.ahead
            known = [point for point in history if point.converged]
            smooth = self.easily(omega, known)
            if smooth is None and known and steps.shortened(closest):
                continue
            found = self.point(omega, known) if smooth is None else smooth
            if steps.taken(omega, 0.0 if smooth is None else self._bend(history, found) / bend):
                yield found
                history = [found] if smooth is None else [*history, found][-2:]

    def _bend(self, history: list[Solution], solution: Solution) -> float:
        """Relative distance of a new amplitude from the line through the last two."""
        if len(history) < 2:
            return 0.0
        a, b = (self.amplitude(point) for point in history)
        c = self.amplitude(solution)
        line = b + (b - a) * (solution.omega - history[1].omega) / (
            history[1].omega - history[0].omega
        )
        size = max(np.abs(b).max(initial=0.0), np.finfo(float).tiny)
        return float(np.abs(c - line).max(initial=0.0) / size)

    def amplitude(self, solution: Solution) -> Floats:
        """Half the peak-to-peak of every output; of the contacts where there is none, m."""
        w, known = self._amplitudes.get(solution.omega, (None, np.empty(0)))
        if w is solution.w:
            return known
        structure = self.family.structure
        if structure.system.output_names:
            moved = structure.output(structure.amplitudes(solution.omega, solution.w))
        else:
            moved = to_complex(solution.u)
        found = half_peak_to_peak(moved).reshape(-1)
        self._amplitudes[solution.omega] = solution.w, found
        return found

    def point(self, omega: float, history: list[Solution]) -> Solution:
        """Solve at one frequency, rad/s, given up to two converged neighbours, the nearest last."""
        return self._asked("point", omega, history, lambda: self._point(omega, history))

    def easily(self, omega: float, history: list[Solution]) -> Solution | None:
        """The same if Newton's iteration finds it at once; None if not."""

        def solved() -> Solution | None:
            tried = self._newton(omega, history)
            return counted(tried, omega) if tried and tried[-1].converged else None

        return self._asked("easily", omega, history, solved)

    def with_truncation(self, solution: Solution) -> Solution:
        """A solution with the relative error by modes that count by their static part alone."""
        missed = self.family.structure.left_out(solution.omega, solution.w)
        stiffness = self.family.friction.stiffness.reshape(-1)
        moved = sensitivity(self.family.at(solution.omega), solution, missed, stiffness)
        if moved is None:
            return replace(solution, truncation=np.inf)
        sizes = (np.abs(to_complex(each)[1:]).max(initial=0.0) for each in (moved, solution.u))
        wrong, largest = (float(size) for size in sizes)
        return replace(solution, truncation=wrong / largest if largest > 0 else 0.0)

    def along(self, omega: float, history: list[Solution]) -> Solution | None:
        """The same along the path from the neighbours alone; None if it does not lead there."""

        def solved() -> Solution | None:
            effort = Effort(self.effort, lambda: self.searching(omega))
            found = counted(self._along(omega, history, effort), omega)
            return found if found.converged else None

        return self._asked("along", omega, history, solved)

    def _asked(
        self, question: str, omega: float, history: list[Solution], compute: Callable[[], S]
    ) -> S:
        """A solution that was written down, put into the equations, or one computed and timed."""
        reuse = history[-1].reuse if history else None

        def check(w: Floats) -> Solution:
            problem = fixed(self.family.at(omega), self.family.friction)
            return solve(problem, w, 0.0, tolerance=self.tolerance, reuse=reuse)

        def timed() -> S:
            begin = time.process_time()
            found = compute()
            if found is None:
                return found
            return cast(S, replace(found, seconds=time.process_time() - begin))

        harmonics = self.family.structure.harmonics
        return once(self.store, question, harmonics, omega, history, check, timed)

    def _along(self, omega: float, history: list[Solution], effort: Effort) -> list[Solution]:
        """What Newton's iteration from the neighbours finds, or the path from there."""
        tried = [effort.spent(each) for each in self._newton(omega, history)]
        if tried[-1].converged:
            return tried
        effort.attempted()
        nearer = [effort.spent(each) for each in self._nearer(omega, history)]
        tried += nearer
        if nearer[-1].converged and nearer[-1].omega == omega:
            return tried
        reached = [each for each in (history[-1], *nearer) if each.converged][-1]
        far = _FAR * (omega - history[-1].omega) / (omega - reached.omega)
        arc = follow(
            self.family, reached, omega, self.tolerance, limit=60, effort=effort.left, away=far
        )
        effort.left -= arc.iterations
        if arc.solution is not None:
            tried.append(replace(arc.solution, continued=not arc.folds))
        return tried

    def _point(self, omega: float, history: list[Solution]) -> Solution:
        effort, tried = Effort(self.effort, lambda: self.searching(omega)), list[Solution]()
        if history:
            tried = self._along(omega, history, effort)
            if (found := counted(tried, omega)).converged:
                return found
        afresh = from_nothing(self.family.at(omega), self.law, self.tolerance, effort)
        tried.append(replace(afresh, continued=not history))
        if not history and not tried[-1].converged:
            tried += self._from_elsewhere(omega, effort)
        return counted(tried, omega)

    def _newton(self, omega: float, history: list[Solution]) -> list[Solution]:
        """Newton's iteration from what the history suggests; the last one tried may converge."""
        problem = fixed(self.family.at(omega), self.family.friction)
        reuse = history[-1].reuse if history else None
        tried: list[Solution] = []
        for start in starts(omega, history):
            found = solve(problem, start, 0.0, tolerance=self.tolerance, reuse=reuse)
            tried.append(replace(found, parameter=omega))
            if found.converged:
                break
        return tried

    def _nearer(self, omega: float, history: list[Solution]) -> list[Solution]:
        """Towards a frequency by quarters of the step; ends where one is not solved."""
        tried: list[Solution] = []
        begin = history[-1].omega
        for share in (0.25, 0.5, 0.75, 1.0):
            at = omega if share == 1.0 else begin + share * (omega - begin)
            found = self._newton(at, history)
            tried += found
            if not found[-1].converged:
                break
            history = [*history, found[-1]][-2:]
        return tried

    def _from_elsewhere(self, omega: float, effort: Effort) -> Iterator[Solution]:
        """From the first of some other frequencies that can be solved at once, along the path."""
        for ratio in _ELSEWHERE:
            if effort.left <= 0:
                return
            effort.attempted()
            begin = ratio * omega
            found = effort.spent(at_once(self.family.at(begin), self.law, self.tolerance))
            if not found.converged:
                continue
            begun = replace(found, parameter=begin)
            most = min(_WAY, effort.left)
            arc = follow(self.family, begun, omega, self.tolerance, effort=most, shortest=_CLOSE)
            effort.left -= arc.iterations
            if arc.solution is not None:
                yield arc.solution
                return


def starts(parameter: float, history: Sequence[Solution]) -> Iterator[Floats]:
    """First guesses: along the secant of the last two solutions, and the last one."""
    if len(history) == 2 and history[0].parameter != history[1].parameter:
        a, b = history
        yield b.w + (parameter - b.parameter) / (b.parameter - a.parameter) * (b.w - a.w)
    if history:
        yield history[-1].w


def counted(tried: Sequence[Solution], parameter: float) -> Solution:
    """The best of some attempts at a value, with the iterations of all on the way there."""
    there = [each for each in tried if each.parameter == parameter]
    best = min(there, key=lambda solution: (not solution.converged, solution.residual))
    return replace(best, iterations=sum(each.iterations for each in tried))
