"""A sweep by one and by two processes in turn, in one run: times, ratios, bytes moved.

python -m benchmarks.runs.sweep_scaling [cases] [study.toml]
"""

import shutil
import sys
import tempfile
import time
from os import sched_getaffinity, times
from pathlib import Path

import h5py

from vanelock import load_study, parse_study
from vanelock.commands.run.cases import OngoingRun
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor.processes import Processes
from vanelock.pipeline.executor.task_queue import TaskQueue
from vanelock.pipeline.executor.tasks import Task
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.stages.plan import plan
from vanelock.commands.run.graph import bundle, jobs

STUDY = """
[mesh]
size = "coarse"
[response]
harmonics = 1
[rows]
"joints.interlock.mu" = {values}
[outputs]
shapes = false
loops = false
animations = false
report = false
"""


def main() -> None:
    """Print seconds and processor seconds of each number of processes, and what moved."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    values = [round(0.1 + 0.4 * i / max(count - 1, 1), 6) for i in range(count)]
    study = (
        load_study(sys.argv[2]) if len(sys.argv) > 2 else parse_study(STUDY.format(values=values))
    )
    with tempfile.TemporaryDirectory() as place:
        shared = Path(place) / "shared"
        planned = plan(cases(study), lambda *_: None)
        cache = Cache(shared, print)
        stages = Stages(cache, silent)
        for step in bundle(jobs(planned), cache)[0]:
            stages.get(step)
        print(f"{len(planned)} cases, {len(sched_getaffinity(0))} cores")
        took: dict[int, list[float]] = {}
        work: dict[int, list[float]] = {}
        moved, taken = 0, 0.0
        for turn, workers in enumerate((1, 2, 2, 1)):
            own = Path(place) / str(turn)
            shutil.copytree(shared, own)
            cache = Cache(own, print)
            tasks = bundle(jobs(planned), cache)[1]
            if not tasks:
                raise InputError("nothing differs between the cases")
            executor = Processes(workers)
            queue = TaskQueue(tasks, cache, executor, silent)
            try:
                queue.bring(tasks[0].makes[-1])  # processes have started and know what all share
                before, began = times(), time.perf_counter()
                for task in tasks[1:]:
                    queue.bring(task.makes[-1])
            finally:
                seconds = time.perf_counter() - began
                after = times()
                executor.close()
            took.setdefault(workers, []).append(seconds / (len(tasks) - 1))
            moved = queue.moved
            own_cpu = sum(after[:2]) - sum(before[:2])
            taken = own_cpu / (len(tasks) - 1)
            spent = sum(processor(cache, task) for task in tasks[1:]) / (len(tasks) - 1)
            work.setdefault(workers, []).append(spent)
            print(
                f"{workers} processes: {seconds:.2f} s after the first case, {spent:.3f} s CPU a "
                f"case; {queue.moved / 1e6:.1f} MB moved"
            )
        one, two = (min(took[workers]) for workers in (1, 2))
        sent = sum(len(cache.image(s, k) or b"") for s, k in tasks[0].given)
        back = (moved - 2 * sent if workers == 2 else moved - sent) / len(tasks)
        print(f"a case takes {one:.3f} s by one process, {two:.3f} s by two: {one / two:.2f} times")
        print(
            f"in CPU s {min(work[1]):.3f} and {min(work[2]):.3f}: {min(work[2]) / min(work[1]):.2f}"
        )
        print(f"to each process, once {sent / 1e6:.1f} MB; back, a case {back / 1e3:.0f} kB")
        folder = Path(place) / "run"
        shutil.copytree(own, folder / "cache")
        stages = Stages(Cache(folder / "cache", print), silent)
        began = time.process_time()
        run = OngoingRun(study, folder, silent, stages)
        run.record.provenance(study, "")
        run.all_cases()
        run.record.complete(stages.done)
        cpu = time.process_time() - began
        files = [folder / "results.h5", *(folder / "results").iterdir()]
        size = sum(each.stat().st_size for each in files)
        print(
            f"the one that writes spends {1e3 * taken:.0f} ms CPU a case on taking in and "
            f"{1e3 * cpu / len(planned):.0f} ms on planning, reading, summing up and writing; "
            f"results {size / 1e6:.0f} MB"
        )


def processor(cache: Cache, task: Task) -> float:
    """Processor seconds of a task's products."""
    spent = 0.0
    for key in task.makes:
        (path,) = cache.folder.rglob(f"*-{key}-*.h5")
        with h5py.File(path) as file:
            spent += float(file.attrs["cpu"])
    return spent


if __name__ == "__main__":
    main()
