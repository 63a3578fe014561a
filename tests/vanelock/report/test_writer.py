"""What is written, without a browser: nothing half, nothing from outside, errors that say where."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vanelock import report
from vanelock.common.errors import InputError
from vanelock.common.tables import Table, heads


def page_of(*blocks):
    return report.Page("Study", "today", (report.Section("All", blocks),))


def refused(tmp_path, block, match):
    with pytest.raises(InputError, match=match):
        report.write_page(tmp_path / "report.html", page_of(block))
    assert not list(tmp_path.glob("*.html*"))


def test_nothing_is_loaded_from_elsewhere_and_a_page_without_curves_is_small(sample, tmp_path):
    text = sample.path.read_text("utf-8")
    own = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', own) == []
    assert "url(" not in own
    assert "@import" not in own
    assert "default-src 'none'" in own
    assert "<script>alert(1)</script>" not in text
    assert text.count("</script>") == text.count("<script")
    path = report.write_page(tmp_path / "new" / "report.html", page_of(report.Text("Hello.")))
    text = path.read_text("utf-8")
    assert "<p>Hello.</p>" in text
    assert len(text) < 40_000
    assert [file.name for file in path.parent.iterdir()] == ["report.html"]


@pytest.mark.system
def test_example_of_the_documentation_writes_its_page(tmp_path, monkeypatch):
    text = (Path(__file__).parents[3] / "docs" / "report_page.md").read_text("utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "response.csv").write_text("frequency,amplitude\n1,2\n2,5\n3,1\n")
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    written = (tmp_path / "page.html").read_text("utf-8")
    assert all(kind in written for kind in ('class="plot"', 'class="view"', 'class="answers"'))


X = np.arange(3.0)
UNEQUAL = report.Trace(X, np.arange(4.0), "μ = 0.3")
FLAGGED = Table("Contacts", heads("a"), [[1]], flags=["good", "bad"])


@pytest.mark.parametrize(
    ("block", "match"),
    [
        (report.Plot((UNEQUAL,), "x", "y", "Response"), r"Response: μ = 0\.3: x \(3,\)"),
        (Table("Contacts", heads("a", "b"), [[1]]), "Contacts: a row of 1 cells: 2"),
        (FLAGGED, "Contacts: 2 flags: 1"),
        (report.Picture(Path(__file__), "S", ""), "test_writer.py: is neither a PNG nor a GIF"),
        (report.Picture(Path("none.png"), "S", ""), "none.png: cannot be read"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, block, match):
    refused(tmp_path, block, match)


def test_shapes_must_fit_their_bodies(tmp_path, sample):
    motion = sample.motions[0]
    view = report.View(sample.bodies, (motion,), "Motion")
    short = replace(motion, shapes=(motion.shapes[0][:-1], motion.shapes[1]))
    refused(tmp_path, replace(view, motions=(short,)), "Response: shapes of")
    still = replace(motion, shapes=tuple(np.zeros_like(s) for s in motion.shapes))
    refused(tmp_path, replace(view, motions=(still,)), "Response: zero everywhere")
    broken = replace(motion, shapes=tuple(s * np.nan for s in motion.shapes))
    refused(tmp_path, replace(view, motions=(broken,)), "Response: shape holds values")
    rings = (sample.bodies[0], replace(sample.bodies[1], sectors=4))
    refused(tmp_path, replace(view, bodies=rings), r"sectors: given \[9, 4\]: must be equal")
    refused(tmp_path, replace(view, motions=()), "needs a body and a motion")


def test_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="report.html: cannot be written"):
        report.write_page(tmp_path / "file" / "report.html", page_of(report.Text("")))
