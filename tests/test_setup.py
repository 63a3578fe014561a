"""The set-up, without optional libraries, the wheel and the release: each says what it needs."""

import hashlib
import os
import re
import runpy
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import files
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import vanelock
from vanelock.commands.installed import pages
from vanelock.common.process import installed
from vanelock.pipeline import cache
from vanelock.pipeline.executor import _identity

ROOT = Path(__file__).resolve().parent.parent
# Any Debian with Python has these.
ALWAYS_THERE = {"c", "dl", "m", "pthread", "rt", "stdc++", "gcc_s", "z"}


@pytest.fixture
def tools(monkeypatch):
    """The set-up's main module, `tools/environment.py`; `.system_packages` is the other one."""
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    for name in ["environment", "system_packages"]:
        monkeypatch.delitem(sys.modules, name, raising=False)
    import environment

    module: ModuleType = environment
    return module


@pytest.fixture
def without_sudo(tmp_path, monkeypatch):
    """Where a stand-in for apt-get, alone on the PATH of a user without sudo, writes its calls."""
    log, commands = tmp_path / "log", tmp_path / "bin"
    log.touch()
    commands.mkdir()
    (commands / "apt-get").write_text(f'#!/bin/sh\necho "$@" >> "{log}"\n')
    (commands / "apt-get").chmod(0o755)
    monkeypatch.setenv("PATH", str(commands))
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    return log


def test_what_gmsh_links_to_is_looked_for(tools):
    (library,) = [
        path for path in files("gmsh") or [] if re.search(r"libgmsh\.so\.[\d.]+$", str(path))
    ]
    names = re.findall(rb"\0(lib[\w+-]+\.so\.\d+)(?=\0)", library.read_binary()[: 2**24])
    needed = {name.decode() for name in names}
    assert {"libGLU.so.1", "libc.so.6"} <= needed
    known = set(tools.system_packages.REQUIRED_LIBRARIES)
    assert {n for n in needed - known if n[3:].split(".so")[0] not in ALWAYS_THERE} == set()


def test_user_without_sudo_is_given_the_line(tools, without_sudo, monkeypatch):
    """A compiler that is missing alone does not stop the set-up."""
    line = "apt-get install --yes --no-install-recommends {}gcc"
    monkeypatch.setattr(tools.system_packages, "missing_required", lambda: ["libgl1", "libegl1"])
    monkeypatch.setattr(tools.system_packages, "missing_for_cholmod", lambda: ["gcc"])
    with pytest.raises(SystemExit) as stop:
        tools._system()
    said = f"    apt-get update && {line.format('libgl1 libegl1 ')}\n"
    assert said in str(stop.value.code)
    assert without_sudo.read_text() == ""
    monkeypatch.setattr(tools.system_packages, "missing_required", list)
    assert line.format("") in tools._system()


def test_parts_of_the_lock_are_installed_by_themselves(tools):
    text = (ROOT / "requirements.lock").read_text()
    built = tools.locked(text, "cholmod")
    assert re.fullmatch(r"scikit-sparse==[\d.]+ \\\n    --hash=sha256:\w{64}\n", built)
    assert "\nmkl==" in tools.locked(text, "pardiso")
    first = tools.locked(text, "test, docs", only=("pip", "Cython"))
    assert re.findall(r"^([\w.-]+)==", first, re.MULTILINE) == ["cython", "pip"]
    assert "scikit-sparse" not in tools.locked(text, "test, docs")
    assert "mkl==" not in tools.locked(text, "test, docs")


def test_a_file_whose_digest_is_not_in_the_lock_is_refused(tools, tmp_path, monkeypatch):
    wheel = tmp_path / "vane_toy-1.0-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as file:
        for name, text in (
            ("METADATA", "Metadata-Version: 2.1\nName: vane-toy\nVersion: 1.0\n"),
            ("WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"),
            ("RECORD", ""),
        ):
            file.writestr(f"vane_toy-1.0.dist-info/{name}", text)
    lock = tmp_path / "requirements.lock"
    monkeypatch.setattr(tools, "ROOT", tmp_path)
    monkeypatch.setattr(tools, "PYTHON", Path(sys.executable))
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path))
    options = ("--dry-run", "--no-index")
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()
    entry = "# For: toys\nvane-toy==1.0 \\\n    --hash=sha256:{}\n"
    lock.write_text(entry.format(digest))
    tools._pip_locked("toys", *options)
    lock.write_text(entry.format("0" * 64))
    with pytest.raises(subprocess.CalledProcessError):
        tools._pip_locked("toys", *options)


@pytest.mark.system
def test_skipped_and_expected_failures_count_as_failed(tmp_path):
    shutil.copy(ROOT / "conftest.py", tmp_path)
    (tmp_path / "test_one.py").write_text(
        "import pytest\n"
        "def test_runs(): pass\n"
        "@pytest.mark.skip\n"
        "def test_skipped(): pass\n"
        "@pytest.mark.xfail\n"
        "def test_expected(): assert False\n"
        "@pytest.mark.xfail\n"
        "def test_better_than_expected(): pass\n"
    )
    (tmp_path / "test_two.py").write_text("import pytest\npytest.importorskip('no_such_module')\n")
    command = [sys.executable, "-m", "pytest", "-c", "/dev/null", "-p", "no:cacheprovider"]
    for options, said, status in (
        ((), "1 passed, 2 skipped, 1 xfailed, 1 xpassed in", 0),
        (("-n", "2", "--everything"), "2 failed, 1 passed, 2 errors in", 1),
    ):
        done = subprocess.run(
            [*command, *options, "--rootdir", tmp_path, tmp_path], capture_output=True, text=True
        )
        assert said in done.stdout
        assert done.returncode == status


OPTIONAL = ("sksparse", "pypardiso", "ansys", "distributed", "dask", "pandas", "xarray", "pyuff")

HIDING = """
import sys

class Hiding:
    def __init__(self, finder):
        self.finder = finder
    def __getattr__(self, name):
        return getattr(self.finder, name)
    def find_spec(self, name, *rest):
        return None if name.split(".")[0] in {0} else self.finder.find_spec(name, *rest)

sys.meta_path[:] = map(Hiding, sys.meta_path)
"""
"""Python runs it before anything else."""


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """An environment in which no optional library is found."""
    folder = tmp_path_factory.mktemp("bare")
    (folder / "sitecustomize.py").write_text(HIDING.format(OPTIONAL))
    paths = [str(folder), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def run(bare: dict[str, str], folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *command], cwd=folder, env=bare, capture_output=True, text=True
    )


def test_every_optional_library_is_blocked_here():
    """The list above is that of pyproject's extras which the program itself uses."""
    with open(ROOT / "pyproject.toml", "rb") as file:
        extras = set(tomllib.load(file)["project"]["optional-dependencies"])
    own = {"cholmod", "pardiso", "ansys", "cluster", "frames", "uff"}
    assert extras - {"test", "docs", "mutants"} == own


NEEDING = {
    "frame(Table('', (), []), {})": ": needs pandas: pip install 'vanelock[frames]'",
    "dataset({}, [], [], {})": ": needs xarray: pip install 'vanelock[frames]'",
    "read_universal(Path('a.uff'), 1, None, None, None)": (
        "a.uff: needs pyuff: pip install 'vanelock[uff]'"
    ),
    "read_mesh('a.cdb')": "a.cdb: needs ansys-mapdl-reader: pip install 'vanelock[ansys]'",
    "chosen_workers(1, 'tcp://127.0.0.1:1', print, Path('a'))": (
        "--scheduler tcp://127.0.0.1:1: needs Dask: pip install '"
    ),
    "load_matrices(Path('a.full'), None)": "pip install 'vanelock[ansys]'",
}
"""What needs a library, and what its line says."""
CODE = """
from pathlib import Path
import numpy as np, scipy.sparse as sp
from vanelock import fem
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.fem.matrix_files import load_matrices
from vanelock.input.measured.universal import read_universal
from vanelock.mesh import read_mesh
from vanelock.pipeline.executor import chosen_workers
from vanelock.commands.stored.run import dataset, frame
print(*fem.backends())
solve = fem.factorise(sp.csc_array([[2.0, -1.0], [-1.0, 2.0]]))
print(*np.round(solve.solve(np.array([1.0, 0.0])), 12))
for call in NEEDING:
    try:
        exec(call)
    except InputError as error:
        print(error)
"""


def test_superlu_takes_the_place_of_other_solvers_and_a_line_says_what_else_is_needed(
    bare, tmp_path
):
    for file in ("a.uff", "a.cdb", "a.full"):
        (tmp_path / file).write_bytes(bytes(1000))
    done = run(bare, tmp_path, "-c", f"NEEDING = {list(NEEDING)}\n{CODE}")
    assert done.stderr == ""
    solver, solved, *lines = done.stdout.splitlines()
    assert (solver, solved) == ("superlu", "0.666666666667 0.333333333333")
    assert len(lines) == len(NEEDING)
    for line, end in zip(lines, NEEDING.values(), strict=True):
        assert end in line
    assert lines[-1].startswith("a.full: ")


def pyproject() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())


def version_of(tree: Path, path: str = "/usr/bin:/bin") -> str:
    """What a build in this folder would be called."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-m", "setuptools_scm"],
        cwd=tree,
        env={"PATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def git(tree: Path, *arguments: str) -> bytes:
    who = ("-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "init.defaultBranch=main")
    done = subprocess.run(["git", *who, *arguments], cwd=tree, capture_output=True, check=True)
    return done.stdout


def test_all_that_tell_the_version_agree(tmp_path):
    left = tmp_path / "vanelock.egg-info" / "PKG-INFO"  # by a build, in the folder we are in
    left.parent.mkdir()
    left.write_text("Metadata-Version: 2.1\nName: vanelock\nVersion: 9.9\n")
    done = subprocess.run(
        [sys.executable, "-m", "vanelock", "--version"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    manual = runpy.run_path(str(ROOT / "docs" / "conf.py"))
    assert done.stdout == f"vanelock {vanelock.__version__}\n"
    assert vanelock.__version__ == manual["release"] != "9.9"
    assert installed("no-such-package") == "none"
    assert installed("numpy") == np.__version__


def test_the_release_is_cited_described_and_fallen_back_on():
    (cited,) = re.findall(
        r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), flags=re.MULTILINE
    )
    described = re.findall(
        r"^## \[(\d[^]]*)\]", (ROOT / "CHANGELOG.md").read_text(), flags=re.MULTILINE
    )
    assert described[0] == cited
    assert pyproject()["tool"]["setuptools_scm"]["fallback_version"].partition(".dev")[0] == cited
    now = version_of(ROOT)
    if ".dev" not in now:  # at a tag, or in what was made of one
        assert now == cited


def test_a_commit_leaves_what_the_cache_holds_valid(monkeypatch):
    def keys(said: str) -> tuple[str, str, str]:
        monkeypatch.setattr(cache, "__version__", said)
        cache.code_of.cache_clear()
        return cache.code_of("fem"), cache.key_of("mesh", "mesh", {"size": 1}), _identity()

    try:
        first = keys("0.1.0.dev12")
        assert keys("0.1.0.dev13") == keys("0.1.0") == first
        assert first[0].startswith("0.1.0+")
        assert not set(keys("0.2.0")) & set(first)
    finally:
        cache.code_of.cache_clear()


STAGES = ["mesh", "fem", "rom", "nonlinear"]


def pip(*arguments: str | Path) -> None:
    command = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments]
    subprocess.run(command, check=True)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Built from a copy, since setuptools would reuse a `build` folder that lies in the tree."""
    copy = tmp_path_factory.mktemp("tree") / "vanelock"
    copy.mkdir()
    for name in ["pyproject.toml", "README.md", "LICENSE"]:
        shutil.copy(ROOT / name, copy)
    for name in ["vanelock", *STAGES, "docs", "examples"]:
        leave = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, copy / name, symlinks=True, ignore=leave)
    target = tmp_path_factory.mktemp("wheel")
    pip("wheel", "--no-deps", "--no-index", "--no-build-isolation", "--wheel-dir", target, copy)
    (path,) = target.glob("*.whl")
    return path


@pytest.mark.system
def test_wheel_holds_the_package_and_nothing_else(wheel):
    modules = {str(path.relative_to(ROOT)) for path in (ROOT / "vanelock").rglob("*.py")}
    for stage in STAGES:
        modules |= {f"vanelock/{path.relative_to(ROOT)}" for path in (ROOT / stage).rglob("*.py")}
    data = {"vanelock/py.typed"}
    for folder in ("vanelock/input/templates", "vanelock/report/page"):
        data |= {f"{folder}/{p.name}" for p in (ROOT / folder).iterdir() if p.is_file()}
    for name, page in pages().items():
        assert page.is_file()
        data.add(f"vanelock/manual/{name}.md")
    data.add("vanelock/manual/index.md")
    examples = [*(ROOT / "examples").glob("*.toml"), *(ROOT / "examples").glob("*/*")]
    data |= {f"vanelock/{p.relative_to(ROOT)}" for p in examples if p.is_file()}
    data -= modules | {"vanelock/input/templates/__init__.py"}
    with zipfile.ZipFile(wheel) as archive:
        held = {name for name in archive.namelist() if ".dist-info/" not in name}
        metadata = {Path(name).name for name in archive.namelist() if ".dist-info/" in name}
    assert held == modules | data
    assert {"METADATA", "LICENSE", "entry_points.txt"} <= metadata
