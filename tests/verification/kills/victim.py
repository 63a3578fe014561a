"""A run that is killed and begun again, and what must hold every time."""

import re
import shutil
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from tests.verification.kills import killing
from tests.verification.kills.killing import Moment

DECIMAL = re.compile(r"-?\d+\.\d+(?:e[-+]\d+)?|-?\d+e[-+]\d+")
"""A number that is not whole."""


class Victim:
    """A run that is killed and begun again, in one folder."""

    def __init__(self, study: Path, folder: Path) -> None:
        self.study, self.folder = study, folder
        self.hits: Counter[str] = Counter()
        self.kills = 0
        self._entries: set[str] = set()
        self._points: dict[str, int] = {}

    def kill(self, moment: Moment) -> killing.Outcome:
        """Kill once, and look at what is left."""
        found = killing.run(self.study, self.folder, moment)
        self.look(found)
        self.kills += found.status == -9
        self.hits[moment.name] += found.hit
        return found

    def look(self, found: killing.Outcome) -> None:
        """Nothing that was finished is lost or computed again, no file is half written."""
        assert "Traceback" not in found.errors, found.errors
        assert found.status in (0, -9), found.errors
        assert not found.left
        assert killing.readable(self.folder)
        there = killing.entries(self.folder) if self.folder.exists() else set()
        assert self._entries <= there
        kept = {stage_of(name) for name in self._entries}
        again = [stage for stage, cached in found.done if flat(stage) in kept and not cached]
        assert not again
        points = killing.records(self.folder)
        for name, count in self._points.items():
            assert points.get(name, count) >= count, f"{name} lost points"
        self._entries, self._points = there, points

    def forget(self, prefix: str) -> None:
        """Remove what a stage has left that ended before its kill, so that it comes once more."""
        for path in (self.folder / "cache").rglob("*.h5"):
            if stage_of(path.name).startswith(flat(prefix)):
                path.unlink()
        for path in self.folder.glob(f"{prefix}*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        self._entries = killing.entries(self.folder)

    def tear(self, rng: np.random.Generator) -> None:
        """Cut the end of a file of points off, as a kill does in the middle of a write."""
        for path in (self.folder / "cache").glob("*.points"):
            content = path.read_bytes()
            path.write_bytes(content[: -int(rng.integers(1, 2000))])
        self._points = {}


def stage_of(entry: str) -> str:
    """Stage of a cache entry by its name, <stage>-<key>-<digest>.h5."""
    return entry.rsplit("-", 2)[0]


def flat(stage: str) -> str:
    """A stage's name as its cache entries have it."""
    return "".join(c if c.isalnum() else "-" for c in stage)


def finish(victim: Victim, whole: Path) -> None:
    """Run to the end, which must be that of the run that was not killed."""
    found = killing.run(victim.study, victim.folder)
    victim.look(found)
    assert found.status == 0, found.errors
    compare(victim.folder, whole)
    left = [*victim.folder.rglob(".*.tmp"), *victim.folder.rglob("*.points")]
    assert left == []


def compare(folder: Path, whole: Path) -> None:
    """All numbers of two runs; those of a response under way agree to 1e-9 of the largest."""
    one, other = (killing.numbers(each / "results.h5") for each in (folder, whole))
    assert one.keys() == other.keys()
    assert [name for name in one if not same(one[name], other[name])] == []
    assert one["@complete"]
    tables = [sorted(each.glob("figures/*.csv")) for each in (folder, whole)]
    for table, like in zip(*tables, strict=True):
        texts = table.read_text(), like.read_text()
        assert DECIMAL.sub("", f"{table.name}{texts[0]}") == DECIMAL.sub("", like.name + texts[1])
        read = [np.array([float(each) for each in DECIMAL.findall(text)]) for text in texts]
        np.testing.assert_allclose(read[0], read[1], rtol=1e-6)


def same(value: Any, expected: Any) -> bool:
    """Whether two arrays agree, numbers that are not whole to 1e-9 of the largest among them."""
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fc":
        return bool(np.array_equal(value, expected))
    apart = 1e-9 * np.nanmax(np.abs(expected), initial=0.0, where=np.isfinite(expected))
    alike = value.shape == expected.shape
    return alike and bool(np.allclose(value, expected, rtol=0.0, atol=apart, equal_nan=True))
