"""A sweep by one and by two processes in turn, in one run: times, ratios, sizes.

    python -m benchmarks.runs.sweep_scaling [--cases 16] [--harmonics 1 3] [--write]
"""

import argparse
import shutil
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

from benchmarks.pages import page
from vanelock import parse_study
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor import Processes
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.pipeline.tasks import Task, TaskQueue
from vanelock.stages.plan import plan
from vanelock.commands.run.graph import bundle

STUDY = """
[mesh]
size = "coarse"
[response]
harmonics = {harmonics}
[rows]
"joints.interlock.mu" = {values}
[outputs]
show = []
"""
ABOUT = """\
A sweep of the interlock's friction on the coarse mesh, with the adaptive points of a default curve:
everything that the cases share is computed beforehand, and the first case, for which processes
start, is left out. The least of two turns each.
"""


def measured(count: int, harmonics: int) -> dict[str, str]:
    """Rows of the table for a number of harmonics, by what they say."""
    values = [round(0.1 + 0.4 * i / max(count - 1, 1), 6) for i in range(count)]
    study = parse_study(STUDY.format(values=values, harmonics=harmonics))
    with tempfile.TemporaryDirectory() as place:
        shared = Path(place) / "shared"
        planned = plan(cases(study), lambda *_: None)
        cache = Cache(shared, print)
        stages = Stages(cache, silent)
        for step in bundle(planned, cache)[0]:
            stages.get(step)
        took: dict[int, list[float]] = {}
        work: dict[int, list[float]] = {}
        for turn, processes in enumerate((1, 2, 2, 1)):
            folder = Path(place) / str(turn)
            shutil.copytree(shared, folder)
            tasks = bundle(planned, Cache(folder, print))[1]
            workers = Processes(processes)
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
            took.setdefault(processes, []).append(seconds)
            work.setdefault(processes, []).append(spent)
        one, two = (min(took[processes]) for processes in (1, 2))
        sizes = [sum(path.stat().st_size for path in f.rglob("*.h5")) for f in (shared, folder)]
        return {
            "cases": f"{len(planned)}",
            "read by each process, once": f"{sizes[0] / 1e6:.0f} MB",
            "written for a case": f"{np.diff(sizes)[0] / len(tasks) / 1e6:.1f} MB",
            "a case's preload and response by one process": f"{one:.2f} s",
            "by two processes": f"{two:.2f} s, {one / two:.2f} times faster",
            "CPU of the same by two processes over by one": f"{min(work[2]) / min(work[1]):.2f}",
        }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", type=int, default=16)
    parser.add_argument("--harmonics", type=int, nargs="+", default=[1, 3])
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    given = parser.parse_args()
    columns = [measured(given.cases, harmonics) for harmonics in given.harmonics]
    lines = [
        ABOUT,
        f"| | {' | '.join(f'H = {harmonics}' for harmonics in given.harmonics)} |",
        "|---|" + "---:|" * len(columns),
        *(f"| {name} | {' | '.join(found[name] for found in columns)} |" for name in columns[0]),
    ]
    print("\n".join(lines))
    page("sweep_scaling", "A sweep by one and by two processes", lines, given.write)


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
