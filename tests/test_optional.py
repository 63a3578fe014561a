"""Without the optional libraries everything else works, and what needs one says so in a line."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
OPTIONAL = ("sksparse", "pypardiso", "ansys", "distributed", "dask")

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
def bare(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment in which no optional library is found."""
    folder = tmp_path_factory.mktemp("bare")
    (folder / "sitecustomize.py").write_text(HIDING.format(OPTIONAL))
    paths = [str(folder), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def told(bare: dict[str, str], folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *command], cwd=folder, env=bare, capture_output=True, text=True
    )


def test_every_optional_library_is_blocked_here() -> None:
    """The list above is that of pyproject's extras which the program itself uses."""
    with open(ROOT / "pyproject.toml", "rb") as file:
        extras = set(tomllib.load(file)["project"]["optional-dependencies"])
    assert extras - {"test", "docs", "mutants"} == {"cholmod", "pardiso", "ansys", "cluster"}


def test_a_cluster_without_dask(bare: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text('[mesh]\nsize = "coarse"\n')
    done = told(
        bare, tmp_path, "-m", "vanelock", "run", "a.toml", "--scheduler", "tcp://127.0.0.1:1"
    )
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith("vanelock: --scheduler tcp://127.0.0.1:1: needs Dask: pip install '")


def test_a_full_file_without_its_reader(bare: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "a.full").write_bytes(bytes(1000))
    code = (
        "from pathlib import Path\n"
        "from vanelock.common.errors import InputError\n"
        "from vanelock.fem.matrix_files import load_matrices\n"
        "try: load_matrices(Path('a.full'), None)\n"
        "except InputError as error: print(error)"
    )
    done = told(bare, tmp_path, "-c", code)
    assert done.stderr == ""
    (line,) = done.stdout.splitlines()
    assert line.startswith("a.full: ")
    assert "pip install 'vanelock[ansys]'" in line


def test_superlu_takes_the_place_of_other_solvers(bare: dict[str, str], tmp_path: Path) -> None:
    code = (
        "import numpy as np, scipy.sparse as sp\n"
        "from vanelock import fem\n"
        "print(*fem.backends())\n"
        "solve = fem.factorise(sp.csc_array([[2.0, -1.0], [-1.0, 2.0]]))\n"
        "print(*np.round(solve.solve(np.array([1.0, 0.0])), 12))"
    )
    done = told(bare, tmp_path, "-c", code)
    assert done.stderr == ""
    assert done.stdout.splitlines() == ["superlu", "0.666666666667 0.333333333333"]
