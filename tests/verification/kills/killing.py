"""Runs that are killed at chosen moments and begun again, and what must hold every time."""

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tests.verification.conftest import ROOT
from vanelock import open_results

TIMES = {"seconds", "cost", "cpu", "cached", "date", "stages", "digest", "whole", "residual"}
"""What varies from run to run: times, the date, stages that it computed or looked up, digests, what
is left of solved equations, and the name of a cache entry, which has one."""
PATIENCE = 600.0
"""Seconds after which a run that neither ends nor comes to the moment of its kill is given up."""
DECIMAL = re.compile(r"-?\d+\.\d+(?:e[-+]\d+)?|-?\d+e[-+]\d+")
"""A number that is not whole."""


@dataclass
class Moment:
    """When to kill: in a stage so long after its beginning, or as a file appears or grows."""

    name: str
    """What is hit there."""
    stage: str
    """Beginning of the names of the stages in which, "" for any."""
    after: float = 0.0
    """Seconds after the stage began."""
    file: str = ""
    """Pattern of the file, if any."""


@dataclass
class Outcome:
    """How a run ended."""

    status: int
    """Of the process; -9 where it was killed."""
    hit: bool
    """Whether the kill came at the moment that was meant."""
    done: list[tuple[str, bool]]
    """Stages whose end it reported, and whether they came from the cache."""
    errors: str
    """What it said on standard error."""
    left: bool
    """Whether processes of it were still there a while after the kill."""


def run(study: Path, folder: Path, moment: Moment | None = None) -> Outcome:
    """Run a study in a session of its own, to its end or to the moment of its kill."""
    out, errors = (folder.with_name(f"{folder.name}.{name}") for name in ("out", "errors"))
    command = [sys.executable, "-m", "vanelock", "run", str(study), "-o", str(folder), "--json"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with open(out, "wb") as one, open(errors, "wb") as two:
        process = subprocess.Popen(
            command, stdout=one, stderr=two, cwd=ROOT, start_new_session=True, env=environment
        )
    try:
        if moment is not None:
            _strike(process, out, folder, moment)
        status = process.wait(PATIENCE)
    finally:
        process.kill()
        process.wait()
    begun: list[str] = []  # a stage may begin others, and go on when they are done
    for event, stage in _stages(out):
        if event in ("begun", "done") and stage in begun:
            begun = begun[: begun.index(stage)]
        begun += [stage] * (event == "begun")
    hit = False
    if moment is not None and status == -9:
        within = any(stage.startswith(moment.stage) for stage in begun)
        # A file is hit where it was not renamed before the kill.
        hit = bool(_sizes(folder, moment.file)) if moment.file else within
    done = [(each["stage"], each["cached"]) for each in _events(out) if each["event"] == "done"]
    return Outcome(status, hit, done, errors.read_text(), _remains(process.pid))


def _events(out: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in out.read_text().split("\n")[:-1]]


def _stages(out: Path) -> list[tuple[str, str]]:
    return [(each["event"], each.get("stage", "")) for each in _events(out)]


def _strike(process: subprocess.Popen[bytes], out: Path, folder: Path, moment: Moment) -> None:
    """Kill a process at a moment, if it comes."""
    limit, sizes, read, begun = time.monotonic() + PATIENCE, _sizes(folder, moment.file), 0, 0
    due = np.inf if moment.stage else 0.0
    while process.poll() is None and time.monotonic() < limit:
        if moment.stage and out.stat().st_size > read:
            read = out.stat().st_size
            stages = [stage for event, stage in _stages(out) if event == "begun"]
            count = sum(stage.startswith(moment.stage) for stage in stages)
            if count > begun:
                begun, due = count, time.monotonic() + moment.after
        now = _sizes(folder, moment.file)
        grown = not moment.file or any(size > sizes.get(name, 0) for name, size in now.items())
        if grown and time.monotonic() >= due:
            process.kill()
        sizes = now
        time.sleep(1e-4)


def _sizes(folder: Path, pattern: str) -> dict[str, int]:
    """Files of a pattern and their sizes."""
    found = {}
    for path in folder.glob(pattern) if pattern else ():
        with suppress(FileNotFoundError):
            found[str(path)] = path.stat().st_size
    return found


def _remains(session: int) -> bool:
    """Whether anything of a session lives on 10 s after its end, more than an entry in a table."""
    for _ in range(100):
        alive = False
        for place in Path("/proc").glob("[0-9]*/stat"):
            with suppress(OSError):
                state, _, group, *_ = place.read_text().rpartition(")")[2].split()
                alive = alive or (int(group) == session and state != "Z")
        if not alive:
            return False
        time.sleep(0.1)
    with suppress(ProcessLookupError):
        os.killpg(session, signal.SIGKILL)
    return True


def numbers(path: Path) -> dict[str, Any]:
    """All datasets and attributes of a results file by their places, times and dates aside."""
    found: dict[str, Any] = {}

    def take(name: str, value: Any) -> None:
        if isinstance(value, h5py.Group | h5py.Dataset):
            inside(f"{name}@", value.attrs)
        if isinstance(value, h5py.Dataset):
            value = json.loads(value[()]) if name.endswith("/about") else value[()]
        if isinstance(value, list):
            value = {str(i): each for i, each in enumerate(value)}
        if isinstance(value, h5py.Group | dict):
            inside(f"{name}/", value)
        else:
            array = np.asarray(value)
            found[name] = array.tolist() if array.dtype == object else array

    def inside(above: str, values: Any) -> None:
        for name, value in values.items():
            if name not in TIMES:
                take(above + name, value)

    with h5py.File(path) as file:
        take("", file)
    return found


def same(value: Any, expected: Any) -> bool:
    """Whether two arrays agree, numbers that are not whole to 1e-9 of the largest among them."""
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fc":
        return bool(np.array_equal(value, expected))
    apart = 1e-9 * np.nanmax(np.abs(expected), initial=0.0, where=np.isfinite(expected))
    alike = value.shape == expected.shape
    return alike and bool(np.allclose(value, expected, rtol=0.0, atol=apart, equal_nan=True))


def seconds(folder: Path) -> dict[str, float]:
    """Time of each stage and picture, as the results have it."""
    with h5py.File(folder / "results.h5") as file:
        stages = file["provenance/stages"]
        names, took = stages["name"].asstr()[()].tolist(), stages["seconds"][()].tolist()
    drawn = json.loads((folder / "cache" / "pictures.json").read_text())
    return dict(zip(names, took, strict=True)) | {n: float(each[2]) for n, each in drawn.items()}


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
            place += 12 + int.from_bytes(content[place : place + 8], "little")
            count += place <= len(content)
        found[path.name] = count
    return found


class Victim:
    """A run that is killed and begun again, in one folder."""

    def __init__(self, study: Path, folder: Path) -> None:
        self.study, self.folder = study, folder
        self.hits: Counter[str] = Counter()
        self.kills = 0
        self._entries: set[str] = set()
        self._points: dict[str, int] = {}

    def kill(self, moment: Moment) -> bool:
        """Kill once, and look at what is left; whether the moment was hit."""
        found = self.look(moment)
        self.kills += found.status == -9
        self.hits[moment.name] += found.hit
        return found.hit

    def look(self, moment: Moment | None) -> Outcome:
        """Nothing that was finished is lost or computed again, no file is half written."""
        found = run(self.study, self.folder, moment)
        assert "Traceback" not in found.errors, found.errors
        assert found.status in (0, -9), found.errors
        assert not found.left
        path = self.folder / "results.h5"
        if path.exists():
            with open_results(path) as file:
                assert file.attrs["format"] == "vanelock-results"
            assert numbers(path)
        there = entries(self.folder)
        assert self._entries <= there
        kept = {stage_of(name) for name in self._entries}
        again = [stage for stage, cached in found.done if flat(stage) in kept and not cached]
        assert not again
        points = records(self.folder)
        for name, count in self._points.items():
            assert points.get(name, count) >= count, f"{name} lost points"
        self._entries, self._points = there, points
        return found

    def forget(self, prefix: str) -> None:
        """Remove what a stage has left that ended before its kill, so that it comes once more."""
        for path in (self.folder / "cache").rglob("*.h5"):
            if stage_of(path.name).startswith(flat(prefix)):
                path.unlink()
        for path in self.folder.glob(f"{prefix}*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        self._entries = entries(self.folder)

    def tear(self, rng: np.random.Generator) -> None:
        """Cut the end of a file of points off, as a kill does in the middle of a write."""
        for path in (self.folder / "cache").glob("*.points"):
            content = path.read_bytes()
            path.write_bytes(content[: -int(rng.integers(1, 2000))])
        self._points = {}

    def finish(self, uninterrupted: Path) -> None:
        """Run to the end, which must be that of the run that was not killed.

        All numbers are; those of a response under way agree to 1e-9 of the largest.
        """
        found = self.look(None)
        assert found.status == 0, found.errors
        one, other = (numbers(each / "results.h5") for each in (self.folder, uninterrupted))
        assert one.keys() == other.keys()
        assert [name for name in one if not same(one[name], other[name])] == []
        assert one["@complete"]
        tables = [sorted(each.glob("figures/*.csv")) for each in (self.folder, uninterrupted)]
        for pair in zip(*tables, strict=True):
            texts = [path.name + path.read_text() for path in pair]
            assert DECIMAL.sub("", texts[0]) == DECIMAL.sub("", texts[1])
            read = [np.array(DECIMAL.findall(text), float) for text in texts]
            np.testing.assert_allclose(read[0], read[1], rtol=1e-6)
        assert [*self.folder.rglob(".*.tmp"), *self.folder.rglob("*.points")] == []


def stage_of(entry: str) -> str:
    """Stage of a cache entry by its name, <stage>-<key>-<digest>.h5."""
    return entry.rsplit("-", 2)[0]


def flat(stage: str) -> str:
    """A stage's name as its cache entries have it."""
    return "".join(c if c.isalnum() else "-" for c in stage)
