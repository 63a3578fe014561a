"""Nothing finished is lost: points, full disks, files that something else spoils or removes."""

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

import vanelock
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear import PointStore
from vanelock.pipeline.cache import HEAD, Cache, _PointsFile
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages, Step, step
from vanelock.results.files.run_folder import claimed
from vanelock.results.files.writer import Results


@dataclass(frozen=True)
class Numbers(Product):
    values: NDArray[np.float64] = field(metadata={"unit": "m"})


@contextmanager
def disk_of(size: int) -> Iterator[None]:
    """No file may become larger than so many bytes: writing fails as it does on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def reason(caught: pytest.ExceptionInfo[InputError], path: Path) -> str:
    """The reason in an error of one line about a path."""
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{path}: cannot be written: ")
    return line.removeprefix(f"{path}: cannot be written: ")


POINTS: dict[str, tuple[list[float], Any]] = {
    "easily 3 1.5": ([4, 1, 0.25], np.array([[1e-300, -0.0], [np.pi, np.nan]])),
    "point 3 2": ([0, 0, 0], np.empty(0)),
    "point 3 2.5": ([12, 0, 1e3], np.arange(600.0).reshape(20, 3, 10)),
    "along 0 3": ([1, 1, 0], np.ones((1, 1, 1))),
}


@pytest.fixture
def written(tmp_path):
    """A file of four points."""
    path = tmp_path / "a.points"
    with closing(_PointsFile(path, print)) as opened:
        for label, (numbers, unknowns) in POINTS.items():
            opened.add(label, numbers, unknowns)
    return path


def read(path: Path) -> tuple[list[str], list[str]]:
    """Which points a file has, to the bit, and what was said about it."""
    said: list[str] = []
    found = []
    with closing(_PointsFile(path, said.append)) as opened:
        for label, (numbers, unknowns) in POINTS.items():
            if (known := opened.get(label)) is not None:
                assert known[0] == numbers
                assert known[1].shape == unknowns.shape
                assert known[1].tobytes() == unknowns.tobytes()
                found.append(label)
    return found, said


def test_points_come_back_and_more_follow(written):
    assert read(written) == ([*POINTS], [])
    with closing(_PointsFile(written, print)) as opened:
        assert opened.get("more") is None
        opened.add("more", (1, True, 0.5), np.zeros(3))
    assert read(written) == ([*POINTS], [])
    with closing(_PointsFile(written, print)) as opened:
        known = opened.get("more")
        assert known is not None
        assert known[0] == [1, True, 0.5]


def test_a_torn_tail_is_left_out_wherever_it_tears(written):
    content = written.read_bytes()
    ends = [len(HEAD)]
    while ends[-1] < len(content):
        length = int.from_bytes(content[ends[-1] : ends[-1] + 8], "little")
        ends.append(ends[-1] + 12 + length)
    assert len(ends) == 5
    around = [end + more for end in ends for more in range(-20, 20)]
    for size in [*range(40), *(each for each in around if 0 <= each <= len(content))]:
        written.write_bytes(content[:size])
        whole = [*POINTS][: sum(size >= end for end in ends[1:])]
        found, said = read(written)
        assert found == whole
        torn = f"{written}: ends in the middle of a point: what follows is left out"
        assert said == [torn] * (0 < size not in ends), size
        with closing(_PointsFile(written, print)) as opened:  # what follows is in its place
            opened.add("along 0 3", *POINTS["along 0 3"])
        assert read(written) == (list(dict.fromkeys([*whole, "along 0 3"])), [])


def test_a_flipped_bit_ends_a_file_there(written: Path) -> None:
    content = bytearray(written.read_bytes())
    content[content.index(b"point 3 2.5") + 100] ^= 4
    written.write_bytes(content)
    found, said = read(written)
    assert found == [*POINTS][:2]
    assert said == [f"{written}: ends in the middle of a point: what follows is left out"]


def test_two_processes_do_not_write_into_one_file(written):
    with (
        closing(_PointsFile(written, print)) as first,
        closing(_PointsFile(written, print)) as second,
    ):
        assert second.get("along 0 3") is None
        second.add("of the second", (0, 0, 0), np.zeros(1))
        assert first.get("along 0 3") is not None
    assert read(written) == ([*POINTS], [])


def test_points_on_a_full_disk_end_with_a_whole_one(written):
    with disk_of(written.stat().st_size + 500), closing(_PointsFile(written, print)) as opened:
        opened.add("fits", (0, 0, 0), np.zeros(40))
        with pytest.raises(InputError) as caught:
            opened.add("does not", (0, 0, 0), np.zeros(40))
    assert reason(caught, written) == "File too large"
    with closing(_PointsFile(written, print)) as opened:
        assert opened.get("fits") is not None
    assert read(written) == ([*POINTS], [])


def counting(kills: list[int]) -> Step[Numbers]:
    """A stage of ten points that is killed before each of some points in turn."""

    def compute(store: PointStore) -> Numbers:
        found = []
        for i in range(10):
            known = store.get(str(i))
            if known is None:
                if kills and kills[0] == i:
                    del kills[0]
                    raise KeyboardInterrupt
                solved.append(i)
                known = (), np.array([i * i])
                store.add(str(i), *known)
            found.append(known[1][0])
        return Numbers(np.array(found))

    return step("long stage", "rom", {}, Numbers, (), compute, resumes=True)


solved: list[int] = []


def test_a_stage_goes_on_where_it_was_killed(tmp_path):
    solved.clear()
    long = counting([0, 3, 3, 9])
    said: list[str] = []
    for _ in range(4):
        with pytest.raises(KeyboardInterrupt):
            Stages(Cache(tmp_path, said.append), silent).get(long)
    assert [path.suffix for path in tmp_path.iterdir()] == [".points"]
    found = Stages(Cache(tmp_path, said.append), silent).get(long)
    assert found.values.tolist() == [i * i for i in range(10)]
    assert solved == list(range(10))
    assert [path.suffix for path in tmp_path.rglob("*.*")] == [".h5"]  # it has served
    assert said == []


def test_a_full_disk_leaves_the_cache_as_it_was(tmp_path):
    cache, large = Cache(tmp_path / "cache", print), Numbers(np.random.default_rng(1).random(10**5))
    cache.store("small", "key", Numbers(np.arange(10.0)), 1.0)
    before = sorted(cache.folder.rglob("*"))
    with disk_of(100_000), pytest.raises(InputError) as caught:
        cache.store("large", "key", large, 1.0)
    assert reason(caught, cache.folder) == "File too large"
    assert sorted(cache.folder.rglob("*")) == before
    assert cache.load("small", "key", Numbers) is not None
    cache.store("large", "key", large, 1.0)


def test_a_full_disk_leaves_the_results_as_they_were(tmp_path):
    results = Results(tmp_path / "results.h5")
    with results.edit() as file:
        file["one"] = np.arange(10.0)
    results.flush()
    before = results.path.read_bytes()
    for places, named in (((), results.path), (("two",), tmp_path / "results")):
        with disk_of(100_000), pytest.raises(InputError) as caught, results.edit(*places) as file:
            file["two"] = np.arange(1e5)
        assert reason(caught, named) == "File too large"
        assert results.path.read_bytes() == before
        assert [path.name for path in tmp_path.rglob("*.*")] == ["results.h5"]


def test_a_complete_file_of_the_same_study_stays_until_the_next_one_is(tmp_path):
    def begun(settings: str) -> Results:
        results = Results(tmp_path / "results.h5")
        results.wait_for_the_end(settings)
        with results.edit() as file:
            file.require_group("provenance").attrs["settings"] = settings
        return results

    def seen() -> tuple[str, bool, bool]:
        with h5py.File(tmp_path / "results.h5") as file:
            settings = file["provenance"].attrs["settings"]
            return str(settings), bool(file.attrs["complete"]), "more" in file

    first = begun("a")
    with first.edit() as file:
        file.attrs["complete"] = True
    first.end()
    second = begun("a")
    assert seen() == ("a", True, False)
    with second.edit() as file:
        file["more"] = 1
        file.attrs["complete"] = True
    second.flush()
    assert seen() == ("a", True, False)
    second.end()
    assert seen() == ("a", True, True)
    third = begun("b")
    third.flush()
    assert seen() == ("b", False, False)


def test_a_folder_is_held_by_one_run_and_results_removed_under_it_are_reported(tmp_path):
    results = of_one(tmp_path)
    results.path.unlink()
    with pytest.raises(InputError) as caught, results.edit() as file:
        file["two"] = 2
    assert reason(caught, results.path) == "No such file or directory"
    with claimed(tmp_path / "run"):
        with pytest.raises(InputError, match="another run is using this folder"):
            with claimed(tmp_path / "run"):
                pass
        (tmp_path / "run" / "kept.txt").write_text("")
    with claimed(tmp_path / "run"):
        pass


def of_one(folder: Path) -> Results:
    """A results file of one number, at its end."""
    results = Results(folder / "results.h5")
    folder.mkdir(exist_ok=True)
    with results.edit() as file:
        file["one"] = 1
    results.flush()
    results.end()
    return results


def test_parts_of_files_that_a_kill_left_are_swept_up(tmp_path):
    """By the next run, and by one that an error ends."""
    parts = [".results.h5.1.tmp", "cache/.a.1.tmp", "figures/.a.png.1.tmp", "shapes/a/.b.vtu.1.tmp"]

    def left(names: list[str]) -> None:
        for name in names:
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).touch()

    def there() -> set[str]:
        return {str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*") if p.is_file()}

    left([*parts, "figures/mine.tmp", "elsewhere/.a.1.tmp"])
    with suppress(KeyboardInterrupt), claimed(tmp_path):
        during = there()
        left(parts)
        raise KeyboardInterrupt
    assert during == there() == {".lock", "figures/mine.tmp", "elsewhere/.a.1.tmp"}


def command(*arguments: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
    """The program, in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "vanelock", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(Path(vanelock.__file__).resolve().parents[1])},
        **options,
    )


@pytest.mark.system
def test_results_open_in_another_program_are_refused_in_a_line(tmp_path):
    study, folder = tmp_path / "study.toml", tmp_path / "run"
    study.write_text("")
    results = of_one(folder)
    with h5py.File(results.path, "a") as file:  # holds HDF5's lock
        made = command("run", study, "-o", folder)
        assert file["one"][()] == 1
    assert made.returncode == 2
    (line,) = made.stderr.splitlines()
    assert line.startswith(f"vanelock: {results.path}: ")
    assert "another program" in line
