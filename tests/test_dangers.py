"""No source runs what a file says: no pickle, no eval, no shell; and messages stay plain text."""

import ast
import csv
from pathlib import Path

import pytest

from vanelock.common.errors import cut_short, printable
from vanelock.common.files.csv_table import write_columns
from vanelock.common.tables import Column, Table
from vanelock.pipeline.text_table import text_lines

ROOT = Path(__file__).resolve().parents[1]
STARTERS = ("run", "Popen", "call", "check_output", "check_call")
SOURCES = sorted(
    path
    for folder in ROOT.iterdir()
    if folder.is_dir() and (folder / "__init__.py").exists() and folder.name != "tests"
    for path in folder.rglob("*.py")
    if not any(part.is_symlink() for part in path.relative_to(ROOT).parents)
)
MODULES = set("pickle cPickle dill cloudpickle joblib shelve marshal yaml jsonpickle".split())
CALLS = {"eval", "exec", "compile", "__import__", "execfile"}
METHODS = {
    "os.system", "os.popen", "pickle.load", "pickle.loads", "yaml.load", "numpy.load", "np.load",
    "pandas.read_pickle", "pd.read_pickle", "pandas.eval", "numexpr.evaluate", "tempfile.mktemp",
}  # fmt: skip


def dangers(source: str) -> list[str]:
    """What a source does that a hostile file could use, with its line."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Import | ast.ImportFrom | ast.Call):
            continue
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name.partition(".")[0] for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [(node.module or "").partition(".")[0]]
        found += [f"{node.lineno}: import {name}" for name in names if name in MODULES]
        if not isinstance(node, ast.Call):
            continue
        called = ast.unparse(node.func)
        plain = any(ast.unparse(each) == "allow_pickle=False" for each in node.keywords)
        if called in CALLS or (called in METHODS and not plain):
            found.append(f"{node.lineno}: {called}")
        for each in node.keywords:
            constant = each.value.value if isinstance(each.value, ast.Constant) else True
            runs = called.rpartition(".")[2] in STARTERS
            if constant and (each.arg == "allow_pickle" or (runs and each.arg == "shell")):
                found.append(f"{node.lineno}: {called}({each.arg})")
    return found


@pytest.mark.parametrize(
    "source",
    [
        "import pickle", "from pickle import loads", "import yaml", "eval('1')", "exec(text)",
        "subprocess.run(x, shell=True)", "np.load(path)", "np.load(path, allow_pickle=True)",
        "os.system('x')", "joblib.load(x); import joblib", "__import__(name)",
        "np.load(path, allow_pickle=given)",
    ],
)  # fmt: skip
def test_dangers_are_seen(source):
    assert dangers(source)


def test_what_is_harmless():
    assert not dangers("np.load(path, allow_pickle=False); re.compile(x); model.eval()")


def test_sources_are_found():
    assert len(SOURCES) > 300
    folders = {path.relative_to(ROOT).parts[0] for path in SOURCES}
    assert {"vanelock", "mesh", "fem", "rom", "nonlinear"} <= folders


def test_no_source_runs_what_a_file_says():
    found = [f"{p.relative_to(ROOT)}: {each}" for p in SOURCES for each in dangers(p.read_text())]
    assert not found


def test_compiled_kernels_are_the_user_s_own():
    """They are loaded as code: beside the sources or in the user's cache, not in a run's folder."""
    from vanelock.nonlinear.fourier import _folder

    kept = _folder()
    assert kept is not None
    folder = Path(kept)
    assert folder.is_relative_to(ROOT) or folder.is_relative_to(Path.home())


def test_control_characters_do_not_reach_a_terminal():
    assert printable("a\x1b[2Jb\u2028c\u202ed\x07\n") == "a?[2Jb?c?d??"
    table = Table("t\x07", (Column("h\x1b]0;x\x07"),), (("c\x1b[1m",),), ("n\x1b[2J",))
    assert text_lines(table) == ["", "t?", " h?]0;x?", " ───────", " c?[1m", "n?[2J"]


def test_long_messages_are_cut():
    assert len(cut_short("x" * 10**6)) == 1000


def test_spreadsheets_do_not_compute_what_a_name_says(tmp_path):
    names = ["=cmd|' /C calc'!A0", "+1+1", "-2+3", "@SUM(A1)", "\t=1", "\t@"]
    names += ["plain", "-5.2", "+1e3"]
    path = write_columns(tmp_path / "t.csv", {"=name": names, "n": [-1.0] * 9}, ["=note"])
    rows = list(csv.reader(path.read_bytes().decode().split("\n")[1:-1]))
    assert rows[0] == ["'=name", "n"]
    cells = [row[0] for row in rows[1:]]
    assert [cell[0] for cell in cells[:6]] == ["'"] * 6
    assert cells[6:] == ["plain", "-5.2", "+1e3"]
    assert rows[1][1] == "-1.0"
