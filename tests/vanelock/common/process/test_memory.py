"""What bounds memory, and what is refused before it runs out."""

import os
import resource
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp

from vanelock import fem
from vanelock.common import process
from vanelock.fem.solvers import backend

STUDY = '[mesh]\nsize = "coarse"\n'
KB = 1024


def machine(path, total, free):
    (path / "self").mkdir(parents=True, exist_ok=True)
    (path / "meminfo").write_text(f"MemTotal: {total} kB\nMemFree: 1 kB\nMemAvailable: {free} kB\n")
    (path / "self" / "status").write_text("Name:\tpython\nVmSize:\t 500 kB\nVmData:\t 200 kB\n")


@pytest.fixture
def proc(tmp_path, monkeypatch):
    """A machine with 8,000 kB, 6,000 of them free, and no control groups."""
    monkeypatch.setattr(process, "_PROC", tmp_path / "proc")
    monkeypatch.setattr(process, "_GROUPS", tmp_path / "groups")
    machine(tmp_path / "proc", 8000, 6000)
    return tmp_path


def limited(monkeypatch, **given):
    """The limits of `ulimit`, bytes."""

    def getrlimit(which):
        names = {resource.RLIMIT_AS: "space", resource.RLIMIT_DATA: "data"}
        found = given.get(names.get(which, ""), resource.RLIM_INFINITY)
        return found, resource.RLIM_INFINITY

    monkeypatch.setattr(resource, "getrlimit", getrlimit)


def test_machine_and_limits_of_the_shell_bound_what_is_not_taken_already(proc, monkeypatch):
    limited(monkeypatch)
    assert process._bounds() == [(8000 * KB, 6000 * KB, "this machine's memory")]
    assert process.capacity() == 8000 * KB
    limited(monkeypatch, space=3000 * KB, data=1000 * KB)
    left = {each.name: each.left / KB for each in process._bounds()}
    assert left["the address space that `ulimit -v` allows"] == 2500
    assert left["the data that `ulimit -d` allows"] == 800
    assert process.capacity() == 1000 * KB


def test_control_groups_bound_a_process_as_those_above_them_do(proc, monkeypatch):
    limited(monkeypatch)
    (proc / "proc" / "self" / "cgroup").write_text("0::/jobs/one\n")
    for name, most, used in (("jobs", "4096000", "1024000"), ("jobs/one", "max", "512000")):
        place = proc / "groups" / name
        place.mkdir(parents=True)
        (place / "memory.max").write_text(most + "\n")
        (place / "memory.current").write_text(used + "\n")
        (place / "memory.stat").write_text("anon 3\ninactive_file 24000\n")
    (group,) = [each for each in process._bounds() if "group" in each.name]
    assert group[:2] == (4096000, 4096000 - 1024000 + 24000)


def test_control_groups_of_the_first_version(proc, monkeypatch):
    limited(monkeypatch)
    (proc / "proc" / "self" / "cgroup").write_text("9:cpu:/x\n8:memory:/docker/ab\n")
    place = proc / "groups" / "memory" / "docker" / "ab"
    place.mkdir(parents=True)
    (place / "memory.limit_in_bytes").write_text("4096000")
    (place / "memory.usage_in_bytes").write_text("96000")
    (place.parent / "memory.limit_in_bytes").write_text(str(2**63 - 4096))  # none
    (place.parent / "memory.usage_in_bytes").write_text("96000")
    (group,) = [each for each in process._bounds() if "group" in each.name]
    assert group[:2] == (4096000, 4000000)


def test_an_unknown_machine_bounds_nothing(tmp_path, monkeypatch):
    limited(monkeypatch)
    monkeypatch.setattr(process, "_PROC", tmp_path)
    assert process._bounds() == []
    assert process.capacity() == np.inf
    process.require(1e15, "anything")


def test_a_factorisation_that_does_not_fit_is_refused_before_it_is_begun(monkeypatch):
    A = sp.diags_array(np.arange(1.0, 1001.0), format="csc")
    assert fem.factorise(A).solve(np.ones(1000))[9] == pytest.approx(0.1)
    little = process._Bound(1e9, 1e6, "a test's memory")
    monkeypatch.setattr(process, "_bounds", lambda: [little])
    said = r"^factorising 1,000 rows takes about 0.00\d+ GB, 0.001 GB of a test's memory are left$"
    with pytest.raises(MemoryError, match=said):
        fem.factorise(A)
    with pytest.raises(MemoryError, match=said):
        fem.schur_complement(A, [0, 1])


def test_what_cholmod_cannot_allocate_is_an_error_and_what_is_used_least_goes_first():
    pytest.importorskip("sksparse")
    from sksparse.cholmod import CholmodOutOfMemoryError

    with pytest.raises(MemoryError, match="CHOLMOD"), backend.cholmod_errors():
        raise CholmodOutOfMemoryError("out of memory")
    kept: dict[str, str] = {}
    for key in "abacb":
        assert process.latest(kept, key, key.upper, 2) == key.upper()
    assert kept == {"c": "C", "b": "B"}


@pytest.mark.system
@pytest.mark.parametrize(
    ("limit", "size", "words"),
    [
        (resource.RLIMIT_AS, 300_000 * KB, "a library cannot be loaded"),
        (resource.RLIMIT_AS, 800_000 * KB, "the smallest run takes 1.5 GB, 0.82 GB is all of"),
        (resource.RLIMIT_DATA, 300_000 * KB, "the smallest run takes 0.5 GB, 0.31 GB is all of"),
    ],
)
def test_a_run_under_a_small_limit_is_one_line_and_status_2(tmp_path, limit, size, words):
    (tmp_path / "study.toml").write_text(STUDY)
    command = [sys.executable, "-m", "vanelock", "run", "study.toml", "--workers", "1"]
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(limit, (size, size)),
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("vanelock: not enough memory (")
    assert words in line
