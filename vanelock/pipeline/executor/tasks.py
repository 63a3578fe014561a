"""Work that another process can do: it is sent what to compute, and returns products as bytes.

A task does not say what its products belong to. It holds a picklable object from which the same
steps, and so the same keys, follow in every process; those upstream products that are known go with
it as the bytes of cache entries, everything else is computed where the task runs. What it returns
are cache entries too, so that the process that holds the results is the only one that writes, and
no file system need be shared.
"""

import hashlib
import io
import platform
from collections.abc import Iterable, Mapping, Sequence, Set
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any, Protocol, TypeAlias, TypeVar

import h5py

import vanelock
from vanelock.common.errors import InputError
from vanelock.common.process.version import __version__, release
from vanelock.common.product import Product
from vanelock.nonlinear import Journal
from vanelock.pipeline.cache import Entry, journal_of, read_entry, write_entry
from vanelock.pipeline.journal import journal
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages, Step

P = TypeVar("P", bound=Product)
Made: TypeAlias = list[tuple[str, str, bytes]]
"""Stage, key and entry of each product."""


class Work(Protocol):
    """Something picklable that says which steps there are."""

    def steps(self) -> Iterable[Step[Any]]:
        """The same steps in every process; what they need need not be among them."""
        ...


@dataclass(frozen=True)
class Task:
    """Products to make.

    Attributes
    ----------
    name : str
        What lists call it.
    work : Work
        Says the steps.
    makes : tuple of str
        Keys of the products wanted.
    after : tuple of str
        Keys of products that other tasks make, which it needs.
    given : tuple of (str, str)
        Stage and key of the products that it starts from, where they are in the cache.
    counts : bool
        Whether it counts in the progress, or only makes what others need.
    """

    name: str
    work: Work
    makes: tuple[str, ...]
    after: tuple[str, ...] = ()
    given: tuple[tuple[str, str], ...] = ()
    counts: bool = True


@dataclass(frozen=True)
class Failure:
    """Why there is no product.

    Attributes
    ----------
    task : str
        What could not be done.
    reason : str
        One line.
    attempts : int
        How often it was tried.
    refused : bool
        Whether the input is to blame.
    again : bool
        Whether another try may help.
    counts : bool
        Whether the task is to blame.
    """

    task: str
    reason: str
    attempts: int = 1
    refused: bool = False
    again: bool = True
    counts: bool = True


Answer: TypeAlias = Made | Failure
"""What comes back of a task."""


class TaskFailed(Exception):
    """A product that a failed task should have made."""

    def __init__(self, failure: Failure) -> None:
        super().__init__(failure.reason)
        self.failure = failure


@dataclass
class Memory:
    """A cache without a folder, of a process that gets and returns products as bytes.

    Attributes
    ----------
    given : dict of str to bytes
        Entries to start from, by key.
    made : list of (str, str, bytes)
        Stage, key and entry of what was stored.
    journals : Path or None
        Folder of the cache, where this process shares it, for the points of stages under way.
    """

    given: dict[str, bytes] = field(default_factory=dict)
    made: Made = field(default_factory=list)
    journals: Path | None = None

    def load(self, stage: str, key: str, kind: type[P]) -> Entry[P] | None:
        """The product of an entry that was given."""
        if not self.given.get(key):
            return None
        entry = read_entry(io.BytesIO(self.given[key]), kind, key)
        self.given[key] = b""  # the stages keep the product
        return entry

    def store(self, stage: str, key: str, product: P, seconds: float, cpu: float = 0.0) -> Entry[P]:
        """Keep a product until it is returned; what loading it gives."""
        image = io.BytesIO()
        with h5py.File(image, "w") as file:
            write_entry(file, stage, key, product, (seconds, cpu))
        self.made.append((stage, key, image.getvalue()))
        return read_entry(image, type(product), key)

    def journal(self, stage: str, key: str) -> AbstractContextManager[Journal]:
        """Where a stage writes down what it has done so far."""
        return journal(None if self.journals is None else journal_of(self.journals, stage, key))

    def take(self) -> Made:
        """What was made since the last time."""
        made, self.made = self.made, []
        return made


class Worker:
    """Where tasks are done, one after the other, in a process that has no folder."""

    def __init__(self, journals: Path | None = None) -> None:
        self._memory = Memory(journals=journals)
        self._stages = Stages(self._memory, silent)
        self._apart: set[str] = set()
        """What the last task made that no cache keeps: the next one may need it, too."""

    def perform(
        self, work: Work, makes: Sequence[str], entries: Mapping[str, bytes], keys: Set[str]
    ) -> Answer:
        """Products of a task, and what else was computed on the way, or why there are none.

        Of the `entries` those that are not known yet are taken in; what is known is forgotten but
        for the `keys`.
        """
        given = self._memory.given
        for key in given.keys() - keys:
            del given[key]
        self._memory.given = {**entries, **given}
        self._memory.take()
        try:
            steps = {step.key: step for step in reachable(work.steps())}
            self._apart = {key for key, step in steps.items() if not step.kept}
            self._keep()
            if any(key not in steps for key in makes):
                raise InputError("the program is not the same here as where the tasks come from")
            for key in makes:
                self._stages.get(steps[key])
            return self._memory.take()
        except Exception as error:
            return Failure("", reason(error), refused=isinstance(error, InputError))
        finally:
            self._keep()

    def _keep(self) -> None:
        self._stages.keep(self._memory.given.keys() | self._apart)


def reachable(steps: Iterable[Step[Any]]) -> list[Step[Any]]:
    """The steps and all that they need, each once."""
    found: dict[str, Step[Any]] = {}
    waiting = list(steps)
    while waiting:
        step = waiting.pop()
        if step.key not in found:
            found[step.key] = step
            waiting += step.needs
    return list(found.values())


def reason(error: BaseException) -> str:
    """An error in one line."""
    lines = str(error).strip().splitlines()
    if isinstance(error, InputError):
        return lines[0] if lines else "refused"
    if isinstance(error, MemoryError):
        return "out of memory"
    return f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__


@lru_cache
def identity() -> str:
    """Release of the program, version of Python, and a digest of all its source files."""
    digest = hashlib.sha256()
    folder = Path(vanelock.__path__[0])
    stages = [init.parent for init in folder.glob("*/__init__.py")]  # links, not looked through
    for path in sorted([*folder.glob("*.py"), *chain(*(s.rglob("*.py") for s in stages))]):
        digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    python = ".".join(platform.python_version_tuple()[:2])
    return f"{release(__version__)}+{digest.hexdigest()[:12]}, Python {python}"
