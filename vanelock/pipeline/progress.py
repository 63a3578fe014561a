"""What a run says while it runs: a bar on a terminal, plain lines elsewhere, JSON, or nothing.

A run calls its listener with one event after the other; the displays here are such listeners.
"""

import json
import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from io import StringIO
from typing import Any, TypeAlias

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn
from rich.table import Table as RichTable

from vanelock.common.errors import printable
from vanelock.common.tables import Table

_PLAIN = str.maketrans({"µ": "u", "μ": "mu", "²": "^2", "³": "^3", "ζ": "zeta"})


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

    Of points that are chosen by their errors `total` is None; `left` is NaN where nothing tells it.
    """

    case: str
    done: int
    total: int | None
    peak: float
    left: float


@dataclass(frozen=True)
class Tasks:
    """Tasks of other processes: done, in all, failed, largest peak so far [m], seconds left.

    `left` is NaN where nothing tells it, and when all are done, since other work follows.
    """

    done: int
    total: int
    failed: int
    peak: float
    left: float


@dataclass(frozen=True)
class Trial:
    """A response of a fit: how many so far, misfits now and at best, and what they are in."""

    response: int
    misfit: float
    least: float
    unit: str


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
    """The run is complete."""

    folder: str
    seconds: float
    summary: dict[str, Any]


Event: TypeAlias = Begun | Done | PointDone | Tasks | Trial | Failed | Notice | Table | Finished
Listener: TypeAlias = Callable[[Event], None]


def silent(event: Event) -> None:
    """Say nothing."""


class Counter:
    """Passes all on, and counts the cases that failed."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self.failed = 0

    def __call__(self, event: Event) -> None:
        """Count a failed case."""
        self.failed += isinstance(event, Failed)
        self._listener(event)


class PlainLines:
    """Plain lines on standard error, tables on standard output; a point every few seconds."""

    interval = 5.0

    def __init__(self) -> None:
        self._tables = Console(file=sys.stdout, highlight=False, markup=False)
        self._spoke = time.monotonic()

    def __call__(self, event: Event) -> None:
        """Say what there is to say about an event."""
        match event:
            case PointDone():
                if time.monotonic() - self._spoke >= self.interval:
                    self._say(f"  {event.case}: {_progress(event)}")
            case Trial():
                if time.monotonic() - self._spoke >= self.interval:
                    self._say(f"  {_trial(event)}")
            case Tasks():
                if time.monotonic() - self._spoke >= self.interval or event.done == event.total:
                    self._say(f"  {_tasks(event)}")
            case Table():
                print_table(self._tables, event)
            case _:
                self._say(_line(event))

    def _say(self, text: str) -> None:
        print(printable(text), file=sys.stderr, flush=True)
        self._spoke = time.monotonic()


class Bar:
    """A bar for the stage in hand, with point, peak and time left."""

    def __init__(self, bar: Progress) -> None:
        # On one terminal all must pass through the bar, which moves down for it.
        here = sys.stdout.isatty()
        self._tables = bar.console if here else Console(highlight=False, markup=False)
        self._bar = bar
        self._task: TaskID | None = None
        self._cases: TaskID | None = None

    def __call__(self, event: Event) -> None:
        """Move the bar, or print a line above it."""
        if isinstance(event, PointDone) and self._task is not None:
            said = _progress(event)
            self._bar.update(self._task, completed=event.done, total=event.total, said=said)
            return
        if isinstance(event, Trial) and self._task is not None:
            self._bar.update(self._task, said=_trial(event))
            return
        if isinstance(event, Tasks):
            if self._cases is None:
                self._cases = self._bar.add_task("cases", total=event.total, said="")
            said = _tasks(event)
            self._bar.update(self._cases, completed=event.done, total=event.total, said=said)
            return
        if not isinstance(event, Notice) and self._task is not None:
            self._bar.remove_task(self._task)
            self._task = None
        match event:
            case Begun():
                self._task = self._bar.add_task(printable(event.stage), total=None, said="")
            case Table():
                print_table(self._tables, event)
            case PointDone() | Trial():
                pass
            case _:
                self._bar.console.print(printable(_line(event)))


def json_lines(event: Event) -> None:
    """One JSON object a line on standard output; numbers that are not finite become null."""
    fields = event.record() if isinstance(event, Table) else asdict(event)
    record = {"event": type(event).__name__.lower(), **fields}
    print(json.dumps(_finite(record), allow_nan=False), flush=True)


@contextmanager
def choose_listener(quiet: bool, as_json: bool) -> Generator[Listener, None, None]:
    """The display for the options given and where standard error goes."""
    if as_json:
        yield json_lines
    elif quiet:
        yield silent
    elif sys.stderr.isatty():
        columns = (
            TextColumn("{task.description}"),
            BarColumn(30),
            TextColumn("{task.fields[said]}"),
        )
        console = Console(stderr=True, highlight=False, markup=False)
        with Progress(*columns, console=console, transient=True) as bar:
            yield Bar(bar)
    else:
        yield PlainLines()


def print_table(console: Console, table: Table) -> None:
    """Print a table under its title, and its notes; a narrow terminal breaks lines."""
    written = StringIO()
    Console(width=1000, file=written, markup=False, highlight=False).print(lined_up(table))
    lines = [line.rstrip() for line in written.getvalue().splitlines()]
    lines = ["", table.title, *filter(None, lines), *table.lines]
    text = "\n".join(map(printable, lines))
    console.print(text, soft_wrap=True)
    console.file.flush()


def lined_up(table: Table) -> RichTable:
    """A table's head and rows, in characters that every terminal has."""
    lined = RichTable(box=SIMPLE_HEAD, pad_edge=False)
    for i, column in enumerate(table.columns):
        numbers = any(isinstance(row[i], int | float) for row in table.shown)
        head = f"{column.head} [{column.unit}]" if column.unit else column.head
        lined.add_column(
            printable(head.translate(_PLAIN)), justify="right" if numbers else "left", no_wrap=True
        )
    for row in table.shown:
        lined.add_row(
            *(printable(c.text(value)) for c, value in zip(table.columns, row, strict=True))
        )
    return lined


def _line(event: Event) -> str:
    match event:
        case Begun():
            return f"{event.stage} ..."
        case Done():
            return f"{event.stage}: " + ("unchanged" if event.cached else f"{event.seconds:.1f} s")
        case Notice():
            return f"note: {event.text}"
        case Failed():
            tries = f" (tried {event.attempts} times)" if event.attempts > 1 else ""
            return f"FAILED {event.case}: {event.reason}{tries}"
        case Finished():
            return f"done in {event.seconds:.1f} s: {event.folder}"
    return ""


def _progress(point: PointDone) -> str:
    of = "" if point.total is None else f"/{point.total}"
    return f"point {point.done}{of}, peak {point.peak * 1e6:.1f} um{_clock(point.left)}"


def _tasks(tasks: Tasks) -> str:
    said = [f"{tasks.done} of {tasks.total} cases"]
    if tasks.failed:
        said.append(f"{tasks.failed} FAILED")
    if tasks.peak:
        said.append(f"largest peak {tasks.peak * 1e6:.1f} um")
    return ", ".join(said) + _clock(tasks.left)


def _trial(trial: Trial) -> str:
    said = f"response {trial.response}, misfit {trial.misfit:.3g} {trial.unit}"
    return f"{said}, least so far {trial.least:.3g}"


def _clock(left: float) -> str:
    if not left > 0:
        return ""
    minutes, seconds = divmod(round(left), 60)
    return f", {minutes}:{seconds:02d} left"


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not abs(value) < float("inf"):
        return None
    return value
