"""The first study of the manual runs as written, and prints what the page shows."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from vanelock.__main__ import app

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "start" / "first_study.md").read_text()
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
QUIET = "\n[outputs]\nshapes = false\nloops = false\nreport = false\n"


def shown() -> list[str]:
    """Lines of the tables on the page."""
    tables = [text for kind, text in FENCE.findall(PAGE) if kind == "text"]
    return [line for text in tables for line in text.splitlines() if not set(line) <= {"─", " "}]


def study() -> str:
    return str(next(text for kind, text in FENCE.findall(PAGE) if kind == "toml"))


def test_the_tables_are_those_of_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    changed = study().replace("[0.15, 0.3]", "[0.15, 0.3, 0.5]")
    assert changed != study()
    (tmp_path / "my.toml").write_text(changed + QUIET)
    monkeypatch.setattr("vanelock.results.figures.pictures.Pictures.draw", lambda *_: [])
    monkeypatch.setenv("COLUMNS", "100")
    command = ["run", str(tmp_path / "my.toml"), "--output", str(tmp_path / "my"), "--workers", "1"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    printed = [line.split() for line in done.stdout.splitlines()]
    lines = shown()
    assert len(lines) > 15
    assert [line for line in lines if not any(same(line.split(), row) for row in printed)] == []


def same(line: list[str], row: list[str]) -> bool:
    """Whether a line of the page is that of the run: words alike, numbers alike.

    To a thousandth of themselves, or of one where they are smaller, or their last digit. By the
    processor's rounding the mesher makes slightly different meshes: between two kinds of processors
    frequencies differed by 4e-5, peaks by 3e-4, and the number of points where all converged.
    """
    return len(line) == len(row) and all(map(alike, line, row))


def alike(one: str, other: str) -> bool:
    if one == other:
        return True
    if all(re.fullmatch(r"(\d+)/\1", word) for word in (one, other)):
        return True
    try:
        a, b = float(one), float(other)
    except ValueError:
        return False
    if "e-" in one:  # an estimated error, of which the order counts
        return bool(0.3 < a / b < 3)
    place = len(one.partition(".")[2])
    return abs(a - b) <= (max(2.5 * 10.0**-place, 1e-3 * max(abs(a), 1.0)) if place else 0.0)


def test_what_is_not_the_same_is_told_apart() -> None:
    assert same(["mu=0.15", "55.3", "55/55"], ["mu=0.15", "55.4", "54/54"])
    assert not same(["mu=0.15", "55.3", "55/55"], ["mu=0.15", "55.3", "55/55", "3.5"])
    assert not same(["mu=0.15", "55.3", "55/55"], ["mu=0.15", "56.3", "54/54"])
    assert not same(["mu=0.15", "55.3", "55/55"], ["mu=0.15", "55.3", "53/54"])
    assert not same(["mu=0.3", "55.3"], ["mu=0.15", "55.3"])
    assert same(["stuck", "477.963"], ["stuck", "477.982"])
    assert not same(["stuck", "477.963"], ["stuck", "478.982"])
