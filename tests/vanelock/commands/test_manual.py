"""Pages of the manual as the command prints them; whoever names one names one that there is."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from vanelock.__main__ import app, main
from vanelock.commands.manual import contents_list, page_text, pages

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


def test_a_terminal_shows_tables_and_formulas() -> None:
    code = (
        "import sys\n"
        "from rich.console import Console\n"
        "sys.stdout.isatty = lambda: True\n"
        "from vanelock.commands.manual import show\n"
        "show('theory/contact')\n"
        "show('keys')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={"COLUMNS": "80", "PATH": "/usr/bin:/bin", "TERM": "dumb"},
        capture_output=True,
        text=True,
        check=True,
    )
    shown = [line.strip() for line in done.stdout.splitlines()]
    assert r"\pm \mu n & \text{slipping, where } |t| \text{ would exceed } \mu n \\" in shown
    assert "$$" not in done.stdout
    assert any(re.fullmatch(r"─{40,}", line) for line in shown)
    assert max(map(len, done.stdout.splitlines())) <= 80


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


def test_no_words_for_users_name_a_file_of_the_source() -> None:
    """Strings and comments of study files; docstrings and comments of code are for developers."""
    files = [*(ROOT / "vanelock" / "input" / "templates").glob("*.toml")]
    files += (ROOT / "examples").rglob("*.toml")
    found = [str(path) for path in files if "docs/" in path.read_text("utf-8")]
    code = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for top in ("mesh", "fem", "rom", "nonlinear", "vanelock")
        for path in (ROOT / top).rglob("*.py")
        for line in path.read_text("utf-8").splitlines()
        if re.match(r'\s*(?:f?"|.*\(f?"|.*= f?").*docs/', line)
        and not line.strip().startswith('"""')
    ]
    assert (found, code) == ([], [])
