"""Tasks in processes of their own: what fails is tried again, the others never know."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import Future
from multiprocessing import active_children

import psutil
import pytest

from vanelock.common.errors import FolderError
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor import Processes
from vanelock.pipeline.progress import Event, Notice, Tasks
from vanelock.pipeline.tasks import Failure, Task, TaskFailed, TaskQueue

TOY = '''
"""Products of one number, made well or badly."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vanelock.common.errors import FolderError, InputError
from vanelock.common.product import Product
from vanelock.pipeline.step import step


ERRORS = {
    "raises": RuntimeError("as it should"),
    "no memory": MemoryError(),
    "refuses": InputError("toy.number = 3: must not be 3"),
    "full disk": FolderError("there: cannot be written: No space left on device"),
}


@dataclass(frozen=True)
class Number(Product):
    value: np.ndarray


def base():
    return step("base", "stages", {}, Number, (), lambda: Number(np.array([40.0])))


@dataclass(frozen=True)
class Toy:
    number: int
    how: str = "well"
    folder: str = ""

    @property
    def own(self):
        def compute(base):
            if self.folder:
                Path(self.folder, f"{self.number}.tried").touch()
            if self.how == "dies":
                os.kill(os.getpid(), signal.SIGKILL)
            if self.how in ERRORS:
                raise ERRORS[self.how]
            if self.how == "counts":
                with Path(self.folder, f"{self.number}.times").open("a") as file:
                    file.write("x")
            if self.how == "sleeps":
                time.sleep(600)
            return Number(base.value + self.number)

        inputs = {"number": self.number}
        return step(f"toy {self.number}", "stages", inputs, Number, (base(),), compute)

    def steps(self):
        return [self.own]
'''


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """The module of the toys, which other processes find too."""
    (tmp_path / "toys.py").write_text(TOY)
    monkeypatch.syspath_prepend(tmp_path)
    import toys  # type: ignore[import-not-found]

    yield toys
    del sys.modules["toys"]


@pytest.fixture
def queue_of(toy, tmp_path):
    """Function that starts toys in two processes; they end with the test."""
    started = []

    def start(*toys, base=True):
        cache = Cache(tmp_path / "cache", print)
        first = toy.base()
        if base:
            cache.store(first.name, first.key, first.compute(), 1.0)
        tasks = []
        for each in toys:
            tasks.append(
                Task(str(each.number), each.steps, (each.own.key,), frozenset({each.number}))
            )
        said: list[Event] = []
        queue = TaskQueue(tasks, Processes(2), cache.folder, said.append)
        started.append(queue)
        return queue, said

    yield start
    for queue in started:
        queue.workers.shutdown()
    assert not active_children()


def value(queue, toy):
    assert queue.bring(toy.own.key)
    return stored(queue, toy.own)[0]


def stored(queue, step):
    """What the cache has of a step."""
    entry = Cache(queue._folder, print).load(step.stage, step.key, step.kind)
    assert entry is not None
    return entry.product.value


def test_what_fails_always_is_reported_and_the_others_are_made(toy, queue_of):
    reasons = {
        "raises": ("RuntimeError: as it should", 2),
        "no memory": ("out of memory", 2),
        "dies": ("its process was killed by signal 9 (SIGKILL)", 2),
        "refuses": ("toy.number = 3: must not be 3", 1),
    }
    bad = [toy.Toy(i, how) for i, how in enumerate(reasons)]
    well = [toy.Toy(i) for i in range(5, 9)]
    queue, said = queue_of(*bad[:2], *well, *bad[2:])
    assert [value(queue, each) for each in well] == [45, 46, 47, 48]
    for each, (reason, attempts) in zip(bad, reasons.values(), strict=True):
        with pytest.raises(TaskFailed) as caught:
            queue.bring(each.own.key)
        failure = caught.value.failure
        assert (failure.reason, failure.attempts) == (reason, attempts)
        assert failure.refused == (each.how == "refuses")
    last = [event for event in said if isinstance(event, Tasks)][-1]
    assert (last.done, last.failed) == (8, 4)


@pytest.mark.system
def test_a_task_waits_for_what_it_shares_with_others_or_fails_with_that(toy, queue_of, tmp_path):
    slow, after, bad = toy.Toy(1), toy.Toy(2), toy.Toy(5, "raises", str(tmp_path))
    queue, said = queue_of(slow, base=False)
    assert value(queue, slow) == 41  # what it starts from is made on the way, and kept, too
    assert stored(queue, toy.base()) == 40

    tasks = [
        Task("after", after.steps, (after.own.key,), frozenset({0})),
        Task("bad", bad.steps, (bad.own.key,), frozenset({0, 1}), counts=False),
    ]
    both = TaskQueue(tasks, queue.workers, queue._folder, said.append)
    with pytest.raises(TaskFailed, match="as it should") as caught:
        both.bring(after.own.key)
    assert caught.value.failure.reason == "RuntimeError: as it should"
    assert not any((tmp_path / "cache").rglob(f"*{after.own.key}*"))
    assert [event for event in said if isinstance(event, Tasks)][-1].done == 1


@pytest.mark.system
def test_a_killed_process_disturbs_no_other_s_task(toy, queue_of, tmp_path):
    """The one of two that is killed at each of its tasks takes none of the other with it."""
    folder = tmp_path / "counts"
    folder.mkdir()
    toys = [toy.Toy(i, "dies" if i == 1 else "counts", str(folder)) for i in range(6)]
    queue, said = queue_of(*toys)
    assert [value(queue, each) for each in toys if each.number != 1] == [40, 42, 43, 44, 45]
    with pytest.raises(TaskFailed, match="SIGKILL"):
        value(queue, toys[1])
    assert sorted(len(path.read_text()) for path in folder.glob("*.times")) == [1] * 5
    notices = [event.text for event in said if isinstance(event, Notice)]
    assert notices == ["1: its process was killed by signal 9 (SIGKILL); trying again"]


def test_a_disk_that_is_full_ends_the_run(toy, queue_of, tmp_path):
    queue, _ = queue_of(toy.Toy(1, "full disk"))
    with pytest.raises(FolderError, match="cannot be written: No space left"):
        queue.bring(toy.Toy(1).own.key)


def test_a_worker_that_is_not_fit_costs_a_task_no_attempt(toy, tmp_path):
    key, answers = toy.Toy(1).own.key, [Failure("a worker does not see", unfit=True)] * 3

    class Unfit:
        slots = 1

        def submit(self, function, /, *arguments):
            future: Future[Failure | None] = Future()
            future.set_result(answers.pop() if answers else Failure("refused", refused=True))
            return future

        def shutdown(self):
            pass

    said: list[Event] = []
    tasks = [Task("1", toy.Toy(1).steps, (key,), frozenset({0}))]
    queue = TaskQueue(tasks, Unfit(), tmp_path, said.append)
    with pytest.raises(TaskFailed) as caught:
        queue.bring(key)
    assert caught.value.failure == Failure("refused", 1, refused=True)
    again = [event.text for event in said if isinstance(event, Notice)]
    assert again == ["1: a worker does not see; trying again"] * 3


SCRIPT = """
import sys
sys.path.insert(0, {folder!r})
import toys
from pathlib import Path
from vanelock.pipeline.executor import Processes
from vanelock.pipeline.tasks import Failure, Task, TaskQueue

if __name__ == "__main__":
    made = [toys.Toy(i, "sleeps", {folder!r}) for i in range(2)]
    tasks = [Task(str(t.number), t.steps, (t.own.key,), frozenset({{t.number}})) for t in made]
    queue = TaskQueue(tasks, Processes(2), Path({folder!r}) / "c", lambda event: None)
    try:
        queue.bring(made[0].own.key)
    finally:
        queue.workers.shutdown()
"""


@pytest.mark.system
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_no_process_outlives_the_one_that_started_it(toy, tmp_path, number):
    path = tmp_path / "script.py"
    path.write_text(textwrap.dedent(SCRIPT.format(folder=str(tmp_path))))
    parent = subprocess.Popen([sys.executable, path], start_new_session=True, stderr=-3)
    try:
        while not all((tmp_path / f"{i}.tried").exists() for i in range(2)):
            assert parent.poll() is None
            time.sleep(0.05)
        below = psutil.Process(parent.pid).children(recursive=True)
        assert len(below) >= 2
        if number == signal.SIGINT:  # a terminal sends it to all of them
            os.killpg(parent.pid, number)
        else:
            parent.send_signal(number)
        parent.wait(600)
        assert psutil.wait_procs(below, 600)[1] == []
    finally:
        parent.kill()
