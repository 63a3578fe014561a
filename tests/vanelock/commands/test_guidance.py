"""Every command teaches by `--help`, and the Tab key knows commands, study files and settings."""

import re
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from vanelock import Study, __main__
from vanelock.__main__ import app
from vanelock.commands.converge.settings import settings_of
from vanelock.commands.installed import pages
from vanelock.commands.options import setting_keys, study_files

COMMANDS = sorted(
    each.name or getattr(each.callback, "__name__", "") for each in app.registered_commands
)


def printed(*words: str) -> str:
    done = CliRunner().invoke(app, [*words, "--help"], prog_name="vanelock", terminal_width=200)
    assert done.exit_code == 0
    return done.output


def test_help_is_quick_since_it_loads_neither_arrays_nor_files_nor_the_schema() -> None:
    code = "import sys, vanelock.__main__; print({'numpy', 'h5py', 'pydantic'} & {*sys.modules})"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "set()\n"


@pytest.mark.parametrize("words", [[], *([name] for name in COMMANDS)])
def test_help_fits_a_terminal_of_80_columns(words: list[str]) -> None:
    done = CliRunner().invoke(app, [*words, "--help"], prog_name="vanelock", terminal_width=80)
    assert [line for line in done.output.splitlines() if len(line) > 80] == []


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_has_purpose_example_statuses_and_pages(name: str) -> None:
    text = printed(name)
    missing = "add the command to vanelock/commands/options.py"
    purpose = text.partition("Arguments:")[0].partition("Usage:")[2]
    assert len(purpose.split()) > 8, missing
    assert f"\n    vanelock {name} " in text, missing
    for status in ("0 done", "2 input that cannot be used", "130 stopped"):
        assert status in " ".join(text.split()), missing
    assert ("some cases of a sweep failed" in " ".join(text.split())) == (name == "run")
    named = re.search(r"More: (.*)", text)
    assert named, missing
    assert set(re.findall(r"`vanelock manual ([\w/]+)`", named[1])) <= set(pages())
    assert named[1].count("`vanelock manual ") == named[1].count(", ") + 1


def test_the_help_of_all_shows_the_way_of_a_first_study() -> None:
    text = printed()
    steps = re.findall(r"^    vanelock (\w+) ", text, re.MULTILINE)
    assert steps == ["init", "check", "mesh", "run", "converge", "compare"]
    assert set(steps) <= set(COMMANDS)
    named = re.search(r"`vanelock manual PAGE` prints one: ([^.]*)", " ".join(text.split()))
    assert named
    assert set(named[1].split(", ")) <= set(pages())
    listed = re.findall(r"^  (\w+)  +(\S.*)$", text.partition("Commands:")[2], re.MULTILINE)
    assert [name for name, _ in listed if name in COMMANDS] == [
        each.name or each.callback.__name__ for each in app.registered_commands if each.callback
    ]
    assert [line for _, line in listed if line.endswith("...")] == []


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "tcsh"])
def test_a_completion_script_names_the_program(shell: str) -> None:
    done = CliRunner().invoke(app, ["completion", shell])
    known = shell != "tcsh"
    assert done.exit_code == (0 if known else 2)
    expected = f"_VANELOCK_COMPLETE=complete_{shell}" if known else "'bash', 'zsh', 'fish'"
    assert expected in done.output


def test_study_files_and_every_setting_of_a_study_are_completed(tmp_path):
    (tmp_path / "a.toml").write_text("")
    (tmp_path / "a.csv").write_text("")
    assert study_files(f"{tmp_path}/") == [f"{tmp_path}/a.toml"]
    assert study_files(f"{tmp_path}/b") == []
    assert study_files(f"{tmp_path}/none/") == []
    studies = [
        {},
        {"rom": {"route": "paper", "modes": 5}},
        {"rom": {"modes": 5}},
    ]
    found = {key for each in studies for key in settings_of(Study.model_validate(each))}
    assert found <= set(setting_keys(""))
    assert setting_keys("mesh") == ["mesh.size"]


def test_too_little_memory_is_one_line_and_status_2(monkeypatch, capsys):
    def greedy(*arguments: object, **options: object) -> None:
        raise MemoryError("Unable to allocate 50 GiB")

    monkeypatch.setattr(__main__, "app", greedy)
    with pytest.raises(SystemExit) as ended:
        __main__.main(["run", "study.toml"])
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("vanelock: not enough memory (Unable to allocate 50 GiB): ")
