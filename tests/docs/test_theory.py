"""Every Python block of the theory pages runs, page by page, and its assertions hold."""

import re
from pathlib import Path

import pytest

PAGES = sorted((Path(__file__).resolve().parents[2] / "docs" / "theory").glob("*.md"))


def blocks(page: Path) -> list[tuple[int, str]]:
    """Line and text of every Python block."""
    text = page.read_text("utf-8")
    found = re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [(text[: each.start(1)].count("\n"), each[1]) for each in found]


@pytest.mark.system
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_claims(page: Path) -> None:
    names: dict[str, object] = {}
    for line, text in blocks(page):
        # a page's line numbers in a traceback
        exec(compile("\n" * line + text, str(page), "exec"), names)


def test_every_page_but_the_first_is_checked() -> None:
    asserting = {page.stem for page in PAGES if any("assert" in text for _, text in blocks(page))}
    assert asserting == {page.stem for page in PAGES} - {"index"}
