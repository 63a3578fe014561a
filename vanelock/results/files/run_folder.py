"""The folder of a run: made, checked and claimed before anything is computed."""

import fcntl
import os
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from vanelock.common.errors import InputError, printable
from vanelock.common.files.files import placed
from vanelock.common.process.signals import held
from vanelock.results.files import results_file

PLACES = ("cache", "figures", "shapes", "mesh", results_file.PARTS)
"""Folders in it."""
OWN = (".lock", results_file.NAME, *PLACES[:-1])
"""By any of these a folder is known as that of a run."""


@contextmanager
def claimed(folder: Path) -> Generator[str, None, None]:
    """Hold a folder for one run."""
    fresh = not os.path.exists(folder)
    try:
        _refuse_foreign(folder)
        folder.mkdir(parents=True, exist_ok=True)
        lock = open(os.open(folder / ".lock", os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666), "a")
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{folder}: cannot be used as a folder to write to: {reason}") from None
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(f"{folder}: another run is using this folder") from None
        _check_places(folder)
        damage = results_file.check_results(folder / results_file.NAME)
        _sweep_up(folder)
        try:
            yield damage
        except InputError:
            if fresh:
                _abandon(folder)
            raise
        finally:
            with held():
                _sweep_up(folder)


def _refuse_foreign(folder: Path) -> None:
    """Refuse a folder that holds other things and no run, such as the root; hidden ones may be."""
    if not os.path.isdir(folder) or any(os.path.lexists(folder / name) for name in OWN):
        return
    other = next((each.name for each in folder.iterdir() if not each.name.startswith(".")), None)
    if other is not None:
        raise InputError(
            f"{folder}: holds {printable(other)!r} and is not the folder of a run; name an empty "
            "folder or a new one with --output"
        )


def _abandon(folder: Path) -> None:
    """Remove a folder that was made for a run which left nothing in it."""
    if [each.name for each in folder.iterdir()] == [".lock"]:
        (folder / ".lock").unlink(missing_ok=True)
        folder.rmdir()


def _check_places(folder: Path) -> None:
    """Refuse files and links where folders go, and a folder where the results file goes.

    What is written stays in the run's folder: a link in it could lead anywhere.
    """
    for name in PLACES:
        place = folder / name
        if place.is_symlink():
            raise InputError(f"{place}: is a link, which is not followed; {results_file.ADVICE}")
        if os.path.lexists(place) and not place.is_dir():
            raise InputError(f"{place}: is not a folder; {results_file.ADVICE}")
    place = folder / results_file.NAME
    if place.is_dir():
        raise InputError(f"{place}: is a folder, not a results file; {results_file.ADVICE}")


def _sweep_up(folder: Path) -> None:
    """Remove unfinished files that a run left; nobody else is writing here."""
    left = list(folder.glob(".*.tmp"))
    for name in PLACES:
        left += (folder / name).rglob(".*.tmp")
    for path in left:
        path.unlink(missing_ok=True)


def record(path: Path, text: str) -> None:
    """Write a small text file as a whole or not at all."""
    with placed(path) as temporary:
        temporary.write_text(text, "utf-8")
