"""The set-up: it looks for what gmsh needs, stops with the exact line, and rests once done."""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import files
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parent.parent
# Any Debian with Python has these.
ALWAYS_THERE = {"c", "dl", "m", "pthread", "rt", "stdc++", "gcc_s", "z"}


@pytest.fixture
def tools(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The set-up's main module, `tools/environment.py`; `.system_packages` is the other one."""
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    for name in ["environment", "system_packages"]:
        monkeypatch.delitem(sys.modules, name, raising=False)
    import environment

    module: ModuleType = environment
    return module


@pytest.fixture
def without_sudo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where a stand-in for apt-get, alone on the PATH of a user without sudo, writes its calls."""
    log, commands = tmp_path / "log", tmp_path / "bin"
    log.touch()
    commands.mkdir()
    (commands / "apt-get").write_text(f'#!/bin/sh\necho "$@" >> "{log}"\n')
    (commands / "apt-get").chmod(0o755)
    monkeypatch.setenv("PATH", str(commands))
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    return log


def test_what_gmsh_links_to_is_looked_for(tools: ModuleType) -> None:
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


def test_parts_of_the_lock_are_installed_by_themselves(tools: ModuleType) -> None:
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
def test_skipped_and_expected_failures_count_as_failed(tmp_path: Path) -> None:
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
