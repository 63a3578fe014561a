"""Tasks done by processes of this machine.

Each process has a pipe of its own, so that it is known which task a process died with, and what it
has been sent before. A process ends with the one that started it, however that ends.
"""

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Callable, Collection, Generator
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from vanelock.common.errors import InputError
from vanelock.pipeline.executor.task_queue import TaskOutcome
from vanelock.pipeline.executor.tasks import Failure, Task, Worker, reason

_PR_SET_PDEATHSIG = 1


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


class Processes:
    """So many processes, started when there is something to do.

    Parameters
    ----------
    count : int
    journals : Path, optional
        Folder of the cache, where they write down the points of what they compute.
    """

    def __init__(self, count: int, journals: Path | None = None) -> None:
        self.slots, self._journals = count, journals
        self._processes: list[_Process] = []
        self._fresh: list[TaskOutcome] = []

    def send(self, task: Task, image: Callable[[str, str], bytes | None]) -> None:
        """Have a task done by an idle process, one that knows most of what it starts from."""
        wanted = {key for _, key in task.given}
        idle = [each for each in self._processes if each.task is None]
        if not idle:
            idle = [_Process(self._journals)]
            self._processes += idle
        chosen = max(idle, key=lambda each: len(wanted & each.knows))
        try:
            chosen.send(task, image)
        except OSError:  # it died while it was idle
            self._bury(chosen, task)

    def wait(self, seconds: float) -> list[TaskOutcome]:
        """Tasks that ended."""
        found, self._fresh = self._fresh, []
        busy = {each.pipe: each for each in self._processes if each.task is not None}
        for pipe in wait(list(busy), 0 if found else seconds):
            process = busy[pipe]  # type: ignore[index]
            assert process.task is not None
            try:
                found.append(process.receive())
            except (EOFError, OSError):
                self._bury(process, process.task)
        found += self._fresh
        self._fresh = []
        return found

    def forget(self, keys: Collection[str]) -> None:
        """Have all processes drop products with their next tasks."""
        for each in self._processes:
            each.drops |= each.knows.intersection(keys)

    def close(self) -> None:
        """Kill all processes."""
        for each in self._processes:
            each.kill()
        self._processes = []

    def _bury(self, process: "_Process", task: Task) -> None:
        told = process.kill(1.0)
        self._processes.remove(process)
        self._fresh.append(TaskOutcome(task, None, Failure(task.name, told)))


class _Process:
    """A process, what it knows, and the task that it is at."""

    def __init__(self, journals: Path | None) -> None:
        context = get_context("spawn")
        self.pipe, far = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(far, os.getpid(), journals), daemon=True
        )
        # A child inherits which signals are held back: Ctrl-C reaches every process of a terminal,
        # and is for the one that runs the study to answer.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        far.close()
        self.task: Task | None = None
        self.knows: set[str] = set()
        self.drops: set[str] = set()

    def send(self, task: Task, image: Callable[[str, str], bytes | None]) -> None:
        self.task = task
        entries: dict[str, bytes] = {}
        for stage, key in task.given:
            if key not in self.knows and (found := image(stage, key)) is not None:
                entries[key] = found
        drops, self.drops = tuple(self.drops), set()
        self.knows = self.knows.difference(drops) | entries.keys()
        with _unbroken():
            self.pipe.send((task.work, task.makes, entries, drops))

    def receive(self) -> TaskOutcome:
        task, answer = self.task, self.pipe.recv()
        assert task is not None
        self.task = None
        if isinstance(answer, Failure):
            failure = Failure(task.name, answer.reason, refused=answer.refused)
            return TaskOutcome(task, None, failure, again=not answer.refused)
        return TaskOutcome(task, answer)

    def kill(self, patience: float = 0.0) -> str:
        """End it, unless it ends by itself in so many seconds; how it ended, in words."""
        self._process.join(patience)
        if self._process.exitcode is None:
            self._process.kill()
        self._process.join()
        self.pipe.close()
        code = self._process.exitcode or 0
        if code < 0:
            return f"its process was killed by signal {-code} ({signal.Signals(-code).name})"
        return f"its process ended with status {code}"


@contextmanager
def _unbroken() -> Generator[None, None, None]:
    """Let writing to a process that has died fail rather than end this one.

    Python ignores the signal of a broken pipe, but libraries that were loaded since may not.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
    try:
        yield
    finally:
        signal.sigtimedwait({signal.SIGPIPE}, 0)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection, parent: int, journals: Path | None) -> None:
    """Do tasks until the pipe closes."""
    end_with(parent)
    workshop = Worker(journals)
    while True:
        try:
            work, makes, entries, drops = pipe.recv()
        except EOFError:
            return
        answer: Any
        try:
            workshop.learn(entries, drops)
            answer = workshop.perform(work, makes)
        except Exception as error:
            answer = Failure("", reason(error), refused=isinstance(error, InputError))
        pipe.send(answer)


def end_with(parent: int) -> None:
    """End this process as soon as its parent does, even if that is killed."""

    def watch() -> None:
        above = parent_process()
        if above is not None:
            above.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    if sys.platform == "linux":  # at once, even within a call that lets no other thread run
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
