"""A case of a sweep: what is computed of it, and what if that fails."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from vanelock.common.errors import FolderError
from vanelock.pipeline.step import Stages
from vanelock.pipeline.tasks import ATTEMPTS, Failure, TaskFailed, failure_of

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
