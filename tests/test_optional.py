"""Without the optional libraries everything else works, and what needs one says so in a line."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
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
def bare(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment in which no optional library is found."""
    folder = tmp_path_factory.mktemp("bare")
    (folder / "sitecustomize.py").write_text(HIDING.format(OPTIONAL))
    paths = [str(folder), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def run(bare: dict[str, str], folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *command], cwd=folder, env=bare, capture_output=True, text=True
    )


def test_every_optional_library_is_blocked_here() -> None:
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
