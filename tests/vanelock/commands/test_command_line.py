"""The command line: exit status and messages; in this process, but for what needs another."""

import subprocess
import sys

import pytest

import vanelock
from vanelock import parse_study, template_text

VANELOCK = [sys.executable, "-m", "vanelock"]


def test_a_process_ends_with_the_status(tmp_path):
    for argument, expected in (
        ("--version", (0, f"vanelock {vanelock.__version__}\n", "")),
        ("--fast", (2, "", "vanelock: No such option: --fast\n")),
    ):
        done = subprocess.run(
            [*VANELOCK, argument], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stdout, done.stderr) == expected


def test_init_writes_a_study_that_can_be_read_once(tmp_path, called, refused):
    assert called("init", "mine.toml")[0] == 0
    text = (tmp_path / "mine.toml").read_text("utf-8")
    assert text == template_text()
    assert parse_study(text).name == "vane segment"
    assert called("init", "every.toml", "--all")[0] == 0
    assert (tmp_path / "every.toml").read_text("utf-8") == template_text(all_keys=True)
    line = refused("init", "mine.toml")
    assert line == "vanelock: mine.toml: exists already; name another file"


def test_usage_errors_are_one_line_and_help_is_plain_where_nothing_is_asked(called, refused):
    assert refused("run", "--fast", "a.toml").startswith("vanelock: No such option: --fast")
    assert "Missing argument" in refused("run")
    assert "No such command" in refused("walk")
    status, out, said = called()
    assert (status, said) == (0, "")
    assert out == called("--help")[1]
    assert out.startswith("Usage: vanelock ")


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("", "must not be empty"),
        ("x" * 5000, f"{'x' * 40}...: no path of a file: File name too long"),
    ],
)
def test_what_cannot_be_a_path_is_refused(tmp_path, refused, path, reason):
    (tmp_path / "a.toml").write_text("")
    refusal = f"vanelock: Invalid value for {{}}: {reason}"
    for command in ("run", "mesh", "converge", "fit", "optimise"):
        assert refused(command, "a.toml", "-o", path) == refusal.format("'--output' / '-o'")
        assert refused(command, path) == refusal.format("'STUDY'")
    assert refused("compare", path, "b") == refusal.format("'A'")
    assert refused("init", path) == refusal.format("'PATH'")
    assert [path.name for path in tmp_path.iterdir()] == ["a.toml"]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (None, "a.toml: no such file"),
        (b"\xff\xfe\x00", "a.toml: not a text file in UTF-8"),
        (b"[joints", "a.toml: line 1: not valid TOML: "),
        (b"colour = 1", "a.toml: colour = 1: unknown key"),
    ],
)
def test_bad_studies(tmp_path, refused, text, line):
    if text is not None:
        (tmp_path / "a.toml").write_bytes(text)
    assert refused("run", "a.toml").startswith(f"vanelock: {line}")
    assert not (tmp_path / "runs").exists()


def test_what_cannot_be_searched(tmp_path, refused):
    """The file is named, and no folder is left behind."""
    key = "joints.interlock.mu"
    (tmp_path / "a.toml").write_text(f"[optimise]\nparameters = {{ {key} = [0.5, 0.9] }}")
    line = f'optimise: "{key}" starts at 0.3, outside of its bounds 0.5 to 0.9'
    assert refused("optimise", "a.toml").startswith(f"vanelock: a.toml: {line}")
    (tmp_path / "a.toml").write_text("")
    for command in ("optimise", "fit"):
        said = f"vanelock: a.toml: {command}: the study has no [{command}] table"
        assert refused(command, "a.toml").startswith(said)
    assert not (tmp_path / "runs").exists()


NO_FOLDER = "is not a folder; move it away or name another"


@pytest.mark.parametrize(
    ("place", "content", "line"),
    [
        ("out", b"a file", "out: cannot be used as a folder to write to"),
        ("out/results.h5", b"\x89HDF\r\n\x1a\n nothing", "out/results.h5: not a readable HDF5"),
        ("out/results.h5/a", b"", "out/results.h5: is a folder, not a results file; move it away"),
        *((f"out/{name}", b"mine", f"out/{name}: {NO_FOLDER}") for name in ("figures", "shapes")),
        ("out/cache", b"mine", f"out/cache: {NO_FOLDER}"),
    ],
)
def test_folders_that_hold_something_else_are_left_as_they_are(
    tmp_path, refused, place, content, line
):
    (tmp_path / "a.toml").write_text("")
    there = tmp_path / place
    there.parent.mkdir(parents=True, exist_ok=True)
    there.write_bytes(content)
    assert refused("run", "a.toml", "-o", "out").startswith(f"vanelock: {line}")
    if place == "out":
        assert refused("run", "a.toml", "-o", "out/below").startswith("vanelock: out/below: cannot")
    assert there.read_bytes() == content
    assert not (tmp_path / "out" / "cache").is_dir()


def test_a_refused_run_leaves_no_folder(tmp_path, refused):
    (tmp_path / "a.toml").write_text('[[measured]]\nfile = "none.csv"\n')
    refused("run", "a.toml", "-o", "out")
    assert not (tmp_path / "out").exists()
    (tmp_path / "out").mkdir()  # one that was there stays
    refused("run", "a.toml", "-o", "out")
    assert (tmp_path / "out").exists()
