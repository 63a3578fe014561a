"""Tasks done by processes of this machine.

Each is a pool of its own, so that it is known which task a process died with, and what it has been
sent before. A process ends with the one that started it, however that ends.
"""

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Callable, Collection, Generator, Sequence, Set
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import parent_process
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from typing import Any

from vanelock.common.process.memory import keep_freed
from vanelock.pipeline.executor.tasks import Answer, Failure, Task, Work, Worker, reason

_PR_SET_PDEATHSIG = 1


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


class Processes:
    """So many processes, started when there is something to do."""

    def __init__(self, count: int, journals: Path | None = None) -> None:
        self.slots, self._journals = count, journals
        self._processes: list[_Process] = []

    def submit(self, task: Task, image: Callable[[str, str], bytes | None]) -> Future[Answer]:
        """Have a task done by an idle process, one that knows most of what it starts from."""
        wanted = {key for _, key in task.given}
        idle = [each for each in self._processes if each.idle]
        if not idle:
            idle = [_Process(self._journals)]
            self._processes += idle
        return max(idle, key=lambda each: len(wanted & each.knows)).submit(task, image)

    def failure(self, task: Task, error: Exception) -> Failure:
        """How the process that a task was sent to ended."""
        if not isinstance(error, BrokenProcessPool):
            return Failure(task.name, reason(error))
        (process,) = [each for each in self._processes if each.task is task]
        self._processes.remove(process)
        return Failure(task.name, process.close())

    def forget(self, keys: Collection[str]) -> None:
        """Have all processes drop products with their next tasks."""
        for each in self._processes:
            each.knows.difference_update(keys)

    def close(self) -> None:
        """Kill all processes."""
        for each in self._processes:
            each.kill()
        for each in self._processes:
            each.close()
        self._processes = []


class _Process(SpawnContext):
    """A pool of one process: what it knows, and the task that it was sent last."""

    def __init__(self, journals: Path | None) -> None:
        begin = (os.getpid(), journals)
        self._pool = ProcessPoolExecutor(1, self, _begin, begin)
        self._process: SpawnProcess | None = None
        self._future: Future[Answer] | None = None
        self.task: Task | None = None
        self.knows: set[str] = set()

    def Process(self, *args: Any, **options: Any) -> SpawnProcess:  # type: ignore[override]
        """What the pool starts, kept to say how it ended."""
        self._process = SpawnProcess(*args, **options, daemon=True)
        return self._process

    @property
    def idle(self) -> bool:
        """Whether it can be sent a task."""
        last = self._future
        return last is None or (last.done() and not isinstance(last.exception(), BrokenProcessPool))

    def submit(self, task: Task, image: Callable[[str, str], bytes | None]) -> Future[Answer]:
        """Send it a task, with what it does not know of what that starts from."""
        entries: dict[str, bytes] = {}
        for stage, key in task.given:
            if key not in self.knows and (found := image(stage, key)) is not None:
                entries[key] = found
        self.knows |= entries.keys()
        self.task, sent = task, (task.work, task.makes, entries, frozenset(self.knows))
        try:
            with held_back():
                self._future = self._pool.submit(_perform, *sent)
        except BrokenProcessPool as error:  # it died while it was idle
            self._future = Future()
            self._future.set_exception(error)
        return self._future

    def kill(self) -> None:
        """End it at once."""
        if self._process is not None:
            self._process.kill()

    def close(self) -> str:
        """Wait until it has ended; how it did, in words."""
        self._pool.shutdown()
        code = (self._process and self._process.exitcode) or 0
        if code < 0:
            return f"its process was killed by signal {-code} ({signal.Signals(-code).name})"
        return f"its process ended with status {code}"


@contextmanager
def held_back() -> Generator[None, None, None]:
    """Start processes and threads that get neither Ctrl-C nor the signal of a broken pipe.

    They inherit which signals are held back. Ctrl-C reaches every process of a terminal, and is for
    the one that runs the study to answer. Writing to a process that has died is to fail rather than
    to end this one: Python ignores that signal, but libraries that were loaded since may not.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGPIPE})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with(parent: int) -> None:
    """End this process when its parent ends, at once, even within a call that lets no thread run.

    Where the system is not Linux, only if it has ended already.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


_worker: Worker
"""In a process that does tasks."""


def _begin(parent: int, journals: Path | None) -> None:
    """Prepare such a process; it ends as soon as its parent does, even if that is killed."""
    global _worker

    def watch() -> None:
        above = parent_process()
        if above is not None:
            above.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    end_with(parent)
    keep_freed()
    _worker = Worker(journals)


def _perform(work: Work, makes: Sequence[str], entries: dict[str, bytes], keys: Set[str]) -> Answer:
    return _worker.perform(work, makes, entries, keys)
