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
