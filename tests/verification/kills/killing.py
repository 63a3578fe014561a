"""Runs that are killed at chosen moments, and what they leave."""

import hashlib
import json
import os
import selectors
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vanelock import open_results

ROOT = Path(__file__).resolve().parents[3]
TIMES = {"seconds", "cost", "cpu", "cached", "date", "stages", "digest", "whole", "residual"}
"""What varies from run to run: times, the date, stages that it computed or looked up, digests, what
is left of solved equations, and the name of a cache entry, which has one."""
PATIENCE = 600.0
"""Seconds after which a run that neither ends nor comes to the moment of its kill is given up."""


@dataclass
class Moment:
    """When to kill: in a stage so long after its beginning, or as a file appears or grows."""

    name: str
    """What is hit there."""
    stage: str = ""
    """Beginning of the names of the stages in which, "" for any."""
    after: float = 0.0
    """Seconds after the stage began; after the start, where there is no stage."""
    file: str = ""
    """Pattern of the file, if any."""


@dataclass
class Outcome:
    """How a run ended."""

    status: int
    """Of the process; -9 where it was killed."""
    within: str | None
    """The stage that was being computed."""
    hit: bool
    """Whether the kill came at the moment that was meant."""
    done: list[tuple[str, bool]]
    """Stages whose end it reported, and whether they came from the cache."""
    errors: str
    """What it said on standard error."""
    left: bool
    """Whether processes of it were still there a while after the kill."""


def started(study: Path, folder: Path) -> subprocess.Popen[bytes]:
    """The command, in a session of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "vanelock", "run", str(study), "-o", str(folder), "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=ROOT,
        start_new_session=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )


def run(study: Path, folder: Path, moment: Moment | None = None) -> Outcome:
    """Run a study, to its end or to the moment of its kill."""
    process = started(study, folder)
    try:
        return _watched(process, folder, moment)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def _watched(process: subprocess.Popen[bytes], folder: Path, moment: Moment | None) -> Outcome:
    assert process.stdout is not None
    assert process.stderr is not None
    lines: list[dict[str, Any]] = []
    began, due, killed, aimed = time.monotonic(), np.inf, False, False
    if moment is not None and not moment.stage and not moment.file:
        due, aimed = began + moment.after, True
    known = _sizes(folder, moment)
    buffers = {process.stdout: b"", process.stderr: b""}
    with selectors.DefaultSelector() as selector:
        for stream in buffers:
            os.set_blocking(stream.fileno(), False)
            selector.register(stream, selectors.EVENT_READ)
        while selector.get_map():
            quick = moment is not None and moment.file and not killed
            early = not quick or (moment is not None and moment.stage and time.monotonic() < due)
            wait = max(0.0, min(due - time.monotonic(), 0.2)) if early else 0.0
            for key, _ in selector.select(wait):
                chunk = key.fileobj.read()  # type: ignore[union-attr]
                if not chunk:
                    selector.unregister(key.fileobj)
                buffers[key.fileobj] += chunk or b""  # type: ignore[index]
            *whole, buffers[process.stdout] = buffers[process.stdout].split(b"\n")
            for line in whole:
                lines.append(json.loads(line))
                event = lines[-1]
                if moment is not None and moment.stage and event["event"] == "begun":
                    if event["stage"].startswith(moment.stage):
                        due = time.monotonic() + moment.after
            if killed or moment is None:
                continue
            if quick:
                if moment.stage and time.monotonic() < due:
                    continue
                now = _sizes(folder, moment)
                killed = any(size > known.get(name, 0) for name, size in now.items())
                if killed:
                    process.kill()
                known = now
                time.sleep(1e-4)
            elif time.monotonic() >= due:
                process.kill()
                killed = True
            if time.monotonic() - began > PATIENCE:
                break
    status = process.wait()
    begun: list[str] = []  # a stage may begin others, and go on when they are done
    for event in lines:
        if event["event"] in ("begun", "done") and event["stage"] in begun:
            begun = begun[: begun.index(event["stage"])]
        if event["event"] == "begun":
            begun.append(event["stage"])
    done = [(each["stage"], each["cached"]) for each in lines if each["event"] == "done"]
    if moment is not None and moment.file:
        aimed = bool(_sizes(folder, moment))  # it was not renamed before the kill
    elif moment is not None and moment.stage:
        aimed = any(stage.startswith(moment.stage) for stage in begun)
    errors = buffers[process.stderr].decode()
    within, hit = begun[-1] if begun else None, status == -9 and aimed
    return Outcome(status, within, hit, done, errors, _remains(process))


def _sizes(folder: Path, moment: Moment | None) -> dict[str, int]:
    """Files of a moment and their sizes."""
    found: dict[str, int] = {}
    if moment is not None and moment.file:
        for path in folder.glob(moment.file):
            try:
                found[str(path)] = path.stat().st_size
            except FileNotFoundError:
                continue
    return found


def _remains(process: subprocess.Popen[bytes]) -> bool:
    """Whether anything of a run's session lives on, 10 s after its end."""
    for _ in range(100):
        if not _alive(process.pid):
            return False
        time.sleep(0.1)
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    return True


def _alive(group: int) -> list[int]:
    """Processes of a group that are more than an entry in the table."""
    found = []
    for place in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, _, own, *_ = place.read_text().rpartition(")")[2].split()
            if int(own) == group and state != "Z":
                found.append(int(place.parent.name))
    return found


def numbers(path: Path) -> dict[str, Any]:
    """All datasets and attributes of a results file by their places, times and dates aside."""
    found: dict[str, Any] = {}

    def take(place: str, node: h5py.Group | h5py.Dataset) -> None:
        for name, value in node.attrs.items():
            if name not in TIMES:
                array = np.asarray(value)
                found[f"{place}@{name}"] = array.tolist() if array.dtype == object else array
        if isinstance(node, h5py.Group):
            for name, each in node.items():
                if name not in TIMES:
                    take(f"{place}/{name}", each)
        elif place.endswith("/about"):
            stored(place, json.loads(node[()]))
        else:
            array = np.asarray(node[()])
            found[place] = array.tolist() if array.dtype == object else array

    def stored(place: str, value: Any) -> None:
        if isinstance(value, dict | list):
            for name, each in value.items() if isinstance(value, dict) else enumerate(value):
                if name not in TIMES:
                    stored(f"{place}/{name}", each)
        else:
            number = isinstance(value, int | float)
            found[place] = np.asarray(value) if number else value

    with h5py.File(path) as file:
        take("", file)
    return found


def entries(folder: Path) -> set[str]:
    """Names of the cache entries of a run; each must hold what its name says."""
    found = set()
    for path in (folder / "cache").rglob("*.h5"):
        digest = hashlib.sha256(path.read_bytes()).hexdigest()[:20]
        assert path.stem.rpartition("-")[2] == digest, f"{path} is not whole"
        found.add(path.name)
    return found


def records(folder: Path) -> dict[str, int]:
    """Whole records in each file of points of a run."""
    found = {}
    for path in (folder / "cache").glob("*.points"):
        content, place, count = path.read_bytes(), len(b"vanelock-points 1\n"), 0
        while place + 12 <= len(content):
            length = int.from_bytes(content[place : place + 8], "little")
            place += 12 + length
            count += place <= len(content)
        found[path.name] = count
    return found


def readable(folder: Path) -> bool:
    """Whether the results file, if it is there, is a whole one."""
    path = folder / "results.h5"
    if not path.exists():
        return True
    with open_results(path) as file:
        return str(file.attrs["format"]) == "vanelock-results" and bool(numbers(path))


def seconds(folder: Path) -> dict[str, float]:
    """Time of each stage and picture, as the results have it."""
    found: dict[str, float] = {}
    with h5py.File(folder / "results.h5") as file:
        stages = file["provenance/stages"]
        names = stages["name"].asstr()[()].tolist()
        found |= dict(zip(names, stages["seconds"][()].tolist(), strict=True))
    drawn = json.loads((folder / "cache" / "pictures.json").read_text())
    return found | {name: float(known[2]) for name, known in drawn.items()}
