"""Work shared with copies of this process: who does it, and what if a copy fails or dies."""

import os
import signal
import time
from multiprocessing import active_children
from typing import Any

import pytest

from vanelock.common.errors import InputError
from vanelock.pipeline.executor import forked
from vanelock.pipeline.executor.forked import of_this_process, shared
from vanelock.pipeline.progress import Event, Notice


def done(works, copies, meanwhile=lambda: None):
    """What each work gave, by its place."""
    found: dict[int, Any] = {}
    with shared(works, copies, found.__setitem__):
        meanwhile()
    return found


def until(path):
    """Wait for a file."""
    limit = time.monotonic() + 60
    while not path.exists():
        assert time.monotonic() < limit
        time.sleep(0.01)


def test_copies_work_while_this_process_does_something_else(tmp_path):
    def work(i):
        (tmp_path / str(i)).touch()
        return os.getpid()

    works = [lambda i=i: work(i) for i in range(7)]
    found = done(works, 2, lambda: [until(tmp_path / str(i)) for i in range(7)])
    assert sorted(found) == list(range(7))
    assert os.getpid() not in found.values()
    assert set(done(works, 0).values()) == {os.getpid()}


def test_they_see_what_is_in_memory_and_leave_it_as_it_is_and_report_nothing(tmp_path):
    known, events = [1, 2, 3], list[Event]()
    listener = of_this_process(events.append)

    def work():
        known.append(4)
        listener(Notice("there"))
        (tmp_path / str(len(known))).touch()
        return len(known)

    found = done([work] * 3, 1, lambda: until(tmp_path / "6"))
    assert found == {0: 4, 1: 5, 2: 6}
    assert known == [1, 2, 3]
    assert events == []
    listener(Notice("here"))
    assert events == [Notice("here")]


@pytest.mark.parametrize("end", [lambda: os.kill(os.getpid(), signal.SIGKILL), lambda: 1 / 0])
def test_the_work_of_a_copy_that_dies_or_fails_is_done_here(tmp_path, end):
    own = os.getpid()

    def work(i):
        if os.getpid() != own:
            (tmp_path / "taken").touch()
            end()
        return i, os.getpid()

    found = done([lambda i=i: work(i) for i in range(4)], 1, lambda: until(tmp_path / "taken"))
    assert found == {i: (i, own) for i in range(4)}


def test_the_work_of_a_copy_that_stands_still_is_done_here_when_it_is_gone(tmp_path, monkeypatch):
    monkeypatch.setattr(forked, "PATIENCE", 0.5)
    own, before, copies = os.getpid(), set(active_children()), dict[int, int]()

    def work(i):
        if os.getpid() != own:
            (tmp_path / "taken").touch()
            time.sleep(3600)
        copies[i] = len(set(active_children()) - before)
        return i, os.getpid()

    found = done([lambda i=i: work(i) for i in range(4)], 1, lambda: until(tmp_path / "taken"))
    assert found == {i: (i, own) for i in range(4)}
    assert copies == {0: 0, 1: 1, 2: 1, 3: 1}  # the first is what the copy had begun


def test_the_error_of_a_work_is_reported_and_no_copy_stays():
    def refused():
        raise InputError("no place")

    before = set(active_children())
    with pytest.raises(InputError, match="no place"):
        done([refused] * 6, 2)
    assert set(active_children()) == before
