"""Without the optional libraries everything else works, and what needs one says so in a line."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
OPTIONAL = (
    "sksparse",
    "pypardiso",
    "ansys",
    "distributed",
    "dask",
    "pandas",
    "xarray",
    "pyuff",
)

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


def test_a_cluster_without_dask(bare: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text('[mesh]\nsize = "coarse"\n')
    done = run(
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
    done = run(bare, tmp_path, "-c", code)
    assert done.stderr == ""
    (line,) = done.stdout.splitlines()
    assert line.startswith("a.full: ")
    assert "pip install 'vanelock[ansys]'" in line


NEEDING = {
    "pandas": "from vanelock.results.reading.frames import frame\nframe(Table('', (), []), {})",
    "xarray": "from vanelock.results.reading.frames import dataset\ndataset({}, [], [], {})",
    "pyuff": "from vanelock.input.measured.universal import read_universal\n"
    "read_universal(Path('a.uff'), 1, None, None, None)",
    "ansys-mapdl-reader": "from vanelock.mesh import read_mesh\nread_mesh('a.cdb')",
}
"""What needs a library."""


@pytest.mark.parametrize(
    ("name", "extra"),
    [("pandas", "frames"), ("xarray", "frames"), ("pyuff", "uff"), ("ansys-mapdl-reader", "ansys")],
)
def test_one_line_says_what_to_install(
    bare: dict[str, str], tmp_path: Path, name: str, extra: str
) -> None:
    for file in ("a.uff", "a.cdb"):
        (tmp_path / file).write_bytes(bytes(1000))
    code = (
        "from pathlib import Path\n"
        "from vanelock.common.errors import InputError\n"
        "from vanelock.common.tables import Table\n"
        f"try: exec({NEEDING[name]!r})\n"
        "except InputError as error: print(error)"
    )
    done = run(bare, tmp_path, "-c", code)
    assert done.stderr == ""
    (line,) = done.stdout.splitlines()
    assert line.endswith(f": needs {name}: pip install 'vanelock[{extra}]'")


def test_superlu_takes_the_place_of_other_solvers(bare: dict[str, str], tmp_path: Path) -> None:
    code = (
        "import numpy as np, scipy.sparse as sp\n"
        "from vanelock import fem\n"
        "print(*fem.backends())\n"
        "solve = fem.factorise(sp.csc_array([[2.0, -1.0], [-1.0, 2.0]]))\n"
        "print(*np.round(solve.solve(np.array([1.0, 0.0])), 12))"
    )
    done = run(bare, tmp_path, "-c", code)
    assert done.stderr == ""
    assert done.stdout.splitlines() == ["superlu", "0.666666666667 0.333333333333"]
