"""The example of unlike segments runs, and prints what the manual shows."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.docs.test_first_study import FENCE, same
from vanelock.__main__ import app

ROOT = Path(__file__).resolve().parents[2]


def test_the_table_is_that_of_the_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    study, folder = ROOT / "examples" / "unlike_segments.toml", tmp_path / "run"
    done = CliRunner().invoke(app, ["run", str(study), "-o", str(folder), "--workers", "1"])
    assert done.exit_code == 0, done.output
    printed = [line.split() for line in done.stdout.splitlines()]
    page = (ROOT / "docs" / "unlike_segments.md").read_text()
    (table,) = (found for kind, found in FENCE.findall(page) if kind == "text")
    row = table.splitlines()[-1].split()
    assert len(row) == 10
    assert any(same(row, other) for other in printed)
    assert (folder / "figures" / "unlike_nominal.png").exists()
    assert "Unlike segments" in (folder / "report.html").read_text()
