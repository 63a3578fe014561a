"""The command line: exit status and messages, and what a check says."""

import re
import subprocess
import sys

import pytest

import vanelock
from tests.vanelock.scenes.test_run import PAD, arm
from vanelock import check_file, parse_study, template_text
from vanelock.common.errors import InputError
from vanelock.results.files.writer import Results

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


def test_a_sweep_of_which_a_case_failed_ends_with_status_1(tmp_path, called):
    sweep = '[response]\npoints = 5\n[outputs]\nshow = []\n[sweep]\n"response.mode" = [1, 9]\n'
    (tmp_path / "a.toml").write_text(f"{arm(tmp_path)}modes = 0\n{PAD}{sweep}")
    status, _, said = called("run", "a.toml")
    assert status == 1, said
    assert "FAILED mode=9: " in said


def test_a_refused_run_leaves_no_folder(tmp_path, refused):
    (tmp_path / "a.toml").write_text('[[measured]]\nfile = "none.csv"\n')
    refused("run", "a.toml", "-o", "out")
    assert not (tmp_path / "out").exists()
    (tmp_path / "out").mkdir()  # one that was there stays
    refused("run", "a.toml", "-o", "out")
    assert (tmp_path / "out").exists()


def rows(path):
    return dict(check_file(path).rows)


@pytest.mark.parametrize(
    ("text", "elements"),
    [
        ("", "medium"),
        ('mesh.size = "5 mm"', "5 mm"),
        ('[sweep]\n"mesh.size" = ["coarse", 0.004]', "coarse, 4 mm"),
        ("accuracy = 0.02\nresponse.harmonics = 3", "chosen for an error of 2 %"),
        ('accuracy = 0.02\nmesh.size = "coarse"', "coarse"),
    ],
)
def test_elements_are_those_that_a_run_has(tmp_path, text, elements):
    (tmp_path / "my.toml").write_text(text)
    found = rows(tmp_path / "my.toml")
    assert found["vane"] == found["casing"] == f"from dimensions, elements {elements}"
    assert ("accuracy" in found) == ("accuracy" in text)
    if elements == "coarse":
        for what, unit in (("unknowns", "degrees of freedom"), ("disk", "GB on disk")):
            assert re.fullmatch(f"about .* {unit}", found[what])
    if "harmonics" in text:
        chosen = "an error of 2 %: the run chooses mesh, modes, frequencies"
        assert found["accuracy"] == chosen


def test_every_wrong_file_of_measurements_gets_its_line(tmp_path):
    with pytest.raises(InputError, match="File name too long|no such file"):
        rows(tmp_path / ("x" * 300))
    (tmp_path / "bad.csv").write_text("frequency (Hz), amplitude (kg)\n1, 2\n")
    tables = "".join(f'[[measured]]\nfile = "{name}.csv"\n' for name in ("absent", "bad"))
    (tmp_path / "my.toml").write_text(tables)
    with pytest.raises(InputError) as caught:
        rows(tmp_path / "my.toml")
    lines = [line.partition(": ")[2] for line in str(caught.value).splitlines()]
    assert [line.partition(" ")[0] for line in lines] == ["measured[0].file:", "measured[1].file:"]
    assert lines[0].endswith("absent.csv: no such file")
    assert "column amplitude" in lines[1]


@pytest.mark.parametrize(
    ("failed", "expected"),
    [(0, "0"), (2, "2: mu=0, mu=1"), (7, "7: mu=0, mu=1, mu=2, mu=3, mu=4, ...")],
)
def test_failed_cases_are_counted(tmp_path, failed, expected):
    results = Results(tmp_path / "results.h5")
    with results.edit() as file:
        about = file.create_group("provenance")
        about.create_group("versions")
        about.attrs.update({"date": "2026-01-01", "settings": "{}", "study": "", "given": "{}"})
        for i in range(failed):
            file.create_group(f"failed/mu={i}").attrs.update({"reason": "it", "attempts": 2})
    results.flush()
    assert rows(tmp_path)["failed"] == expected
