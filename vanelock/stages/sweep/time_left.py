"""Cases of a sweep: peak so far and time left, and what is left of a case that fails."""

import time
from collections.abc import Callable, Collection
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from vanelock.common.errors import FolderError
from vanelock.input.cases.values import Given
from vanelock.pipeline.progress import PointDone
from vanelock.pipeline.step import Stages
from vanelock.pipeline.tasks import ATTEMPTS, Failure, TaskFailed, failure_of

if TYPE_CHECKING:
    from vanelock.nonlinear import Response
    from vanelock.pipeline.step import Step
    from vanelock.stages.plan import Planned

TYPICAL = 100
"""Points of a response over a range that chooses them itself."""


class Clock:
    """Stopwatch over all cases of a run."""

    def __init__(self, planned: "Collection[Planned]") -> None:
        self._adaptive = any(getattr(each.case.given, "accuracy", None) for each in planned)
        self._left = {
            step.key: work(each.case.given) for each in planned for step in each.responses
        }
        self._after = sum(self._left.values())
        self._done = 0.0
        self._seconds = 0.0
        self._began = time.perf_counter()
        self._name, self._own, self._peak = "", 0.0, 0.0

    def begin(self, planned: "Planned", response: "Step[Response] | None" = None) -> None:
        """A case begins, or another of its responses."""
        self._name, self._peak = planned.case.name, 0.0
        self._own = self._left.pop((response or planned.response).key, 0.0)
        self._after = max(self._after - self._own, 0.0)
        self._began = time.perf_counter()

    def end(self, computed: bool) -> None:
        """It has its response, computed now or not."""
        if computed:
            self._seconds += time.perf_counter() - self._began
            self._done += self._own

    def point(self, done: int, total: int, frequency: float, amplitude: float) -> PointDone:
        """A point of it is solved; `amplitude` counts for the peak, m.

        It is NaN of one that is being looked for by ways that may take long. With an accuracy
        there are as many points as the errors ask for, which nobody knows before.
        """
        if amplitude != amplitude:
            known = None if self._adaptive else total
            return PointDone(self._name, done, known, self._peak, float("nan"), frequency)
        self._peak = max(self._peak, amplitude)
        if self._adaptive:
            return PointDone(self._name, done, None, self._peak, float("nan"))
        part = self._own * done / total
        pace = (self._seconds + time.perf_counter() - self._began) / max(self._done + part, 1e-9)
        left = pace * (self._own - part + self._after)
        return PointDone(self._name, done, total, self._peak, left)

    def count(self, done: int, total: int | None, amplitude: float) -> PointDone:
        """A step of the case's bounds or stability; its time left is not known."""
        peak = max(self._peak, amplitude) if amplitude == amplitude else self._peak
        return PointDone(self._name, done, total, peak, float("nan"))


def work(given: Given) -> float:
    """Relative cost of a response: the unknowns at a point grow with 2H + 1."""
    response = given.response
    points = len(response.frequencies) if response.frequencies else response.points or TYPICAL
    return float(points * (2 * response.harmonics + 1) ** 1.5)


A = TypeVar("A")
C = TypeVar("C")


def attempt(compute: Callable[[A], C], planned: A, name: str, stages: Stages) -> C:
    """Compute something of a case of a sweep, twice if need be."""
    failure = Failure(name, "")
    for tries in range(1, ATTEMPTS + 1):
        try:
            return compute(planned)
        except (TaskFailed, FolderError):
            raise
        except Exception as error:
            failure = replace(failure_of(error), task=name, attempts=tries)
            if failure.refused:
                break
            stages.keep(())  # what is kept is in the cache too, and memory may be short
    raise TaskFailed(failure)
