"""The wheel, built from a copy of the tree, holds every module and works away from the tree."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from vanelock.commands.installed import pages

ROOT = Path(__file__).resolve().parent.parent
pytestmark = pytest.mark.system
STAGES = ["mesh", "fem", "rom", "nonlinear"]


def pip(*arguments: str | Path) -> None:
    command = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments]
    subprocess.run(command, check=True)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
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


def test_wheel_holds_the_package_and_nothing_else(wheel: Path) -> None:
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
