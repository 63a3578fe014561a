"""Run a study or a scene: every stage that is not cached, results file, tables and pictures."""

import os
import time
from dataclasses import asdict
from pathlib import Path

from vanelock import render
from vanelock.analyses import ANALYSES
from vanelock.commands.run.cases import OngoingRun
from vanelock.common.process.memory import largest
from vanelock.input.cases.sweep import cases
from vanelock.input.cases.values import Given
from vanelock.input.schema.study import Study
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.executor import chosen_workers
from vanelock.pipeline.progress import Finished, Listener, Notice, silent
from vanelock.pipeline.step import Stages
from vanelock.results import listing
from vanelock.results.figures.pictures import draw
from vanelock.results.files import results_file
from vanelock.results.files.redrawn import REPORT, OutputFiles
from vanelock.results.files.run_folder import claimed
from vanelock.results.page import write_report
from vanelock.stages.accuracy.cost_estimate import estimated
from vanelock.stages.accuracy.error_places import of_own_meshes
from vanelock.stages.accuracy.mesh_sizes import processes
from vanelock.stages.response.summary import Summary


def run_study(
    given: Given,
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
    given : Study or Scene
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
        found = cases(given)
        needed = None
        if isinstance(given, Study):
            needed = estimated(found, memory, analyses=ANALYSES)
        if needed is not None:
            workers = min(workers, processes(needed.memory, memory))
        others = chosen_workers(workers, scheduler, listener, cache.folder, insecure)
        output_files = OutputFiles(path, listener)
        running = OngoingRun(
            given, path, listener, stages, found, output_files, others, memory, text
        )
        running.record.provenance(given, text)
        if needed is not None:
            listener(Notice(f"about {', '.join(needed.words().values())}, if nothing is there yet"))
            if needed.warning:
                listener(Notice(needed.warning))
        shapes = getattr(given.outputs, "shapes", False)
        if shapes:
            render.trial()  # whether this machine draws is then known when the first is drawn

        with running.record.finished(running.unshown):
            with running.background():
                summaries = running.all_cases()
            running.scatter()
            if shapes and (places := of_own_meshes(running.planned[0])):
                listener(stages.get(places).table)
            running.answer()
            draw(running.run)
            if given.outputs.report:
                running.record.answers(running.run.answers, ANALYSES)
                write_report(running.run)
            listener(listing.stage_times([*stages.done.values(), *output_files.done]))
            running.record.complete(stages.done)
    summary = {
        "cases": [asdict(case) for case in summaries],
        "failed": {name: failure.reason for name, failure in running.failed.items()},
        "results": str(path / results_file.NAME),
        "pictures": [
            str(file) for shown in running.run.pictures for file in (shown.path, *shown.data)
        ],
    }
    page = str(path / REPORT) if given.outputs.report else ""
    listener(Finished(str(path), time.perf_counter() - began, summary, page, largest()))
    return summaries


run_scene = run_study
"""The same for a scene."""
