"""Tasks in processes of their own: what fails is tried again, the others never know."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import Future
from multiprocessing import active_children

import numpy as np
import psutil
import pytest

from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor.processes import Processes
from vanelock.pipeline.executor.task_queue import TaskQueue
from vanelock.pipeline.executor.tasks import Answer, Failure, Task, TaskFailed
from vanelock.pipeline.progress import Event, Failed, Notice, Tasks

TOY = '''
"""Products of one number, made well or badly."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.pipeline.step import step


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
            again = Path(self.folder, f"{self.number}.tried")
            first = not (self.folder and again.exists())
            if self.folder:
                again.touch()
            if self.how == "raises" or (self.how == "raises once" and first):
                raise RuntimeError("as it should")
            if self.how == "no memory":
                raise MemoryError
            if self.how == "refuses":
                raise InputError("toy.number = 3: must not be 3")
            if self.how == "dies" or (self.how == "dies once" and first):
                os.kill(os.getpid(), signal.SIGKILL)
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
            tasks.append(Task(str(each.number), each, (each.own.key,), (), (("base", first.key),)))
        said: list[Event] = []
        queue = TaskQueue(tasks, cache, Processes(2), said.append)
        started.append(queue)
        return queue, said

    yield start
    for queue in started:
        queue.executor.close()
    assert not active_children()


def value(queue, toy):
    assert queue.bring(toy.own.key)
    entry = queue.cache.load(toy.own.name, toy.own.key, toy.own.kind)
    return entry.product.value[0]


@pytest.mark.system
def test_all_are_made_and_counted_and_come_back_bit_by_bit(toy, queue_of):
    toys = [toy.Toy(i) for i in range(8)]
    queue, said = queue_of(*toys)
    assert [value(queue, each) for each in toys] == [40 + i for i in range(8)]
    counts = [event for event in said if isinstance(event, Tasks)]
    assert sorted({each.done for each in counts} - {0}) == [1, 2, 3, 4, 5, 6, 7, 8]
    assert {each.total for each in counts} == {8}
    assert np.isnan(counts[-1].left)  # pictures follow
    assert not queue.bring("of no task")
    odd = toys[1].own
    found = queue.cache.load(odd.name, odd.key, odd.kind).product
    np.testing.assert_array_equal(found.value, odd.compute(toy.base().compute()).value)
    # What is sent once to each process is not sent again.
    size = len(queue.cache.image("base", toy.base().key))
    made = sum(len(queue.cache.image(each.own.name, each.own.key)) for each in toys)
    assert queue.moved == made + 2 * size


def test_the_time_left_never_rises_while_a_task_is_under_way(toy, queue_of):
    queue, _ = queue_of(*(toy.Toy(i) for i in range(4)))
    assert np.isnan(queue._left(queue._began + 5))
    queue._done, queue._ended = 1, queue._began + 10
    left = [queue._left(queue._began + after) for after in (10, 20, 39, 41)]
    assert left[:3] == pytest.approx([30, 20, 1])
    assert np.isnan(left[3])
    queue._done = 4
    assert np.isnan(queue._left(queue._began + 50))


@pytest.mark.system
def test_what_fails_once_is_made_the_second_time(toy, queue_of, tmp_path):
    folder = str(tmp_path)
    toys = [toy.Toy(1, "raises once", folder), toy.Toy(2, "dies once", folder), toy.Toy(3)]
    queue, said = queue_of(*toys)
    assert [value(queue, each) for each in toys] == [41, 42, 43]
    notices = sorted(event.text for event in said if isinstance(event, Notice))
    assert notices == [
        "1: RuntimeError: as it should; trying again",
        "2: its process was killed by signal 9 (SIGKILL); trying again",
    ]


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
        found = failure.task, failure.reason, failure.attempts
        assert found == (str(each.number), reason, attempts)
        assert failure.refused == (each.how == "refuses")
    last = [event for event in said if isinstance(event, Tasks)][-1]
    assert (last.done, last.failed) == (8, 4)


@pytest.mark.system
def test_a_task_waits_for_what_another_makes_or_fails_with_it(toy, queue_of):
    first, second = toy.Toy(1), toy.Toy(2)
    queue, _ = queue_of(first, second, base=False)
    base = toy.base()

    assert value(queue, first) == 41  # made on the way, and taken home too
    assert queue.cache.load("base", base.key, base.kind).product.value == 40

    bad = toy.Toy(5, "raises")
    tasks = [
        Task("bad", bad, (bad.own.key,)),
        Task("after", second, (second.own.key,), (bad.own.key,)),
    ]
    both = TaskQueue(tasks, queue.cache, queue.executor, lambda event: None)
    with pytest.raises(TaskFailed, match="as it should"):
        both.bring(second.own.key)


def test_what_comes_of_another_queue_s_task_is_left_alone(toy, tmp_path):
    """The same executor brings the end of a task that another queue sent."""
    wanted = toy.Toy(1).own.key
    other, own = Task("other", toy.Toy(1), (wanted,)), Task("own", toy.Toy(1), (wanted,))

    class Shared:
        slots = 1

        def submit(self, task, image):
            assert task in (other, own)
            future: Future[Answer] = Future()
            bad = Failure("own", "as it should", again=False)
            future.set_result(bad if task is own else [])
            return future

        def failure(self, task, error):
            raise error

        def forget(self, keys):
            pass

        def close(self):
            pass

    first, queue = (
        TaskQueue([task], Cache(tmp_path, print), Shared(), lambda event: None)
        for task in (other, own)
    )
    assert first.bring(wanted)
    with pytest.raises(TaskFailed, match="as it should"):
        queue.bring(wanted)


SCRIPT = """
import sys
sys.path.insert(0, {folder!r})
import toys
from pathlib import Path
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor.task_queue import TaskQueue
from vanelock.pipeline.executor.processes import Processes
from vanelock.pipeline.executor.tasks import Task

if __name__ == "__main__":
    made = [toys.Toy(i, "sleeps", {folder!r}) for i in range(2)]
    tasks = [Task(str(t.number), t, (t.own.key,)) for t in made]
    queue = TaskQueue(tasks, Cache(Path({folder!r}) / "c", print), Processes(2), lambda event: None)
    try:
        queue.bring(made[0].own.key)
    finally:
        queue.executor.close()
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


@pytest.mark.parametrize(("failed", "status"), [(True, 1), (False, 0)])
def test_the_exit_status_shows_failed_cases(tmp_path, monkeypatch, capsys, failed, status):
    from vanelock import __main__ as command
    from vanelock.commands.run import study

    given: dict[str, object] = {}

    def run_study(study, folder, listener, text, workers, scheduler, *rest, **more):
        given.update(workers=workers, scheduler=scheduler)
        if failed:
            listener(Failed("mu=0.2", "out of memory", 2))

    monkeypatch.setattr(study, "run_study", run_study)
    (tmp_path / "a.toml").write_text("")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as caught:
        command.main(["run", "a.toml", "--workers", "3", "--scheduler", "tcp://a:1"])
    assert caught.value.code == status
    assert given == {"workers": 3, "scheduler": "tcp://a:1"}
    assert ("FAILED mu=0.2: out of memory (tried 2 times)" in capsys.readouterr().err) == failed
