"""The manual builds without a warning, needs no network to be read, and misses no public name."""

import importlib
import re
import subprocess
import sys
import zlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.system
PACKAGES = [f"vanelock.{name}" for name in ("mesh", "fem", "fem.matrix_files", "rom", "nonlinear")]
PACKAGES += ["vanelock", "vanelock.render", "vanelock.report"]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("manual")
    done = subprocess.run(
        [
            *(sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going"),
            *(ROOT / "docs", folder / "html"),
        ],
        capture_output=True,
        text=True,
        cwd=folder,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "html"


def test_pages_ask_for_nothing_beyond_themselves(built):
    pages = list(built.rglob("*.html"))
    assert len(pages) > 60
    # what a browser fetches by itself: pictures, scripts, styles, frames
    fetched = re.compile(r'(?:src|<link[^>]*?href)="((?:https?:)?//[^"]*)"')
    asked = {page.name: fetched.findall(page.read_text("utf-8")) for page in pages}
    assert {name: found for name, found in asked.items() if found} == {}


def test_formulas_are_drawn_by_the_browser_alone(built):
    page = (built / "theory" / "harmonic_balance.html").read_text("utf-8")
    assert page.count('<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=') > 10
    assert not re.search(r"src=\"[^\"]*mathjax", page, re.IGNORECASE)
    text = re.sub(r"<(pre|code|script|svg)\b.*?</\1>", "", page, flags=re.DOTALL)
    assert "$" not in text
    assert "\\omega" not in text


def test_every_public_name_is_in_the_reference(built):
    data = (built / "objects.inv").read_bytes().split(b"\n", 4)[4]
    listed = {line.split(" ")[0] for line in zlib.decompress(data).decode().splitlines()}
    missing = []
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in module.__all__:
            home = getattr(getattr(module, name), "__module__", None) or ""
            owners = [each for each in PACKAGES if f"{home}.".startswith(f"{each}.")]
            if f"{max(owners, key=len, default=package)}.{name}" not in listed:
                missing.append(f"{package}.{name}")
    assert missing == []


def test_every_page_of_docs_can_be_reached(built):
    sources = {page.relative_to(ROOT / "docs") for page in (ROOT / "docs").rglob("*.md")}
    linked = set()
    for page in built.rglob("*.html"):
        for found in re.findall(r'href="([^"#:]+\.html)', page.read_text("utf-8")):
            linked.add((page.parent / found).resolve().relative_to(built.resolve()))
    assert {source for source in sources if source.with_suffix(".html") not in linked} == set()
