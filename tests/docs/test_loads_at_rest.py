"""The example of gas loads and heat at rest runs, and prints what the manual shows."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.docs.test_first_study import FENCE, QUIET, same
from vanelock.__main__ import app

ROOT = Path(__file__).resolve().parents[2]


def test_the_tables_are_those_of_the_example(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (ROOT / "examples" / "loads_at_rest.toml").read_text()
    (tmp_path / "my.toml").write_text(text.replace("\n[outputs]\nloops = false\n", QUIET))
    monkeypatch.setattr("vanelock.results.figures.pictures.Pictures.draw", lambda *_: [])
    monkeypatch.setenv("COLUMNS", "100")
    done = CliRunner().invoke(app, ["run", str(tmp_path / "my.toml"), "-o", str(tmp_path / "my")])
    assert done.exit_code == 0, done.output
    printed = [line.split() for line in done.stdout.splitlines()]
    page = (ROOT / "docs" / "loads_at_rest.md").read_text()
    tables = [found for kind, found in FENCE.findall(page) if kind == "text"]
    rows = [line.split() for table in tables for line in table.splitlines()]
    rows = [row for row in rows if row[0] in ("hook", "interlock", "key", "loads")]
    assert len(rows) == 6
    assert [row for row in rows if not any(same(row, other) for other in printed)] == []
    (balance,) = (row for row in printed if row[:1] == ["sum"])
    assert all(abs(float(number)) < 1e-7 for number in balance[1:])
