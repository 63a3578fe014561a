"""Words: what users read is in the terms of the field."""

import re
import runpy
from pathlib import Path
from typing import Any

import pytest

from vanelock.results.case_table import CASE_COLUMNS

ROOT = Path(__file__).resolve().parents[2]
WORDS: dict[str, Any] = runpy.run_path(str(ROOT / "tools" / "words.py"))
GLOSSARY = (ROOT / "docs" / "glossary.md").read_text("utf-8")


def test_what_users_read_is_searched() -> None:
    """By `make lint`, which looks for house words in all of it."""
    read = {path.relative_to(ROOT).as_posix() for path in WORDS["files"]()}
    assert {"README.md", "docs/glossary.md", "vanelock/results/listing.py", "mesh/part.py"} <= read
    assert {"examples/notebooks/two_masses.ipynb", "tests/conftest.py", "CHANGELOG.md"} <= read


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("errors are told\nby source, and it tells why", ["told", "tells"]),
        ("told apart, tell them apart, tells a lead\nfrom lag apart", []),
        ("contacts that rub; of linear stuck", ["rub", "of linear stuck"]),
        ("linear elasticity, a rubber disc, retold", []),
        ("n, other rule; may grow; HCF reserve", ["HCF reserve", "may grow", "other rule"]),
    ],
)
def test_house_words_are_found(text: str, found: list[str]) -> None:
    assert sorted(word for _, word, _ in WORDS["house_words"](text)) == sorted(found)


def test_what_is_found_is_printed_and_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.md").write_text("a\nb told\n")
    main = WORDS["main"]
    monkeypatch.setitem(main.__globals__, "ROOT", tmp_path)
    monkeypatch.setitem(main.__globals__, "files", lambda: [tmp_path / "a.md"])
    assert main() == 1
    assert capsys.readouterr().out == "a.md:2: told: given, estimated, reported\n"


def test_house_words_are_found_in_names_and_notebooks(tmp_path: Path) -> None:
    source, notebook = tmp_path / "a.py", tmp_path / "a.ipynb"
    source.write_text(
        "def is_told(x):\n    rival = f'{x} told_apart'\n    return told_apart(Told)\n"
    )
    found = list(WORDS["house_names"](source))
    assert found == [(1, "is_told"), (2, "rival"), (3, "Told")]
    notebook.write_text('{"cells": [{"source": ["one\\n", "contacts that rub"]}, {"source": []}]}')
    texts = [text for _, text in WORDS["texts"](notebook)]
    assert texts == ["one\ncontacts that rub", ""]


def test_the_glossary_has_the_words_of_the_tables() -> None:
    """Every head of the responses' table is a term, or says what it is by itself."""
    heads = [column.head for column in CASE_COLUMNS]
    assert len(heads) > 15
    plain = {"case", "H", "μ", "slip", "open", "converged", "time"}
    terms = " ".join(re.findall(r"^\| (.*?) \|", GLOSSARY, re.MULTILINE)).lower()
    words = {word for head in set(heads) - plain for word in head.lower().split()}
    assert {word for word in words if word.rstrip("s") not in terms} <= {
        "lower", "upper", "bound", "vibratory", "stress", "hcf", "to", "per", "dissipated",
    }  # fmt: skip
