"""A case of a sweep: what is computed of it, and what if that fails."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from vanelock.common.errors import FolderError, InputError
from vanelock.nonlinear import Response
from vanelock.pipeline.executor.tasks import Failure, TaskFailed, reason
from vanelock.pipeline.step import Stages
from vanelock.stages.accuracy.errors import Errors
from vanelock.stages.accuracy.left_out import LeftOut
from vanelock.stages.campbell.campbell import Campbell
from vanelock.stages.parts.by_cause import LoadsByCause
from vanelock.stages.parts.gauges import Strain
from vanelock.stages.plan import Planned

A = TypeVar("A")
C = TypeVar("C")
TRIES = 2
"""How often this process tries what fails."""


@dataclass(frozen=True)
class Solved:
    """What is computed of a case.

    Attributes
    ----------
    planned : Planned
        As solved.
    static, response : Response
        At rest and vibrating.
    strain : Strain or None
        What gauges read.
    worth : (Errors, list of LeftOut) or None
        Estimated errors, with an accuracy.
    campbell : Campbell or None
        Its Campbell diagram, unless another case has the same.
    other : Response or None
        Vibrating in the other direction of the sweep, where both are wanted; no higher.
    by_cause : LoadsByCause or None
        The joints' loads at rest, where other things than interference press them.
    """

    planned: Planned
    static: Response
    response: Response
    strain: Strain | None
    worth: tuple[Errors, Sequence[LeftOut]] | None
    campbell: Campbell | None
    other: Response | None = None
    by_cause: LoadsByCause | None = None


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
