"""Who computes the cases of a sweep: this process, others of this machine, or a cluster."""

from collections.abc import Callable
from pathlib import Path

from vanelock.pipeline.executor.task_queue import Executor
from vanelock.pipeline.progress import Listener


def chosen_executor(
    workers: int,
    scheduler: str | None,
    listener: Listener,
    journals: Path | None = None,
    insecure: bool = False,
) -> Callable[[], Executor] | None:
    """What gets the processes when they are needed; None where this one does all."""
    if scheduler is not None:
        from vanelock.pipeline.executor.dask import Cluster

        cluster = Cluster(scheduler, listener, insecure)  # refused before the long stages
        return lambda: cluster
    if workers < 2:
        return None
    from vanelock.pipeline.executor.processes import Processes

    return lambda: Processes(workers, journals)
