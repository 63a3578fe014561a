"""Pages of the manual as the command prints them; whoever names one names one that there is."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from vanelock.__main__ import app, main
from vanelock.commands.installed import contents_list, page_text, pages

ROOT = Path(__file__).resolve().parents[3]
NOT_INSTALLED = {"index", "project/changelog", "project/contributing", "project/licence"}


def printed(*words: str) -> str:
    done = CliRunner().invoke(app, ["manual", *words])
    assert done.exit_code == 0
    return done.output


def test_all_pages_are_listed_and_plain_markdown_where_no_terminal_shows_them():
    docs = ROOT / "docs"
    names = {str(page.relative_to(docs).with_suffix("")) for page in docs.rglob("*.md")}
    names = {name for name in names if not name.startswith("reference/")}  # made by `make docs`
    assert set(pages()) == names - NOT_INSTALLED
    lines = printed().splitlines()
    assert printed() == f"{contents_list()}\n"
    assert [line.split()[0] for line in lines if line.startswith("  ")] == [*pages()]
    assert re.search(r"^  theory/contact +Contact law$", printed(), re.MULTILINE)
    text = printed("start/install")
    assert text.startswith("# Install\n\nLinux with Python")
    assert "$ make study\n" in text
    assert "\x1b" not in text


@pytest.mark.parametrize("name", pages())
def test_a_page_points_at_no_file_that_is_not_installed(name: str) -> None:
    text = page_text(name)
    assert text.startswith("# ")
    assert not re.search(r"\]\([^)\s]*\.(md|png)", text)
    assert "```{" not in text


def test_a_page_that_there_is_not_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["manual", "sweep"])
    said = capsys.readouterr()
    assert (ended.value.code, said.out) == (2, "")
    (line,) = said.err.splitlines()
    assert line.startswith(
        'vanelock: manual: "sweep" is no page; expected one of start/first_study, '
    )
    assert ", sweeps, trust, theory/..., " in line


def test_pages_that_the_program_and_examples_name_are_there() -> None:
    sources = [
        path
        for top in ("mesh", "fem", "rom", "nonlinear", "vanelock", "examples")
        for ending in ("py", "toml", "html", "js", "ipynb")
        for path in (ROOT / top).rglob(f"*.{ending}")
    ]
    text = "\n".join(path.read_text("utf-8") for path in sources)
    named = set(re.findall(r"`vanelock manual ([a-z_/]+)`", text))
    assert len(named) > 8
    assert named <= set(pages())
