"""Work shared with copies of this process, which see all that it has in memory.

What they do is what needs nothing but that memory and writes files of its own, such as pictures. A
copy that fails or dies leaves its work to this process, whose error then counts; so does one that
stands still, as a copy may for ever that was made while another thread held a lock.
"""

import os
import sys
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import TypeVar

from vanelock.pipeline.executor.processes import end_with, held_back
from vanelock.pipeline.progress import Event, Listener

R = TypeVar("R")
EACH = 3
"""Works for which a copy is worth what it takes to begin."""
PATIENCE = 60.0
"""Seconds without a result after which copies are taken to stand still."""


@contextmanager
def shared(
    works: Sequence[Callable[[], R]], copies: int, take: Callable[[int, R], object]
) -> Generator[None, None, None]:
    """Have copies of this process do works while the block does something else.

    When the block has ended this process joins in, until all are done.
    """
    context = get_context("fork" if sys.platform == "linux" else None)
    begun = context.Value("i", 0)

    def next_one() -> int:
        with begun.get_lock():
            begun.value += 1
            return int(begun.value) - 1

    def work(results: Connection) -> None:
        end_with(parent)
        while (i := next_one()) < len(works):
            try:
                results.send((i, works[i]()))
            except Exception:
                return

    parent, started, readers = os.getpid(), [], list[Connection]()
    try:
        for _ in range(min(copies, len(works) // EACH) if sys.platform == "linux" else 0):
            reader, writer = context.Pipe(duplex=False)
            with held_back():
                started.append(context.Process(target=work, args=(writer,), daemon=True))
                started[-1].start()
            writer.close()
            readers.append(reader)
        yield
        left = set(range(len(works)))

        def collect(patience: float) -> None:
            while readers and (ready := wait(readers, patience)):
                for reader in [each for each in readers if each in ready]:
                    try:
                        i, result = reader.recv()
                    except EOFError:
                        readers.remove(reader)
                    else:
                        take(i, result)
                        left.discard(i)

        while (i := next_one()) < len(works):
            take(i, works[i]())
            left.discard(i)
            collect(0)
        collect(PATIENCE)
        _end(started)  # one that stood still must not go on with a file that is made here now
        for i in sorted(left):
            take(i, works[i]())
    finally:
        _end(started)


def _end(started: Sequence[BaseProcess]) -> None:
    for each in started:
        each.kill()
        each.join()


def of_this_process(listener: Listener) -> Listener:
    """The listener, which copies of this process do not call: its display is not theirs."""
    own = os.getpid()

    def told(event: Event) -> None:
        if os.getpid() == own:
            listener(event)

    return told
