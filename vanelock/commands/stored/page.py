"""`vanelock page`: tables, pictures and page of a run again, from its results alone."""

import os
import time
from pathlib import Path

from vanelock.commands.stored.contents import load_run
from vanelock.common.errors import InputError
from vanelock.common.process.memory import largest
from vanelock.pipeline.progress import Finished, Listener, silent
from vanelock.quantities.run_result import RunResult
from vanelock.results.files.redrawn import REPORT, OutputFiles
from vanelock.results.files.results_file import NAME
from vanelock.results.files.run_folder import claimed
from vanelock.results.listing import tables
from vanelock.results.page import show


def show_again(folder: str | os.PathLike[str], listener: Listener = silent) -> RunResult:
    """Make all that a run shows from what its results file holds; nothing is computed.

    Parameters
    ----------
    folder : path
        The run's folder, or the results file in it; its cache need not be there, nor the files
        that its study names.
    listener : callable
        Called with the tables, with each picture drawn, and with where all of it is.

    Raises
    ------
    InputError
        If it holds no results, they are damaged, or no case is finished; after the tables, if the
        run is not complete.
    """
    place, began = Path(folder), time.perf_counter()
    if place.name == NAME:
        place = place.parent
    run = load_run(place, place.name)
    if not run.cases:
        raise InputError(f"{place}: no case is finished yet")
    with claimed(place):
        run.output_files = OutputFiles(place, listener)
        for table in tables(run):
            listener(table)
        if not run.complete:
            raise InputError(
                f"{place}: not complete, so without pictures and page: the same `vanelock run` "
                "goes on from there"
            )
        show(run)
    pictures = [str(file) for shown in run.pictures for file in (shown.path, *shown.data)]
    found = {"results": str(place / NAME), "pictures": pictures}
    page = str(place / REPORT) if "report" in run.given.outputs.show else ""
    listener(Finished(str(place), time.perf_counter() - began, found, page, largest()))
    return run
