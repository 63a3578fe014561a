"""Arguments and options that commands share, and what may be given for them."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from vanelock.commands.guidance import study_files
from vanelock.common.errors import InputError
from vanelock.common.files.files import possible


class Shell(StrEnum):
    """Shells with completion."""

    bash = "bash"
    zsh = "zsh"
    fish = "fish"


def given_path(text: str) -> Path:
    """A path that was given, not left out: an empty one would be the current folder."""
    if not text.strip():
        raise typer.BadParameter("must not be empty")
    try:
        possible(text, f"{text[:40]}...")
    except InputError as error:
        raise typer.BadParameter(str(error)) from None
    return Path(text)


def _bytes(text: str) -> float:
    """An amount of memory."""
    from vanelock.common.quantities import si

    try:
        found = float(str(si(text, "byte")))
    except ValueError:
        found = 0.0
    if not found > 0:
        raise typer.BadParameter(f'{text!r}: expected an amount such as "8 GB"')
    return found


StudyFile = Annotated[
    Path,
    typer.Argument(
        help="Study file (TOML).", parser=given_path, metavar="STUDY", autocompletion=study_files
    ),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Folder; default runs/<name of the file>.",
        parser=given_path,
        metavar="PATH",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Outside = Annotated[
    bool,
    typer.Option("--allow-outside", help="Let the study name files outside of its own folder."),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object a line instead of text.")
]


Workers = Annotated[
    int | None,
    typer.Option(
        "--workers",
        "-w",
        min=1,
        max=1024,
        help="Processes that compute a sweep's cases; default: as many as there are cores to "
        "use; 1: none but this one.",
        metavar="N",
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        help="Address of a Dask scheduler whose workers, which see the run's folder, compute the "
        "cases instead, such as tcp://host:8786 (`vanelock manual sweeps`).",
        metavar="ADDRESS",
    ),
]
Insecure = Annotated[
    bool,
    typer.Option(
        "--insecure-scheduler",
        help="Let the scheduler be on another machine without encryption (tcp://).",
    ),
]


Memory = Annotated[
    float | None,
    typer.Option(
        help="Memory that a study's processes, and the meshes chosen for its accuracy, may take, "
        'such as "8 GB"; default, and at most: seven tenths of what there is.',
        parser=_bytes,
        metavar="AMOUNT",
    ),
]
