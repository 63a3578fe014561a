"""Solved points written down as they come: a response that was stopped takes them up again.

A point is known by what is asked: the number of harmonics, the frequency, and where the neighbours
lie. Where it was solved before, its unknowns are put into the equations, which say whether they
solve them; so the points of a response do not depend on what was written down.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar, cast

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.nonlinear.newton.newton import Solution

S = TypeVar("S", bound=Solution | None)


class PointStore(Protocol):
    """Points by label: some numbers, and the unknowns of each."""

    def get(self, label: str) -> tuple[Sequence[float], Floats] | None:
        """What was written of a point; None where nothing was."""

    def add(self, label: str, numbers: Sequence[float], unknowns: Floats) -> None:
        """Write a point down."""


@dataclass(frozen=True)
class SolvedPoints:
    """What asks for points, and writes them into a store, if there is one."""

    store: PointStore | None = None

    def __call__(
        self,
        question: str,
        harmonics: int,
        omega: float,
        history: Sequence[Solution],
        check: Callable[[Floats], Solution],
        compute: Callable[[], S],
    ) -> S:
        """The solution at a frequency, rad/s: checked where it was written down, else computed."""
        if self.store is None:
            return compute()
        about = [omega, *(x for each in history for x in (each.omega, np.linalg.norm(each.w)))]
        label = f"{question} {harmonics} " + " ".join(f"{x:.9g}" for x in about)
        if (written := self.store.get(label)) is not None:
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
            self.store.add(label, (0, 0, 0), np.empty(0))
        elif solution.converged:
            numbers = solution.iterations, solution.continued, solution.seconds
            self.store.add(label, numbers, solution.w)
        return solution
