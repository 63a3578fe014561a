"""What a run says while it runs: events, one after the other, to its listener.

That is a display of `vanelock.pipeline.display`, one that writes JSON, or none.
"""

import json
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

from vanelock.common.tables import Table

KINDS = {
    "mesh": "meshes",
    "read": "meshes",
    "match": "meshes",
    "fem": "stiffness and mass",
    "rom": "reduced models",
    "component": "reduced models",
    "linear": "linear limits",
    "Campbell": "Campbell diagram",
    "campbell": "Campbell diagram",
    "preload": "preloads",
    "static": "static friction",
    "bounds": "static friction",
    "response": "responses",
    "stress": "stresses",
    "check": "checks",
    "figures": "pictures",
    "shapes": "pictures",
    "report.html": "pictures",
}
"""Stages that are counted together, by the first word of their names."""


def kind_of(stage: str) -> str:
    """What stages of a kind are called together."""
    word = stage.replace("/", " ").partition(" ")[0]
    return KINDS.get(word, stage.partition(", ND")[0])


@dataclass(frozen=True)
class Begun:
    """A stage begins."""

    stage: str


@dataclass(frozen=True)
class Done:
    """A stage has its product; `seconds` is what computing it took, now or in an earlier run."""

    stage: str
    seconds: float
    cached: bool


@dataclass(frozen=True)
class PointDone:
    """A point of a case is solved: how many of them, the peak so far [m], seconds left in all.

    Of points that are chosen by their errors `total` is None; `left` is NaN where it is unknown;
    `searching` is the frequency, Hz, that is looked for by ways that may take long.
    """

    case: str
    done: int
    total: int | None
    peak: float
    left: float
    searching: float | None = None


@dataclass(frozen=True)
class Tasks:
    """Tasks of other processes: done, in all, failed, largest peak so far [m], seconds left.

    `left` is NaN where it is unknown, and when all are done, since other work follows.
    """

    done: int
    total: int
    failed: int
    peak: float
    left: float


@dataclass(frozen=True)
class Trial:
    """Values that were tried: how many so far, and about how many in all; seconds left.

    What is to be small, now and at best, what it is called and what it is in.
    """

    count: int
    value: float
    least: float
    unit: str
    total: int
    left: float
    name: str = "misfit"


@dataclass(frozen=True)
class Failed:
    """A case that could not be computed, and why."""

    case: str
    reason: str
    attempts: int


@dataclass(frozen=True)
class Notice:
    """Something worth a line."""

    text: str


@dataclass(frozen=True)
class Finished:
    """The run is complete; `page` is what to open, if it wrote a page.

    `memory` is what the process that took most held at most, in bytes; NaN where it is not said.
    """

    folder: str
    seconds: float
    summary: dict[str, Any]
    page: str = ""
    memory: float = float("nan")


Event: TypeAlias = Begun | Done | PointDone | Tasks | Trial | Failed | Notice | Table | Finished
Listener: TypeAlias = Callable[[Event], None]


def silent(event: Event) -> None:
    """Say nothing."""


def _json_lines(event: Event) -> None:
    """One JSON object a line on standard output; numbers that are not finite become null."""
    fields = event.record() if isinstance(event, Table) else asdict(event)
    record = {"event": type(event).__name__.lower(), **fields}
    print(json.dumps(_finite(record), allow_nan=False), flush=True)


@contextmanager
def choose_listener(quiet: bool, as_json: bool) -> Generator[Listener, None, None]:
    """The display for the options given and where standard error goes."""
    if as_json:
        yield _json_lines
    elif quiet:
        yield silent
    else:
        from vanelock.pipeline.display import PlainLines, on_terminal

        if sys.stderr.isatty():
            with on_terminal() as bar:
                yield bar
        else:
            yield PlainLines()


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not abs(value) < float("inf"):
        return None
    return value
