"""Run a file from Python as `vanelock run` does, and read what it found."""

import os
from pathlib import Path

from vanelock.commands.run.study import run_study
from vanelock.common.files.files import default_folder
from vanelock.files import load_given, read_text
from vanelock.nonlinear.fourier import one_thread
from vanelock.pipeline.progress import choose_listener
from vanelock.results.reading.run import Run, load


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
