"""Build sdist and wheel into dist/, try them in empty environments, print what was found.

Run by `make wheel`, or with other interpreters: `python tools/wheel.py python3.12 python3.13`. Each
environment gets the wheel and what it requires, nothing else, and works in a folder away from the
source: its version and manual, examples, a smoke study, then part of the tests. What it prints
last is what docs/start/install.md says of it.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import venv
import zipfile
from email.parser import Parser
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DIST = ROOT / "dist"
TESTS = (
    "vanelock/common/test_product.py",
    "vanelock/common/test_quantities.py",
    "vanelock/commands/test_guidance.py",
    "mesh/geometry/test_dimensions.py",
    "vanelock/input/test_read_study.py",
    "vanelock/input/cases/test_sweep.py",
    "docs/test_theory.py",
)
"""Part of the tests that needs no browser and little time."""
SMOKE = """
name = "smoke"
[mesh]
size = "coarse"
[rom]
modes = 10
[response]
frequencies = [260, 265, 270]
harmonics = 1
"""


def main() -> None:
    """Build, look at the metadata, try every interpreter."""
    pythons = sys.argv[1:] or [sys.executable]
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        tool = _environment(work / "tools", sys.executable, "build", "twine")
        wheel, sdist = build(tool, work / "dist")
        run(tool, "-m", "twine", "check", "--strict", wheel, sdist)
        print(f"{wheel.name}: {_size(wheel)}; {sdist.name}: {_size(sdist)}; metadata passed")
        for extra, outcome in extras(tool, wheel).items():
            print(f"extra {extra}: {outcome}")
        print("\n| Python | install | environment | smoke study | part of the tests |")
        print("|---|---:|---:|---:|---|", flush=True)
        for i, python in enumerate(pythons):
            print(_tried(python, wheel, work / f"env{i}"), flush=True)


def build(tool: Path, place: Path) -> tuple[Path, Path]:
    """Both; the wheel is made of the sdist, as pip would make it."""
    run(tool, "-m", "build", "--outdir", place, ROOT)
    (wheel,), (sdist,) = place.glob("*.whl"), place.glob("*.tar.gz")
    DIST.mkdir(exist_ok=True)
    return DIST / shutil.copy(wheel, DIST), DIST / shutil.copy(sdist, DIST)


def extras(tool: Path, wheel: Path) -> dict[str, str]:
    """Whether pip finds versions that fit together for every extra."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        metadata = Parser().parsestr(archive.read(name).decode())
    found = {}
    for extra in metadata.get_all("Provides-Extra") or []:
        command = (tool, "-m", "pip", "install", "--quiet", "--dry-run", "--report", "-")
        done = subprocess.run((*command, f"{wheel}[{extra}]"), capture_output=True, text=True)
        if done.returncode:
            found[extra] = f"NOT RESOLVED: {done.stderr.strip().splitlines()[-1]}"
            continue
        wanted = json.loads(done.stdout)["install"]
        found[extra] = f"{len(wanted)} packages with all that they need"
    return found


def _tried(python: str, wheel: Path, place: Path) -> str:
    """One row of the table."""
    began = time.monotonic()
    own = _environment(place, python, str(wheel))
    installed = time.monotonic() - began
    size = sum(path.stat().st_size for path in place.rglob("*") if path.is_file()) / 1e6
    run(own, "-m", "pip", "check")
    away = place / "away"
    away.mkdir()
    (away / "smoke.toml").write_text(SMOKE)
    command = place / "bin" / "vanelock"
    _asked(command, wheel, away)
    began = time.monotonic()
    run(command, "run", "smoke.toml", "--quiet", cwd=away)
    smoke = time.monotonic() - began
    for name in ("results.h5", "report.html", "figures/response.png", "shapes/mode_free.png"):
        assert (away / "runs/smoke" / name).stat().st_size > 10_000, name
    version = run(own, "-c", "import platform; print(platform.python_version())")
    run(own, "-m", "pip", "install", "--quiet", "pytest", "hypothesis", "playwright")
    passed = _tests(own, away)
    return f"| {version} | {installed:.0f} s | {size:,.0f} MB | {smoke:.0f} s | {passed} |"


def _asked(command: Path, wheel: Path, away: Path) -> None:
    """What an installation answers at once."""
    version = wheel.name.split("-")[1]
    assert run(command, "--version") == f"vanelock {version}"
    assert "A first study:" in run(command, "--help")
    assert "start/first_study" in run(command, "manual")
    assert run(command, "manual", "keys").startswith("# Every key")
    for name, study in {"vane": "vane.toml", "lap_joint": "lap_joint/scene.toml"}.items():
        run(command, "init", "--example", name, cwd=away)
        run(command, "check", study, cwd=away)


def _tests(own: Path, away: Path) -> str:
    """Run tests from a copy beside nothing of the source but what they read."""
    for name in ("tests", "docs", "examples", "benchmarks"):
        shutil.copytree(ROOT / name, away / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "conftest.py", away)
    chosen = [f"tests/{name}" for name in TESTS if (ROOT / "tests" / name).exists()]
    origin = run(own, "-c", "import vanelock; print(vanelock.__file__)", cwd=away)
    assert Path(origin).is_relative_to(away.parent / "lib"), origin
    printed = run(
        *(own, "-m", "pytest", "-q", "--import-mode=importlib", "-p", "no:cacheprovider"),
        *("-m", "not system", *chosen),
        cwd=away,
    )
    return printed.splitlines()[-1].partition(" in ")[0]


def _environment(place: Path, python: str, *packages: str) -> Path:
    """An empty environment with these packages; its interpreter."""
    if python == sys.executable:
        venv.create(place, with_pip=True)
    else:
        subprocess.run([python, "-m", "venv", place], check=True)
    own = place / "bin" / "python"
    options = ("--quiet", "--disable-pip-version-check", "--no-compile")  # bytecode comes by use
    run(own, "-m", "pip", "install", *options, *packages)
    return own


def run(*command: str | Path, cwd: Path | None = None) -> str:
    """Standard output of a command that must succeed, without this environment's own paths."""
    own = {k: v for k, v in os.environ.items() if k not in {"PYTHONPATH", "VIRTUAL_ENV"}}
    done = subprocess.run(command, cwd=cwd, env=own, text=True, stdout=subprocess.PIPE)
    if done.returncode:
        sys.exit(f"wheel: failed: {' '.join(map(str, command))}\n{done.stdout}")
    return done.stdout.strip()


def _size(path: Path) -> str:
    return f"{path.stat().st_size / 1e3:,.0f} kB"


if __name__ == "__main__":
    main()
