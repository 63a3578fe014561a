"""`vanelock run`, from Python too: every stage that is not cached, results, tables and pictures."""

import os
import time
from dataclasses import asdict
from pathlib import Path

from vanelock import render
from vanelock.analyses import ANALYSES
from vanelock.commands.run.cases import OngoingRun
from vanelock.commands.stored.run import Run, finished, load
from vanelock.common.files.files import default_folder
from vanelock.files import load_given, read_text
from vanelock.input.cases.sweep import cases
from vanelock.input.cases.values import Problem
from vanelock.input.schema.study import Study
from vanelock.nonlinear.fourier import one_thread
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor import chosen_workers
from vanelock.pipeline.progress import Listener, Notice, choose_listener, silent
from vanelock.pipeline.step import Stages
from vanelock.results import listing
from vanelock.results.figures.pictures import look_into
from vanelock.results.files.run_folder import claimed
from vanelock.results.listing import tables
from vanelock.results.page import show
from vanelock.stages.accuracy.mesh_sizes import processes
from vanelock.stages.cost_estimate import estimated
from vanelock.stages.response.summary import Summary


def run_study(
    problem: Problem,
    folder: str | os.PathLike[str],
    listener: Listener = silent,
    text: str = "",
    workers: int = 1,
    scheduler: str | None = None,
    insecure: bool = False,
    memory: float | None = None,
) -> tuple[Summary, ...]:
    """Run a study or a scene in a folder; what earlier runs there computed is used again.

    With several `workers`, protect the calling script with `if __name__ == "__main__":`, since each
    of the processes imports it.

    Parameters
    ----------
    problem : Study or Scene
        What to compute.
    folder : path
        Where `results.h5`, `figures/`, `shapes/` and `cache/` go.
    listener : callable
        Called with stages, points, notices and tables.
    text : str
        The file's text, kept in the results.
    workers : int
        Processes that compute the cases of a sweep; 1: this one does.
    scheduler : str, optional
        Address of a Dask scheduler whose workers do, such as "tcp://host:8786"; they see the
        folder, and files that a scene names, at the same places.
    insecure : bool
        Whether the scheduler may be on another machine without encryption.
    memory : float, optional
        Bytes that what is chosen may take: meshes for an accuracy, and the number of processes. By
        default, and at most, seven tenths of this machine's, control group's or shell's memory.

    Returns
    -------
    tuple of Summary
        One for each case that could be computed; of the others of a sweep the listener is informed.

    Raises
    ------
    InputError
        If it cannot be computed, or the folder not be used.
    """
    path, began = Path(folder), time.perf_counter()
    with claimed(path) as damage:
        if damage:
            listener(Notice(damage))
        cache = Cache(path / "cache", lambda message: listener(Notice(message)))
        stages = Stages(cache, listener)
        found = cases(problem)
        of_study = isinstance(problem, Study)
        needed = estimated(found, memory, analyses=ANALYSES) if of_study else None
        if needed is not None:
            workers = min(workers, processes(needed.memory, memory))
        others = chosen_workers(workers, scheduler, listener, cache.folder, insecure)
        running = OngoingRun(problem, path, stages, found, others, memory, text)
        running.record.provenance(problem, text)
        if needed is not None:
            listener(Notice(f"about {', '.join(needed.words().values())}, if nothing is there yet"))
            if needed.warning:
                listener(Notice(needed.warning))
        if "shapes" in problem.outputs.show:
            render.trial()  # whether this machine draws is then known when the first is drawn

        with running.record.finished(running.unshown):
            with running.background():
                summaries = running.all_cases()
            running.scatter()
            look_into(running.run)
            for table in tables(running.run):
                listener(table)
            running.record.rest(running.run)
            show(running.run)
            listener(listing.stage_times([*stages.done.values(), *running.output_files.done]))
            running.record.complete(stages.done)
    failed = {name: failure.reason for name, failure in running.failed.items()}
    listener(
        finished(running.run, began, cases=[asdict(case) for case in summaries], failed=failed)
    )
    return summaries


run_scene = run_study
"""The same for a scene."""


@one_thread
def run(
    file: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    workers: int = 1,
    quiet: bool = False,
    allow_outside: bool = False,
    memory: float | None = None,
) -> Run:
    """Run a study or a scene, or go on with it; what an earlier run computed is used again.

    With several `workers`, protect the calling script with `if __name__ == "__main__":`, since each
    of the processes imports it.

    Parameters
    ----------
    file : path
        Study or scene file (TOML).
    output : path, optional
        The run's folder; by default `runs/<name of the file>`, as the command line has it.
    workers : int
        Processes that compute the cases of a sweep; 1: this one does.
    quiet : bool
        Whether to say nothing on the way.
    allow_outside : bool
        Whether the files that it names may lie outside its folder.
    memory : float, optional
        Bytes that it may take, as for `run_study`.

    Returns
    -------
    Run
        Cases, their table, responses and curves; `Run.failed` has cases that could not be computed.

    Raises
    ------
    InputError
        One line for each mistake in the file; or no case can be computed, or the folder not used.
    """
    path = Path(file)
    given = load_given(path, allow_outside)
    folder = default_folder(path) if output is None else Path(output)
    with choose_listener(quiet, as_json=False) as listener:
        run_study(given, folder, listener, read_text(path), workers, memory=memory)
    return load(folder)
