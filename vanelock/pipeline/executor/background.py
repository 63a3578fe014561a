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
    """Have tasks done by other processes, if there are any and there is something to divide."""
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
