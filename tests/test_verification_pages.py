"""Pages of evidence: what `make verify` wrote is complete and passed; each names its commit."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import pages

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted((ROOT / "tests" / "verification").rglob("test_*.py"))
QUICK = ("cost", "peak_gradient", "stability", "time_integration", "mistuned_rings")
EVIDENCE = runpy.run_path(str(ROOT / "tools" / "evidence.py"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_page_of_each_verification(file):
    page = ROOT / "docs" / "verification" / f"{file.stem.removeprefix('test_')}.md"
    rows = re.findall(r"^\| `(\w+)\S*` \|.*\| (\w+) \|$", page.read_text(), re.MULTILINE)
    assert {outcome for _, outcome in rows} == {"passed"}
    assert {name for name, _ in rows} == set(re.findall(r"^def (test_\w+)", file.read_text(), re.M))


@pytest.mark.parametrize("kind", ["benchmarks", "verification"])
def test_the_list_of_pages_has_the_program_and_the_commit_of_each(kind):
    listed = (ROOT / "docs" / "evidence" / f"{kind}.md").read_text("utf-8")
    rows = re.findall(r"\]\(\.\./(\S+)\) \| `(\S+)` \| (\w+) \|", listed)
    made = EVIDENCE["pages"](kind)
    found = [(f"{kind}/{m.path.name}", str(EVIDENCE["program"](m)), m.commit) for m in made]
    assert rows == found, "run tools/evidence.py"
    assert [name for _, name, _ in rows if not (ROOT / name).exists()] == []


def test_a_benchmark_writes_its_command_commit_and_machine(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "FOLDER", tmp_path)
    monkeypatch.setattr(sys, "argv", ["-m", "--system", str(tmp_path / "my file.h5"), "--write"])
    pages.page("one", "One", ["| 1 |"], True)
    title, _, head, _, row = (tmp_path / "one.md").read_text("utf-8").splitlines()
    assert (title, row) == ("# One", "| 1 |")
    assert re.search(
        r" --system 'my file.h5' --write` at commit \w+\S*, 20\d\d-.*, \d+ GB\.$", head
    )
    assert EVIDENCE["HEAD"].search(head)


@pytest.mark.system
def test_every_benchmark_finds_what_it_imports_and_small_ones_run():
    files = [path for path in (ROOT / "benchmarks").rglob("*.py") if "pyharm" not in path.name]
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts) for path in files]
    runs = [["-c", f"import {', '.join(names)}"]]
    runs += [["-m", f"benchmarks.solver.{name}", "--quick"] for name in QUICK]
    runs += [["-m", "benchmarks.rom.interface", *"--size 0.012 --nodes 60".split()]]
    for words in runs:
        subprocess.run([sys.executable, *words], cwd=ROOT, check=True)
