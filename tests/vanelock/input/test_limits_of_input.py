"""Input of any size ends in one line, soon and in little memory; nothing is written elsewhere."""

import os
from pathlib import Path

import pytest

from vanelock import load_study, parse_study
from vanelock.common.errors import InputError
from vanelock.common.toml import LARGEST, toml_tables
from vanelock.results.files.run_folder import claimed


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("#" * (LARGEST + 1), "more than 2,000,000 bytes"),
        (".".join("a" * 1000) + " = 1", "line 1: nested too deeply"),
        ("a = " + "[" * 1000, "nested too deeply"),
        ("a = " + "{b = " * 300 + "1" + "}" * 300, "nested too deeply"),
        ("name = " + "1" * 10_000, "not valid TOML"),
        ("[a]\nb = [1, 0x" + "f" * 10_000 + "]", "a.b[1]: not valid TOML: an integer of more"),
    ],
    ids=["size", "a long key", "brackets", "tables", "digits", "hexadecimal digits"],
)
def test_where_the_limits_lie(tmp_path, text, expected):
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        load_study(path)
    assert expected in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_the_limits_leave_room_mistakes_are_counted_and_a_pipe_is_not_waited_for(tmp_path):
    text = "\n".join(f"# {'comment ' * 20}" for _ in range(10_000))
    assert len(text) < LARGEST
    assert toml_tables(text, "study") == {}
    assert toml_tables("a.b.c.d.e.f = 1", "study")["a"]["b"]["c"]["d"]["e"]["f"] == 1
    assert toml_tables('n = "1.2.3.4.5.6.7.8.9.10.11.12.13"', "study")
    with pytest.raises(InputError) as error:
        parse_study("".join(f"k{i} = 1\n" for i in range(1000)))
    lines = str(error.value).splitlines()
    assert len(lines) == 21
    assert lines[-1] == "study: and 980 more mistakes"
    os.mkfifo(tmp_path / "study.toml")
    with pytest.raises(InputError, match="is no regular file"):
        load_study(tmp_path / "study.toml")


@pytest.mark.parametrize("name", ["cache", "figures", "shapes", "mesh"])
def test_links_in_the_folder_are_not_followed(tmp_path, name):
    folder, other = tmp_path / "run", tmp_path / "other"
    folder.mkdir()
    other.mkdir()
    (folder / name).symlink_to(other)
    with pytest.raises(InputError, match=f"{name}: is a link, which is not followed"):
        enter(folder)
    (folder / name).unlink()
    (folder / ".lock").unlink()
    (folder / ".lock").symlink_to(other / "made")
    with pytest.raises(InputError, match="cannot be used as a folder"):
        enter(folder)
    assert list(other.iterdir()) == []


def enter(folder: Path) -> None:
    """As a run does."""
    with claimed(folder):
        pass


def test_a_folder_is_used_that_is_new_empty_or_of_a_run(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / ".gitkeep").touch()
    for name in ("new", "empty"):
        with claimed(tmp_path / name):
            (tmp_path / name / "report.html").write_text("page")
        with claimed(tmp_path / name):
            pass


@pytest.mark.parametrize(
    "text",
    ["9^9^9^9 m", "9⁹⁹⁹⁹⁹⁹⁹⁹⁹ m", "9 cubed cubed cubed m", "9**9**9 m", "(9)^(9)^9 m", "9e9^9"],
)
def test_arithmetic_is_not_evaluated(text):
    with pytest.raises(InputError, match="expected a number"):
        parse_study(f'[joints.hook]\ninterference = "{text}"')
