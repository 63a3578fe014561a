"""Files: paths stay in a study's folder; files are read and written whole or not at all."""

import ast
import csv
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

import vanelock
from vanelock import load_study
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import write_columns
from vanelock.common.files.files import beside, by_library, contents, limited, placed


def refused(folder, given, **options):
    with pytest.raises(InputError) as caught:
        beside(folder, given, "vane.mesh", **options)
    text = str(caught.value)
    assert text.startswith('vane.mesh = "')
    assert text.isprintable()
    return text


@pytest.fixture
def folder(tmp_path):
    """A study's folder with links in it, and a secret beside it."""
    (tmp_path / "secret.inp").write_text("secret")
    here = tmp_path / "study"
    (here / "meshes").mkdir(parents=True)
    (here / "meshes" / "vane.inp").write_text("mine")
    (here / "link.inp").symlink_to(tmp_path / "secret.inp")
    (here / "up").symlink_to(tmp_path)
    (here / "inner.inp").symlink_to("meshes/vane.inp")
    (here / "loop").symlink_to("loop")
    return here


@pytest.mark.parametrize(
    "given", ["meshes/vane.inp", "meshes/../meshes/vane.inp", "inner.inp", "./inner.inp", "new.inp"]
)
def test_what_stays_in_the_folder(folder, given):
    assert beside(folder, given, "vane.mesh") == folder / given
    assert beside(folder, str(folder / "inner.inp"), "vane.mesh") == folder / "inner.inp"


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("../secret.inp", "is outside the study file's folder"),
        ("meshes/../../secret.inp", "is outside"),
        ("/etc/passwd", "is outside"),
        ("link.inp", "a link leads outside"),
        ("up/secret.inp", "a link leads outside"),
        ("up/new.inp", "a link leads outside"),
        ("..", "is outside"),
        ("~/../../x\x1b[31m", "is outside"),
    ],
)
def test_what_leaves_the_folder_needs_leave(folder, given, expected):
    text = refused(folder, given)
    assert expected in text
    assert "--allow-outside" in text
    assert beside(folder, given, "vane.mesh", outside=True) == folder / given


@pytest.mark.parametrize("given", ["a\0b", "loop", "x" * 5000])
def test_what_is_no_path(folder, given):
    assert "no path of a file" in refused(folder, given, outside=True)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('[vane]\nmesh = "../secret.inp"', "vane.mesh"),
        ('[casing]\nmesh = "link.inp"', "casing.mesh"),
        ('[[measured]]\nfile = "a.csv"\n[[measured]]\nfile = "/etc/hosts"', "measured[1].file"),
    ],
)
def test_every_path_of_a_study(folder, text, key):
    path = folder / "study.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert str(caught.value).startswith(f"{path}: {key} = ")
    assert "--allow-outside" in str(caught.value)
    load_study(path, outside=True)


def test_only_regular_files_are_read(folder):
    os.mkfifo(folder / "pipe")
    for name, expected in (
        ("pipe", "is no regular file, a mesh is needed"),
        ("meshes", "is a folder, a mesh is needed"),
        ("none", "no such file"),
        ("loop", "cannot be read: Too many levels"),
        ("a\0b", "no path"),
    ):
        with pytest.raises(InputError, match=expected):
            contents(folder / name, "a mesh")
    assert contents(folder / "inner.inp", "a mesh", 4) == b"mine"
    with pytest.raises(InputError, match="more than 3 bytes"):
        contents(folder / "inner.inp", "a mesh", 3)


def test_links_are_replaced_not_followed(folder):
    secret = folder.parent / "secret.inp"
    with placed(folder / "link.inp") as temporary:
        temporary.symlink_to(secret)  # as if it had been there before
        temporary.unlink()
        temporary.write_text("new")
    assert not (folder / "link.inp").is_symlink()
    with placed(folder / "other.inp") as temporary:
        temporary.write_text("new")
    temporary.symlink_to(secret)
    with placed(folder / "other.inp") as temporary:
        temporary.write_text("newer")
    assert secret.read_text() == "secret"


KILLED = """
import os, signal, sys
from vanelock.common.files.files import placed
with placed(sys.argv[1]) as temporary:
    temporary.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_writer_left_is_removed_by_the_next_one(tmp_path):
    """But not what a writer has that still runs, here or on another machine, or other files."""
    page = tmp_path / "a[1].html"
    subprocess.run([sys.executable, "-c", KILLED, page], check=False)
    (left,) = tmp_path.iterdir()
    dead = left.name.rpartition("-")[2]
    others = {left.with_name(f".{page.name}.elsewhere-{dead}"), left.with_name(f".b.html.{dead}")}
    others.add(left.with_name(left.name.replace(dead, f"{os.getppid()}.tmp")))
    for other in others:
        other.write_text("half")
    with placed(page) as temporary:
        temporary.write_text("whole")
    assert set(tmp_path.iterdir()) == {page, *others}


def endless() -> str:
    while True:
        pass


def crashing() -> str:
    os.abort()


def failing() -> str:
    raise KeyError("absent")


def huge() -> str:
    return str(len(bytearray(1 << 40)))


@pytest.mark.parametrize(
    ("work", "expected"),
    [(endless, "reading it does not end"), (failing, "it makes the library that reads it fail")],
)
def test_a_child_that_falls_says_why(work, expected, capfd):
    assert limited(work, 1, 200_000_000, "a.bin: ") == f"a.bin: {expected}"
    assert capfd.readouterr() == ("", "")


def printing() -> str:
    print("no such section", file=sys.stderr)
    sys.exit(1)


def saying() -> str:
    raise ValueError("line 3: not a number\nand more")


def refusing() -> str:
    raise InputError("a.bin: element 4 has no nodes")


@pytest.mark.parametrize(
    ("read", "expected"),
    [
        (saying, "a.bin: not a mesh that can be read: line 3: not a number"),
        (printing, "a.bin: not a mesh that can be read: no such section"),
        (crashing, "a.bin: not a mesh that can be read: it makes the library that reads it fail"),
        (huge, "a.bin: not a mesh that can be read: it asks for too much memory"),
        (refusing, "a.bin: element 4 has no nodes"),
    ],
)
def test_a_library_that_fails_is_reported_in_one_line(read, expected, capfd):
    with pytest.raises(InputError) as caught:
        by_library(read, "a.bin", 1000, "a mesh")
    assert str(caught.value) == expected
    assert capfd.readouterr() == ("", "")


def test_what_a_library_reads_is_handed_over_and_its_talk_is_not(capfd):
    def read() -> dict[str, int]:
        print("reading ...")
        return {"nodes": 4}

    assert by_library(read, "a.bin", 1000, "a mesh") == {"nodes": 4}
    assert capfd.readouterr() == ("", "")


def test_numbers_read_back_exactly_and_gaps_are_empty(tmp_path):
    frequency = np.array([249.1, 1 / 3, 1e-300, 5e-324])
    amplitude = np.array([np.nan, 2.0**0.5])
    columns: dict[str, ArrayLike] = {
        "frequency (Hz)": frequency,
        "amplitude (µm)": amplitude,
        "state": ["stuck", 'slips, "opens"'],
        "solved": np.array([True, False]),
    }
    path = write_columns(tmp_path / "new" / "curve.csv", columns, ["Peak: 3 µm", "two\nlines"])
    lines = path.read_text("utf-8").splitlines()
    assert lines[:3] == ["# Peak: 3 µm", "# two", "# lines"]
    header, *rows = csv.reader(lines[3:])
    assert header == list(columns)
    assert [float(row[0]) for row in rows] == frequency.tolist()
    assert [row[1] for row in rows] == ["", str(amplitude[1]), "", ""]
    assert [row[2:] for row in rows] == [["stuck", "1"], ['slips, "opens"', "0"], *[["", ""]] * 2]


WRITES = {"write_text", "write_bytes", "savez", "savetxt", "tofile", "savefig", "mmwrite", "dump"}
BESIDE = ("placed(", "os.replace(")
"""What a function that writes a file has in it: the file is written beside its place."""
ELSEWHERE = {
    "common/files/hdf5.py:written": "the others call it",
    "pipeline/cache.py:__init__": "grows by records with checksums",
    "results/files/run_folder.py:claimed": "an empty file that is locked",
    "render/style.py:_repr_png_": "in memory",
    "fem/matrix_files/ansys_full.py:_child": "a temporary file, for the parent alone",
    "fem/matrix_files/ansys_full.py:main": "a temporary file, for the parent alone",
}


def test_every_file_is_written_beside_its_place():
    root = Path(vanelock.__file__).resolve().parent
    found, unknown = 0, []
    stages = [init.parent for init in root.glob("*/__init__.py")]
    for path in sorted([*root.glob("*.py"), *(p for stage in stages for p in stage.rglob("*.py"))]):
        text = path.read_text("utf-8")
        if not any(each in text for each in (*WRITES, "open(", "File(")):
            continue
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.FunctionDef):
                continue
            calls = [each for each in ast.walk(node) if isinstance(each, ast.Call)]
            if not any(writes(each) for each in calls):
                continue
            own = ast.get_source_segment(text, node) or ""
            found += 1
            place = str(path.relative_to(root))
            known = {place, f"{place}:{node.name}"} & ELSEWHERE.keys()
            if not known and not any(each in own for each in BESIDE):
                unknown.append(f"{place}:{node.name}")
    assert unknown == []
    assert found > 6


def writes(call: ast.Call) -> bool:
    """Whether a call writes a file."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name in WRITES:
        return True
    modes = [each.value for each in call.args if isinstance(each, ast.Constant)]
    modes += [each.value.value for each in call.keywords if isinstance(each.value, ast.Constant)]
    opens = name in ("open", "File")
    return opens and any(m in ("w", "a", "x", "wb", "ab", "xb", "a+b", "r+", "w+b") for m in modes)
