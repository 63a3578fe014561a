"""The pages that `make verify` wrote are there, complete, and say that everything passed."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted((ROOT / "tests" / "verification").rglob("test_*.py"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_page_of_each_verification(file: Path) -> None:
    page = ROOT / "docs" / "verification" / f"{file.stem.removeprefix('test_')}.md"
    rows = re.findall(r"^\| `(\w+)\S*` \|.*\| (\w+) \|$", page.read_text(), re.MULTILINE)
    assert {outcome for _, outcome in rows} == {"passed"}
    assert {name for name, _ in rows} == set(re.findall(r"^def (test_\w+)", file.read_text(), re.M))
