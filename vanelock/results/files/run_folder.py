"""The folder of a run: made, checked and claimed before anything is computed.

Files that show results, drawn again only when what they show has changed.
"""

import fcntl
import json
import os
import time
from collections.abc import Callable, Collection, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from vanelock.common.errors import InputError, printable
from vanelock.common.files.files import file_digest, placed
from vanelock.common.process import held
from vanelock.pipeline.cache import code_of, key_of
from vanelock.pipeline.progress import Begun, Done, Listener
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


FOLDERS = ("figures/", "shapes/")
"""Where the files go; nothing else is ever removed."""
REPORT = "report.html"
"""The one file of its own."""
NOTED = 3.0
"""Seconds between two notes of what is drawn: each replaces a file, which takes a disk a while."""


@contextmanager
def _placing(path: Path) -> Generator[None, None, None]:
    """Turn what the system refuses at `path` into one line."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None


@dataclass
class OutputFiles:
    """Draws files unless they are there and show the same already.

    Attributes
    ----------
    folder : Path
        The run's folder.
    listener : callable
        Called with each file drawn.
    done : list of Done
        The files so far.
    """

    folder: Path
    listener: Listener
    done: list[Done] = field(default_factory=list)
    _noted: float = field(default_factory=time.perf_counter, repr=False)
    _tidied: bool = field(default=False, repr=False)

    @cached_property
    def _known(self) -> dict[str, list[str]]:
        try:
            known = json.loads((self.folder / "cache" / "pictures.json").read_text("utf-8"))
            return {
                str(name): [str(key), str(digest), str(float(seconds))]
                for name, (key, digest, seconds) in known.items()
                if name == REPORT or (".." not in name and name.startswith(FOLDERS))
            }
        except (OSError, ValueError, AttributeError, TypeError):
            return {}

    def draw(
        self, name: str, shows: Any, function: Callable[[Path], object], quick: bool = False
    ) -> Path:
        """The file `name`; `shows` is what JSON can hold of all that it depends on."""
        path, key = self.folder / name, _key(name, shows)
        if self._there(name, key):
            return path
        if not quick:
            self.listener(Begun(name))
        began = time.perf_counter()
        with _placing(path):
            path.unlink(missing_ok=True)
            function(path)
        seconds = time.perf_counter() - began
        self._known[name] = [key, file_digest(path), f"{seconds:.3f}"]
        self.done.append(Done(name, seconds, False))
        if not quick:
            self.listener(self.done[-1])
        if self._tidied or time.perf_counter() - self._noted > NOTED:
            self._note()
        return path

    def _there(self, name: str, key: str) -> bool:
        """Whether the file is there and shows what it should."""
        known, path = self._known.get(name), self.folder / name
        if known is None or known[0] != key or not path.is_file():
            return False
        if file_digest(path) != known[1]:
            return False
        self.done.append(Done(name, float(known[2]), True))
        return True

    def tidy(self, keep: Collection[str] = ()) -> None:
        """Remove files that an earlier run drew and this one did not: they show other results.

        Those to `keep` are drawn later. What was drawn is then noted for the next run.
        """
        current = {*keep, *(done.stage for done in self.done)}
        for name in [name for name in self._known if name not in current]:
            place = self.folder / name
            with _placing(place):
                place.unlink(missing_ok=True)
                if name.count("/") > 1 and not any(place.parent.iterdir()):
                    place.parent.rmdir()
            del self._known[name]
        self._note()
        self._tidied = True

    def _note(self) -> None:
        """Record what is drawn; a run that is killed draws again what came after the last note."""
        self._noted = time.perf_counter()
        record(self.folder / "cache" / "pictures.json", json.dumps(self._known, indent=1))


def _key(name: str, shows: Any) -> str:
    return key_of(name, "render", {"shows": shows, "made by": code_of("results", "quantities")})
