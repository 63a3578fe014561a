"""The example studies: each is valid, and the published model's scale is met."""

import csv
from pathlib import Path

import pytest

from vanelock import load_study, mesh_study

FOLDER = Path(__file__).resolve().parents[3] / "examples"
PAPER = FOLDER / "paper" / "study.toml"


@pytest.mark.system
def test_the_paper_s_scale(tmp_path, monkeypatch):
    """Counts of the published model: 326 nodes a face, 56 + 10 contact pairs, 16 forces."""
    monkeypatch.setattr("vanelock.render.mesh_picture", lambda path, *_: path)
    found = mesh_study(load_study(PAPER), tmp_path)
    with (tmp_path / "mesh" / "sets.csv").open() as file:
        rows = {row["set"]: (row["vane"], row["casing"]) for row in csv.DictReader(file)}
    fixed = rows.pop("fixed")
    assert rows == {
        "left": ("", "326"),
        "right": ("", "326"),
        "hook_front": ("30", "30"),
        "hook_rear": ("30", "30"),
        "key": ("4", "4"),
        "interlock_left": ("10", ""),
        "interlock_right": ("10", ""),
        "force": ("", "16"),
        "output": ("3", "3"),
    }
    assert int(fixed[1]) > 100
    assert 100_000 < found["vane"].dofs < 200_000
    assert found["casing"].dofs == pytest.approx(43_000, rel=0.05)
    for figures in found.values():
        assert figures.smallest_jacobian > 0
        assert figures.sicn[0] > 0.05
