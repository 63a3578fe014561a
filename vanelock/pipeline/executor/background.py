"""Cases computed by other processes while this one shows them, where that is wanted."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any

from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor.task_queue import Executor, TaskQueue
from vanelock.pipeline.executor.tasks import Task
from vanelock.pipeline.progress import Listener
from vanelock.pipeline.step import Stages, Step


@contextmanager
def in_background(
    make: Callable[[], Executor] | None,
    divide: Callable[[], tuple[list[Step[Any]], list[Task]]],
    stages: Stages,
    cache: Cache,
    listener: Listener,
    peak: Callable[[], float],
    idle: Callable[[], object],
) -> Generator[None, None, None]:
    """Have tasks done by other processes, if there are any and there is something to divide.

    Parameters
    ----------
    make : callable or None
        Gets the processes.
    divide : callable
        What all cases need, which is computed here first, and the tasks after it.
    stages : Stages
        What then waits for the tasks' products.
    cache : Cache
        Where these go.
    listener : callable
        Called with how many tasks are done.
    peak : callable
        The largest peak so far, m.
    idle : callable
        Called whenever it waits.
    """
    if make is None:
        yield
        return
    shared, tasks = divide()
    if len(tasks) < 2:
        yield
        return
    for step in shared:
        stages.get(step)
    executor = make()
    try:
        queue = TaskQueue(tasks, cache, executor, listener, peak)
        queue.idle = idle
        stages.elsewhere = queue.bring
        yield
    finally:
        stages.elsewhere = None
        executor.close()
