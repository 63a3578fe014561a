"""A case of a sweep: what is computed of it, and what if that fails."""

from collections.abc import Callable
from typing import TypeVar

from vanelock.common.errors import FolderError, InputError
from vanelock.pipeline.executor.tasks import Failure, TaskFailed, reason
from vanelock.pipeline.step import Stages

A = TypeVar("A")
C = TypeVar("C")
TRIES = 2
"""How often this process tries what fails."""


def attempt(compute: Callable[[A], C], planned: A, name: str, stages: Stages) -> C:
    """Compute something of a case of a sweep, twice if need be."""
    failure = Failure(name, "")
    for tries in range(1, TRIES + 1):
        try:
            return compute(planned)
        except (TaskFailed, FolderError):
            raise
        except InputError as error:
            refused = Failure(name, reason(error), tries, refused=True)
            raise TaskFailed(refused) from None
        except Exception as error:
            failure = Failure(name, reason(error), tries)
            stages.keep(())  # what is kept is in the cache too, and memory may be short
    raise TaskFailed(failure)
