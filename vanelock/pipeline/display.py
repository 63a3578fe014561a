"""Displays of a run: bars on a terminal that leave the answers alone behind, plain lines elsewhere.

Tables go to standard output, all else to standard error, and each thing is said once: what stages
took in one line at the end, not in a table besides.
"""

import os
import sys
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Generator
from contextlib import contextmanager
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from vanelock.common.errors import printable
from vanelock.common.process import gigabytes
from vanelock.common.tables import Table
from vanelock.pipeline.progress import (
    Begun,
    Done,
    Event,
    Failed,
    Finished,
    Notice,
    PointDone,
    Tasks,
    Trial,
    kind_of,
)
from vanelock.pipeline.text_table import WIDEST, text_lines, wrapped

COUNTED = ("pictures", "stresses", "checks")
"""Stages so many and so short that plain lines do not name each."""
SAID = ("stages", "failed")
"""Tables of what lines have said by then."""
NAMED = 3
"""Kinds of stages that the last line names, if they took a second."""


class _Times:
    """Stages that are done, by kind: how many are unchanged, how many new, and their seconds."""

    def __init__(self) -> None:
        self._kept, self._new = Counter[str](), Counter[str]()
        self._seconds: defaultdict[str, float] = defaultdict(float)

    def add(self, event: Done) -> str:
        """Count a stage; its kind."""
        kind = kind_of(event.stage)
        self._kept[kind] += event.cached
        self._new[kind] += not event.cached
        self._seconds[kind] += 0.0 if event.cached else event.seconds
        return kind

    def text(self, kind: str) -> str:
        new = [f"{self._new[kind]} in {self._seconds[kind]:.1f} s"] if self._new[kind] else []
        return ", ".join(new + [f"{self._kept[kind]} unchanged"] * (self._kept[kind] > 0))

    def line(self, run: Finished) -> str:
        """What a run took, and of that its longest stages."""
        held = f", at most {gigabytes(run.memory)} of memory" if run.memory > 0 else ""
        order = sorted(self._seconds.items(), key=lambda item: -item[1])
        longest = [f"{kind} {seconds:.1f} s" for kind, seconds in order[:NAMED] if seconds >= 1]
        return f"done in {run.seconds:.1f} s{held}" + (f": {', '.join(longest)}" if longest else "")


def _width_of(file: TextIO) -> int:
    """Characters of a line: of a terminal its own, elsewhere without limit, unless COLUMNS says."""
    asked = os.environ.get("COLUMNS", "")
    if asked.isdecimal() and int(asked) > 0:
        return int(asked)
    try:
        return (os.get_terminal_size(file.fileno()).columns if file.isatty() else 0) or WIDEST
    except (OSError, ValueError):
        return WIDEST


class PlainLines:
    """Plain lines: stages and notes to standard error, a point every half minute, and tables.

    A stage that takes longer without a word of its points is named every half minute, too.
    """

    interval = 30.0

    def __init__(self) -> None:
        self._spoke = time.monotonic()
        self._times = _Times()
        self._clock: threading.Timer | None = None

    def __call__(self, event: Event) -> None:
        """Say what there is to say about an event."""
        if isinstance(event, Begun | Done | Failed | Finished):
            self._watch(event.stage if isinstance(event, Begun) else None, time.monotonic())
        match event:
            case PointDone():
                self._in_a_while(f"{event.case}: {_progress(event)}")
            case Trial():
                self._in_a_while(_trial(event))
            case Tasks():
                self._in_a_while(_tasks(event), event.done == event.total)
            case Table():
                if event.key not in SAID:
                    print("\n".join(text_lines(event, _width_of(sys.stdout))), flush=True)
            case Begun():
                pass
            case Done():
                if self._times.add(event) not in COUNTED:
                    took = "unchanged" if event.cached else f"{event.seconds:.1f} s"
                    self._say(f"{event.stage}: {took}")
            case Finished():
                self._say(self._times.line(event))
                self._say(_last(event))
            case _:
                self._say(_line(event))

    def _watch(self, stage: str | None, began: float) -> None:
        """Say from time to time that a stage is still at work; none: no longer."""
        if self._clock is not None:
            self._clock.cancel()
        self._clock = None
        if stage is not None:
            self._clock = threading.Timer(self.interval, self._still, (stage, began))
            self._clock.daemon = True
            self._clock.start()

    def _still(self, stage: str, began: float) -> None:
        if self._clock is threading.current_thread():
            self._in_a_while(f"{stage}: {time.monotonic() - began:.0f} s so far")
            self._watch(stage, began)

    def _in_a_while(self, text: str, now: bool = False) -> None:
        if now or time.monotonic() - self._spoke >= self.interval:
            self._say(f"  {text}")

    def _say(self, text: str) -> None:
        print(printable(text), file=sys.stderr, flush=True)
        self._spoke = time.monotonic()


class _Bar:
    """A bar for each kind of stage while the run lasts; what stays is tables, notes and the end."""

    def __init__(self, bar: Progress) -> None:
        # On one terminal all must pass through the bar, which moves down for it.
        here = sys.stdout.isatty()
        self._tables = bar.console if here else Console(highlight=False, markup=False)
        self._bar = bar
        self._times = _Times()
        self._rows: dict[str, TaskID] = {}
        self._stage = ""

    def __call__(self, event: Event) -> None:
        """Move the bars, or print lines above them."""
        match event:
            case Begun():
                self._stage = kind_of(event.stage)
                self._move(self._stage, None, None, printable(event.stage))
            case PointDone() if self._stage:
                said = f"{printable(event.case)}: {_progress(event)}"
                self._move(self._stage, event.done, event.total, said)
            case Trial() if self._stage:
                self._move(self._stage, event.count, event.total, _trial(event))
            case Tasks():
                self._move("cases", event.done, event.total, _tasks(event))
            case Done():
                kind = self._times.add(event)
                self._move(kind, 1, 1, self._times.text(kind))
            case Table():
                if event.key != "stages":
                    lines = text_lines(event, _width_of(sys.stdout))
                    self._tables.print("\n".join(lines), soft_wrap=True)
                    self._tables.file.flush()
            case Finished():
                lines = [self._times.line(event), _last(event)]
                self._bar.stop()
                self._say(lines[0], "dim")
                self._say(lines[1], "bold")
            case Notice() | Failed():
                self._say(_line(event), "bold red" if isinstance(event, Failed) else "")

    def _move(self, kind: str, done: int | None, total: int | None, said: str) -> None:
        if kind not in self._rows:
            self._rows[kind] = self._bar.add_task(printable(kind), total=total, said=said)
        self._bar.update(self._rows[kind], completed=done or 0, total=total, said=said)

    def _say(self, text: str, style: str = "") -> None:
        console = self._bar.console
        first, *more = wrapped(printable(text), console.width - 2)
        lines = "\n".join([first, *(f"  {line}" for line in more)])
        console.print(lines, style=style, soft_wrap=True)


@contextmanager
def on_terminal() -> Generator[_Bar, None, None]:
    """Bars on the terminal that standard error is."""
    console = Console(stderr=True, highlight=False, markup=False)
    name, said = (TextColumn(f"{{task.{each}}}") for each in ("description", "fields[said]"))
    columns = name, BarColumn(20), TimeElapsedColumn(), said
    with Progress(*columns, console=console, transient=True) as bar:
        yield _Bar(bar)


def _last(event: Finished) -> str:
    return f"open {event.page}" if event.page else f"results are in {event.folder}"


def _line(event: Event) -> str:
    match event:
        case Notice():
            return f"note: {event.text}"
        case Failed():
            tries = f" (tried {event.attempts} times)" if event.attempts > 1 else ""
            return f"FAILED {event.case}: {event.reason}{tries}"
    return ""


def _progress(point: PointDone) -> str:
    of = "" if point.total is None else f"/{point.total}"
    said = f"point {point.done}{of}, peak {point.peak * 1e6:.1f} um"
    if point.searching is not None:
        return f"{said}, looking for {point.searching:.2f} Hz by longer ways"
    return f"{said}{_clock(point.left)}"


def _tasks(tasks: Tasks) -> str:
    said = [f"{tasks.done} of {tasks.total} cases"]
    if tasks.failed:
        said.append(f"{tasks.failed} FAILED")
    if tasks.peak:
        said.append(f"largest peak {tasks.peak * 1e6:.1f} um")
    return ", ".join(said) + _clock(tasks.left)


def _trial(trial: Trial) -> str:
    said = f"response {trial.count} of about {trial.total}, {trial.name} {trial.value:.3g}"
    return f"{said} {trial.unit}, least so far {trial.least:.3g}{_clock(trial.left)}"


def _clock(left: float) -> str:
    if not left > 0:
        return ""
    minutes, seconds = divmod(round(left), 60)
    return f", {minutes}:{seconds:02d} left"
