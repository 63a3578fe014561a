"""Studies, notebooks and theory pages of the manual run as written."""

import re
import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient
from typer.testing import CliRunner

from vanelock.__main__ import app

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
QUIET = "\n[outputs]\nshow = []\n"


def fenced(page: str, kind: str) -> str:
    text = (ROOT / "docs" / page).read_text("utf-8")
    return "".join(block for found, block in FENCE.findall(text) if found == kind)


def first_study() -> str:
    study = fenced("start/first_study.md", "toml").partition("accuracy =")[0]
    assert "[0.15, 0.3]" in study
    return study.replace("[0.15, 0.3]", "[0.15, 0.3, 0.5]")


def example(name: str) -> str:
    return (ROOT / "examples" / name).read_text("utf-8")


@pytest.mark.system
@pytest.mark.parametrize(
    ("page", "study", "kept", "count"),
    [
        ("start/first_study.md", first_study(), r".*[^ ─]", 31),
        ("mistuning.md", example("mistuning.toml"), r" +\d", 1),
        ("loads_at_rest.md", example("loads_at_rest.toml"), " (hook|interlock|key|loads) ", 6),
    ],
    ids=["first study", "mistuning", "loads at rest"],
)
def test_the_tables_are_those_of_a_run(page, study, kept, count, tmp_path, monkeypatch):
    outputs = re.compile(r"^\[outputs\]\n(?:\w.*\n)*", re.MULTILINE)
    (tmp_path / "my.toml").write_text(outputs.sub("", study) + QUIET)
    monkeypatch.setattr("vanelock.commands.run.study.show", lambda *_: None)
    monkeypatch.setenv("COLUMNS", "100")
    command = ["run", str(tmp_path / "my.toml"), "--output", str(tmp_path / "my"), "--workers", "1"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    printed = [line.split() for line in done.stdout.splitlines()]
    rows = [line for line in fenced(page, "text").splitlines() if re.match(kept, line)]
    assert len(rows) == count
    assert [row for row in rows if not any(same(row.split(), other) for other in printed)] == []
    for balance in (row for row in printed if row[:1] == ["sum"]):  # of reactions at rest
        assert all(abs(float(number)) < 1e-7 for number in balance[1:])


def same(line: list[str], row: list[str]) -> bool:
    """Whether a line of the page is that of the run: words alike, numbers alike.

    To a thousandth of themselves, or of one where they are smaller, or their last digit. By the
    processor's rounding the mesher makes slightly different meshes: between two kinds of processors
    frequencies differed by 4e-5, peaks by 3e-4, and the number of points where all converged.
    """
    return len(line) == len(row) and all(map(alike, line, row))


def alike(one: str, other: str) -> bool:
    if one == other or all(re.fullmatch(r"(\d+)/\1", word) for word in (one, other)):
        return True
    try:
        a, b = float(one), float(other)
    except ValueError:
        return False
    if "e-" in one:  # an estimated error, of which the order counts
        return bool(0.3 < a / b < 3)
    place = len(one.partition(".")[2])
    return abs(a - b) <= (max(2.5 * 10.0**-place, 1e-3 * max(abs(a), 1.0)) if place else 0.0)


EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NOTEBOOKS = sorted((EXAMPLES / "notebooks").glob("*.ipynb"))


@pytest.mark.system
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path):
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
def test_a_notebook_is_kept_without_outputs(path):
    book = nbformat.read(path, as_version=4)
    nbformat.validate(book)
    assert book.cells[0].source.startswith("# ")
    for cell in book.cells:
        if cell.cell_type == "code":
            assert (cell.outputs, cell.execution_count) == ([], None)


def test_two_masses_of_the_manual_are_solved(capsys):
    text = (EXAMPLES.parent / "docs/python.md").read_text("utf-8")
    block = next(each for each in text.split("```python\n") if "System.from_matrices(" in each)
    exec(block.partition("```")[0], {})
    peak, converged = capsys.readouterr().out.split()
    assert 1e-4 < float(peak) < 1e-3
    assert converged == "True"


def test_the_manual_links_every_notebook():
    for page in ("docs/python.md", "README.md"):
        text = (EXAMPLES.parent / page).read_text("utf-8")
        assert [path.name for path in NOTEBOOKS if f"notebooks/{path.name}" not in text] == []
    assert {path.stem for path in NOTEBOOKS} == {"two_masses", "default_study", "own_matrices"}


PAGES = sorted((Path(__file__).resolve().parents[2] / "docs" / "theory").glob("*.md"))


def blocks(page: Path) -> list[tuple[int, str]]:
    text = page.read_text("utf-8")
    found = re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [(text[: each.start(1)].count("\n"), each[1]) for each in found]


@pytest.mark.system
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_claims(page):
    names: dict[str, object] = {}
    for line, text in blocks(page):
        # a page's line numbers in a traceback
        exec(compile("\n" * line + text, str(page), "exec"), names)


def test_every_page_but_the_first_is_checked():
    asserting = {page.stem for page in PAGES if any("assert" in text for _, text in blocks(page))}
    assert asserting == {page.stem for page in PAGES} - {"index"}
