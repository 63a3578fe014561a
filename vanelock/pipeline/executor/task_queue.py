"""Tasks handed out to processes, near or far, and what they return taken into the cache.

Only the process that runs the study reads and writes its folder. Each task is tried again once when
it fails or its process dies; what then still fails is reported, with all that waits for it, and the
rest goes on.
"""

import time
from collections import Counter, deque
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field, replace
from typing import Protocol

from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor.tasks import Answer, Failure, Task, TaskFailed
from vanelock.pipeline.progress import Listener, Notice, Tasks

ATTEMPTS = 2
"""How often a task is tried."""
SPARED = 5
"""How often one is sent again that lost what it starts from, since that is not its fault."""
PATIENCE = 1.0
"""Seconds after which the display is updated again."""


class Executor(Protocol):
    """Processes that do tasks."""

    @property
    def slots(self) -> int:
        """How many tasks may be out at a time."""
        ...

    def submit(self, task: Task, image: Callable[[str, str], bytes | None]) -> Future[Answer]:
        """Have a task done; `image` reads a product that it starts from."""
        ...

    def failure(self, task: Task, error: Exception) -> Failure:
        """Why there is no answer to a task."""
        ...

    def forget(self, keys: Collection[str]) -> None:
        """No task to come starts from these products."""
        ...

    def close(self) -> None:
        """Stop all work at once."""
        ...


@dataclass
class TaskQueue:
    """Tasks under way.

    Attributes
    ----------
    tasks : sequence of Task
        In the order in which they are wanted.
    cache : Cache
        Where products come from and go to.
    executor : Executor
        Who does them.
    listener : callable
        Called with how many are done.
    peak : callable
        The largest peak so far, m.
    idle : callable
        Called whenever it waits.
    failed : dict of str to Failure
        Products that will not come, by key.
    moved : int
        Bytes read from the cache for others, and returned by them.
    """

    tasks: Sequence[Task]
    cache: Cache
    executor: Executor
    listener: Listener
    peak: Callable[[], float] = lambda: 0.0
    idle: Callable[[], object] = lambda: None
    failed: dict[str, Failure] = field(default_factory=dict)
    moved: int = 0

    def __post_init__(self) -> None:
        self._maker = {key: task for task in self.tasks for key in task.makes}
        self._waiting = deque(self.tasks)
        self._made: set[str] = set()
        self._lost: set[str] = set()
        self._attempts: Counter[str] = Counter()
        self._spared: Counter[str] = Counter()
        self._uses = Counter(key for task in self.tasks for _, key in task.given)
        self._out: dict[Future[Answer], Task] = {}
        self._total = sum(task.counts for task in self.tasks)
        self._done = 0
        self._began = self._told = self._ended = time.monotonic()

    def bring(self, key: str) -> bool:
        """Wait until a product is in the cache; False where no task makes it."""
        if key not in self._maker:
            return False
        while key not in self._made:
            self._hand_out()
            if key in self.failed:
                raise TaskFailed(self.failed[key])
            for future in wait(self._out, PATIENCE, FIRST_COMPLETED).done:
                self._take(self._out.pop(future), future)
            self.idle()
            self._tell()
        return True

    def _hand_out(self) -> None:
        """Send what can be done; fail what waits for something that failed."""
        held: deque[Task] = deque()
        slots = self.executor.slots
        while self._waiting and len(self._out) < slots:
            task = self._waiting.popleft()
            lost = next((self.failed[key] for key in task.after if key in self.failed), None)
            if lost is not None:
                self._fail(task, lost)
            elif all(key in self._made for key in task.after):
                self._out[self.executor.submit(task, self._image)] = task
            else:
                held.append(task)
        self._waiting.extendleft(reversed(held))

    def _image(self, stage: str, key: str) -> bytes | None:
        image = self.cache.image(stage, key)
        self.moved += len(image or b"")
        return image

    def _take(self, task: Task, future: Future[Answer]) -> None:
        try:
            answer = future.result()
        except Exception as error:
            answer = self.executor.failure(task, error)
        if isinstance(answer, Failure):
            self._retry(task, replace(answer, task=task.name))
            return
        for stage, key, image in answer:
            self.moved += len(image)
            if not self.cache.holds(stage, key):
                self.cache.adopt(stage, key, image)
        self._made.update(task.makes)
        self._end(task)

    def _retry(self, task: Task, failure: Failure) -> None:
        """Try a task again, where that may help and was not done often enough."""
        self._spared[task.makes[0]] += not failure.counts
        spared = not failure.counts and self._spared[task.makes[0]] <= SPARED
        self._attempts[task.makes[0]] += not spared
        attempts = self._attempts[task.makes[0]]
        if failure.again and not failure.refused and attempts < ATTEMPTS:
            self.listener(Notice(f"{task.name}: {failure.reason}; trying again"))
            self._waiting.append(task)
        else:
            self._fail(task, replace(failure, attempts=attempts))

    def _fail(self, task: Task, failure: Failure) -> None:
        self.failed.update(dict.fromkeys(task.makes, failure))
        self._lost.add(task.name)
        self._end(task)

    def _end(self, task: Task) -> None:
        self._done += task.counts
        if task.counts:
            self._ended = time.monotonic()
        self._uses.subtract(key for _, key in task.given)
        self.executor.forget([key for _, key in task.given if self._uses[key] <= 0])
        self._tell(bool(task.counts))

    def _tell(self, now: bool = False) -> None:
        """Say how far the tasks are."""
        if not now and time.monotonic() - self._told < PATIENCE:
            return
        self._told = time.monotonic()
        left = self._left(self._told)
        self.listener(Tasks(self._done, self._total, len(self._lost), self.peak(), left))

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
