"""One version, from the tag in git; what says it elsewhere agrees; a commit changes no key."""

import re
import runpy
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vanelock
from vanelock.common.process import installed
from vanelock.pipeline import cache
from vanelock.pipeline.executor import _identity

ROOT = Path(__file__).resolve().parent.parent


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


def test_all_that_tell_the_version_agree(tmp_path: Path) -> None:
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


def test_the_release_is_cited_described_and_fallen_back_on() -> None:
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


def test_a_commit_leaves_what_the_cache_holds_valid(monkeypatch: pytest.MonkeyPatch) -> None:
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
