"""What holds for the repository's text: no machine's paths, no package hosts, short files."""

import os
import re
import tomllib
from collections.abc import Iterator
from importlib.metadata import requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parent.parent
GENERATED = {"build", "dist", "runs", "__pycache__"}
TEXT = {".py", ".toml", ".md", ".sh", ".lock", ".html", ".css", ".json", ".yaml", ".yml", ".txt"}
NAMED = {"Makefile", "Dockerfile", "run", "LICENSE", ".gitignore"}

# A home folder or scratch folder of one machine, in any file.
MACHINE_PATH = re.compile(r"(?<![\w.])/(?:home|root|work|Users|mnt|tmp)/\w")
# Where packages come from is each user's own configuration.
PACKAGE_SOURCE = re.compile(
    r"-{2}(?:extra-)?index-url|-{2}find-links|-{2}trusted-host|PIP_[A-Z]*URL"
)
ADDRESS = re.compile(r"\w+://")


def files() -> Iterator[Path]:
    """Every text file of the project, without what tools and runs leave behind."""
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [
            name
            for name in folders
            if name not in GENERATED
            and not name.endswith(".egg-info")
            and (not name.startswith(".") or name in {".ci", ".github"})
        ]
        for name in names:
            path = Path(folder) / name
            if path.suffix in TEXT or name in NAMED:
                yield path


def occurrences(pattern: re.Pattern[str], paths: Iterator[Path]) -> list[str]:
    return [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in paths
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if pattern.search(line)
    ]


@pytest.mark.parametrize("pattern", [MACHINE_PATH, PACKAGE_SOURCE], ids=["path", "source"])
def test_no_file_names_a_machine(pattern):
    assert occurrences(pattern, files()) == []


def test_set_up_names_no_address():
    setting_up = [
        path
        for path in files()
        if path.relative_to(ROOT).parts[0] in {"tools", ".ci", ".github", ".gitlab-ci.yml"}
        or path.name in {"Makefile", "Dockerfile", "pyproject.toml", "requirements.lock"}
    ]
    assert len(setting_up) >= 7
    assert occurrences(ADDRESS, iter(setting_up)) == []


def test_lock_holds_names_versions_and_digests_alone():
    text = (ROOT / "requirements.lock").read_text()
    entry = r"[\w.-]+==[\w.]+(?: \\\n    --hash=sha256:[0-9a-f]{64})+\n"
    assert re.fullmatch(rf"(?:#.*\n|{entry})+", text)
    pins = re.findall(r"^([\w.-]+==[\w.]+) ", text, re.MULTILINE)
    names = {re.split("==", pin)[0].lower().replace("_", "-") for pin in pins}
    assert len(names) == len(pins)
    assert {"numpy", "gmsh", "vtk", "scikit-sparse", "pytest", "setuptools", "cython"} <= names


def test_lock_pins_all_that_is_installed_with_vanelock():
    pins = re.findall(r"^([\w.-]+)==", (ROOT / "requirements.lock").read_text(), re.MULTILINE)
    needed: set[str] = set()
    wanted = [Requirement("vanelock[test,docs]")]
    while wanted:
        parent = wanted.pop()
        for child in map(Requirement, requires(parent.name) or []):
            contexts = [{"extra": extra} for extra in ("", *parent.extras)]
            applies = not child.marker or any(map(child.marker.evaluate, contexts))
            if applies and canonicalize_name(child.name) not in needed:
                needed.add(canonicalize_name(child.name))
                wanted.append(child)
    assert len(needed) > 40
    assert needed - {canonicalize_name(pin) for pin in pins} == set()


def test_no_file_is_too_long_to_read():
    long = {
        str(path.relative_to(ROOT)): length
        for path in files()
        if path.suffix == ".py" and (length := len(path.read_text().splitlines())) >= 400
    }
    for path in list(long):
        if path.startswith("vanelock/analyses/"):  # an analysis is one file
            assert long.pop(path) < 450
    assert long.pop("examples/paper/paper.py") <= 900  # one script, to be copied and changed
    assert long == {}


def test_tests_that_are_named_as_slow_are_there():
    for name in tomllib.loads((ROOT / "tools" / "slow.toml").read_text()):
        file, _, function = name.partition("::")
        assert f"\ndef {function}(" in (ROOT / file).read_text(), name
