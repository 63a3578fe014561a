"""A sweep by one and by two processes in turn, in one run: times, ratios, sizes.

python -m benchmarks.runs.sweep_scaling [cases] [study.toml]
"""

import shutil
import sys
import tempfile
import time
from os import sched_getaffinity
from pathlib import Path

import h5py
import numpy as np

from vanelock import load_study, parse_study
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor import Processes
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.pipeline.tasks import Task, TaskQueue
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
    """Print seconds and processor seconds of each number of processes, and sizes."""
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
        for turn, count in enumerate((1, 2, 2, 1)):
            folder = Path(place) / str(turn)
            shutil.copytree(shared, folder)
            tasks = bundle(jobs(planned), Cache(folder, print))[1]
            if not tasks:
                raise InputError("nothing differs between the cases")
            workers = Processes(count)
            queue = TaskQueue(tasks, workers, folder, silent)
            try:
                queue.bring(tasks[0].keys[-1])  # processes have started and read what all share
                began = time.perf_counter()
                for task in tasks[1:]:
                    queue.bring(task.keys[-1])
            finally:
                seconds = (time.perf_counter() - began) / (len(tasks) - 1)
                workers.shutdown()
            spent = sum(processor(folder, task) for task in tasks[1:]) / (len(tasks) - 1)
            took.setdefault(count, []).append(seconds)
            work.setdefault(count, []).append(spent)
            print(f"{count} processes: {seconds:.3f} s and {spent:.3f} s CPU a case")
        one, two = (min(took[count]) for count in (1, 2))
        print(f"a case takes {one:.3f} s by one process, {two:.3f} s by two: {one / two:.2f} times")
        print(
            f"in CPU s {min(work[1]):.3f} and {min(work[2]):.3f}: {min(work[2]) / min(work[1]):.2f}"
        )
        sizes = [sum(path.stat().st_size for path in f.rglob("*.h5")) for f in (shared, folder)]
        print(
            f"shared {sizes[0] / 1e6:.1f} MB; a case {np.diff(sizes)[0] / len(tasks) / 1e3:.0f} kB"
        )


def processor(folder: Path, task: Task) -> float:
    """Processor seconds of a task's products."""
    spent = 0.0
    for key in task.keys:
        (path,) = folder.rglob(f"*-{key}-*.h5")
        with h5py.File(path) as file:
            spent += float(file.attrs["cpu"])
    return spent


if __name__ == "__main__":
    main()
