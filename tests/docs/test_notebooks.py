"""Every notebook runs from its first cell to its last, and is kept without what it prints."""

import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NOTEBOOKS = sorted((EXAMPLES / "notebooks").glob("*.ipynb"))


@pytest.mark.system
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, tmp_path: Path) -> None:
    """In a copy of the examples' folder, by a kernel of its own; a cell that fails is an error."""
    for folder in ("notebooks", "lap_joint"):
        shutil.copytree(EXAMPLES / folder, tmp_path / folder, ignore=shutil.ignore_patterns("runs"))
    book = nbformat.read(path, as_version=4)
    client = NotebookClient(
        book, timeout=600, resources={"metadata": {"path": str(tmp_path / "notebooks")}}
    )
    client.execute()
    cells = [cell for cell in book.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    shown = [output for cell in cells for output in cell.outputs]
    assert [each for each in shown if each.output_type == "error"] == []
    assert len([each for each in shown if "image/png" in each.get("data", {})]) >= 2


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(path: Path) -> None:
    book = nbformat.read(path, as_version=4)
    nbformat.validate(book)
    assert book.cells[0].source.startswith("# ")
    for cell in book.cells:
        if cell.cell_type == "code":
            assert (cell.outputs, cell.execution_count) == ([], None)


def test_two_masses_of_the_manual_are_solved(capsys: pytest.CaptureFixture[str]) -> None:
    text = (EXAMPLES.parent / "docs/python.md").read_text("utf-8")
    block = next(each for each in text.split("```python\n") if "System.from_matrices(" in each)
    exec(block.partition("```")[0], {})
    peak, converged = capsys.readouterr().out.split()
    assert 1e-4 < float(peak) < 1e-3
    assert converged == "True"


def test_the_manual_links_every_notebook() -> None:
    for page in ("docs/python.md", "README.md"):
        text = (EXAMPLES.parent / page).read_text("utf-8")
        assert [path.name for path in NOTEBOOKS if f"notebooks/{path.name}" not in text] == []
    assert {path.stem for path in NOTEBOOKS} == {"two_masses", "default_study", "own_matrices"}
