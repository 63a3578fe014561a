"""Paths that a study names stay in its folder; files of the user are read whole or not at all."""

import os
import subprocess
import sys

import pytest

from vanelock import load_study
from vanelock.common.errors import InputError
from vanelock.common.files.files import beside, contents, placed


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
