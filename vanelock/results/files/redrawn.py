"""Files that show results, drawn again only when what they show has changed."""

import json
import time
from collections.abc import Callable, Collection, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from vanelock.common.errors import InputError
from vanelock.common.files.digests import file_digest
from vanelock.pipeline.cache import code_of, key_of
from vanelock.pipeline.progress import Begun, Done, Listener
from vanelock.results.files.run_folder import record

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
