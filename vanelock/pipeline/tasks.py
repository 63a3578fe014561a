"""Products made by other processes, which put them into the cache: handed out, tried again, listed.

A task holds a picklable function from which the same steps, and so the same keys, follow in every
process. What it starts from and what it makes is in the cache's folder, which all of them share. A
task that fails is tried once more; what then still fails is reported, with all that waits for it,
and the rest goes on.
"""

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from vanelock.common.errors import FolderError, InputError
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Listener, Notice, Tasks, silent
from vanelock.pipeline.step import Stages, Step, reachable

ATTEMPTS = 2
"""How often a task is tried."""
PATIENCE = 1.0
"""Seconds after which the display is updated again."""


Work: TypeAlias = Callable[[], Iterable[Step[Any]]]
"""Something picklable that gives the same steps in every process, without all that they need."""


class Workers(Protocol):
    """An executor of `concurrent.futures` that knows how many tasks it can do at a time."""

    @property
    def slots(self) -> int:
        """How many tasks may be out."""
        ...

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Have a function called by another process."""
        ...

    def shutdown(self) -> None:
        """Stop all work at once."""
        ...


@dataclass(frozen=True)
class Task:
    """Products to make.

    Attributes
    ----------
    name : str
        What lists call it.
    work : callable
        Gives the steps.
    keys : tuple of str
        Keys of the products.
    users : frozenset of int
        Who needs them; tasks whose products all of these and others need are done before.
    counts : bool
        Whether it counts in the progress, or only makes what others need.
    """

    name: str
    work: Work
    keys: tuple[str, ...]
    users: frozenset[int]
    counts: bool = True


@dataclass(frozen=True)
class Failure:
    """Why there is no product.

    Attributes
    ----------
    reason : str
        One line.
    attempts : int
        How often it was tried.
    refused : bool
        Whether another try is in vain, as where the input is to blame.
    unfit : bool
        Whether the worker is to blame, which is asked for nothing more.
    """

    reason: str
    attempts: int = 1
    refused: bool = False
    unfit: bool = False


class TaskFailed(Exception):
    """A product that a failed task should have made."""

    def __init__(self, failure: Failure) -> None:
        super().__init__(failure.reason)
        self.failure = failure


class Killed(Exception):
    """How a process ended that was at a task."""


class TaskQueue:
    """Tasks under way, in the order in which they are wanted.

    Its `listener` is called with how many are done, with the largest `peak` so far, m, and `idle`
    whenever it waits; `folder` is that of the cache.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        workers: Workers,
        folder: Path,
        listener: Listener,
        peak: Callable[[], float] = lambda: 0.0,
        idle: Callable[[], object] = lambda: None,
    ) -> None:
        self.workers, self._folder, self._listener = workers, folder, listener
        self._peak, self._idle = peak, idle
        self._task = {key: task for task in tasks for key in task.keys}
        self._waiting = list(tasks)
        self._shared = {task.users for task in tasks if len(task.users) > 1}
        self._out: dict[Future[Failure | None], Task] = {}
        self._made: set[str] = set()
        self._failed: dict[str, Failure] = {}
        self._attempts: Counter[str] = Counter()
        self._done, self._total = 0, sum(task.counts for task in tasks)
        self._began = self._shown = self._ended = time.monotonic()

    def bring(self, key: str) -> bool:
        """Wait until a product is in the cache; False where no task makes it."""
        if key not in self._task:
            return False
        while key not in self._made:
            if key in self._failed:
                raise TaskFailed(self._failed[key])
            self._hand_out()
            for future in wait(self._out, PATIENCE, FIRST_COMPLETED).done:
                self._take(self._out.pop(future), future)
            self._idle()
            self._tell()
        return True

    def _hand_out(self) -> None:
        """Send what waits for nothing."""
        free = self.workers.slots - len(self._out)
        for task in list(self._waiting):
            if free <= 0:
                return
            if not any(users > task.users for users in self._shared):
                free -= 1
                self._waiting.remove(task)
                sent = _solve, task.work, task.keys, str(self._folder)
                self._out[self.workers.submit(*sent)] = task

    def _take(self, task: Task, future: Future[Failure | None]) -> None:
        """Note what became of a task; try it again where that may help."""
        try:
            failure = future.result()
        except FolderError:
            raise
        except Exception as error:
            failure = failure_of(error)
        if failure is None:
            self._made.update(task.keys)
        else:
            self._attempts[task.keys[0]] += not failure.unfit
            failure = replace(failure, attempts=self._attempts[task.keys[0]])
            if not failure.refused and failure.attempts < ATTEMPTS:
                self._listener(Notice(f"{task.name}: {failure.reason}; trying again"))
                self._waiting.append(task)
                return
            self._fail(task, failure)
        self._shared.discard(task.users)
        self._done += task.counts
        self._ended = time.monotonic() if task.counts else self._ended
        self._tell(bool(task.counts))

    def _fail(self, task: Task, failure: Failure) -> None:
        """List a task, and all that would have followed on it, as failed."""
        after = [each for each in self._waiting if each.users < task.users]
        for each in (task, *after):
            self._failed.update(dict.fromkeys(each.keys, failure))
            self._shared.discard(each.users)
        self._waiting = [each for each in self._waiting if each not in after]
        self._done += sum(each.counts for each in after)

    def _tell(self, now: bool = False) -> None:
        """Say how far the tasks are."""
        if not now and time.monotonic() - self._shown < PATIENCE:
            return
        self._shown = time.monotonic()
        lost = len({self._task[key].name for key in self._failed})
        left = self._left(self._shown)
        self._listener(Tasks(self._done, self._total, lost, self._peak(), left))

    def _left(self, now: float) -> float:
        """Seconds left at the rate of those that ended; NaN where that is unknown.

        When all have ended, too: then the process that runs the study goes on with what it keeps
        for itself.
        """
        if not 0 < self._done < self._total:
            return float("nan")
        rate = (self._ended - self._began) / self._done
        left = rate * (self._total - self._done) - (now - self._ended)
        return left if left > 0 else float("nan")


_busy = threading.Lock()
"""The mesher and the products in memory are for one task at a time."""
_stages: dict[str, Stages] = {}
"""By folder, what a process keeps for the next task."""


def _solve(work: Work, keys: Sequence[str], folder: str) -> Failure | None:
    """Put products into the cache of a folder; why not, where they are not there afterwards."""
    with _busy:
        if folder not in _stages:
            _stages[folder] = Stages(Cache(Path(folder), lambda text: None), silent)
        stages = _stages[folder]
        try:
            steps = {step.key: step for step in reachable(work())}
            stages.retain(steps.values())
            if any(key not in steps for key in keys):
                raise InputError("a file is not the same here as where the tasks come from")
            for key in keys:
                stages.get(steps[key])
        except FolderError:
            raise
        except Exception as error:
            stages.retain(())  # memory may be short
            return failure_of(error)
    return None


def failure_of(error: BaseException) -> Failure:
    """An error in one line."""
    lines = str(error).strip().splitlines()
    if isinstance(error, InputError):
        return Failure(lines[0] if lines else "refused", refused=True)
    if isinstance(error, MemoryError):
        return Failure("out of memory")
    if isinstance(error, Killed):
        return Failure(lines[0])
    if (kind := type(error).__name__) == "KilledWorker":  # Dask has tried it on several
        return Failure("each of the workers that tried it was killed", refused=True)
    return Failure(f"{kind}: {lines[0]}" if lines else kind)
