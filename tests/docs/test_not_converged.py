"""The page on convergence has every message that the program has, word by word."""

import ast
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vanelock.nonlinear import Contact, Options, Response, System, frequency_response
from vanelock.results.figures.curves import NOTE
from vanelock.results.files.writer import Results

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "not_converged.md").read_text("utf-8")
REPORTED = re.compile(
    r"did not converge|DID NOT CONVERGE|NOT CONVERGED|NOT DETERMINED|no converged|not converged \("
    r"|needs a converged|point[^.]* converged|no solution|something is not held|rigid[- ]body"
    r"|end of the frequency range|WARNING"
)
ELSEWHERE = {
    NOTE,  # a caption
    "WARNING: ",  # taken off a warning, or put before one
}


def messages() -> set[str]:
    """The fixed parts of every text in the code about convergence, docstrings apart."""
    found = set()
    stages = [init.parent for init in (ROOT / "vanelock").glob("*/__init__.py")]
    for source in [path for stage in stages for path in stage.rglob("*.py")]:
        tree = ast.parse(source.read_text("utf-8"))
        plain = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.JoinedStr):
                parts = [p.value for p in node.values if isinstance(p, ast.Constant)]
                plain |= {id(p) for p in node.values}
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                parts = [] if id(node) in plain else [node.value]
            else:
                continue
            found |= {str(part) for part in parts if REPORTED.search(str(part))}
    return {each for each in found - ELSEWHERE if "a cell is unknown" not in each}


def test_every_message_is_on_the_page() -> None:
    """Its longest run of words, since what is around differs from place to place."""
    found = messages()
    assert len(found) > 15
    page = " ".join(PAGE.replace("`", "").split())
    missing = {text for text in found if core(text) not in page}
    assert missing == set(), "say in docs/not_converged.md what it means and what to try"


def core(text: str) -> str:
    """The part between punctuation that is about convergence."""
    parts = filter(REPORTED.search, re.split(r"[,;:()]|\.(?=\s|$)", text))
    return next(parts, text).strip(" ;:,.()")


def test_every_message_on_the_page_has_an_advice() -> None:
    rows = [line for line in PAGE.splitlines() if line.startswith("|") and "---" not in line]
    cells = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]
    assert len(cells) > 20
    assert [row[0] for row in cells if len(row) != 3 or not row[2]] == []


def spring(stiffness: float) -> System:
    """A mass of 1 kg on a contact that is pressed."""
    pressed = Contact(normal=0, kn=stiffness, preload=1e-3 * stiffness)
    return System.from_matrices([[1.0]], [[0.0]], [pressed], damping_ratio=0.01, force={0: 1.0})


@pytest.mark.parametrize("lost", [(), (0, 2)])
def test_what_the_page_looks_closer_with_takes_the_system_of_the_case(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lost: tuple[int, ...]
) -> None:
    """As written, on a sweep whose first case is stiffer, with points lost and without."""
    snippet = next(s for s in re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S))
    first, second = spring(4e6), spring(1e6)
    found: Response = frequency_response(second, [100.0, 120.0, 140.0], Options(1))
    converged = ~np.isin(np.arange(3), lost)
    results = Results(tmp_path / "runs" / "my" / "results.h5")
    results.path.parent.mkdir(parents=True)
    with results.edit("system", "response/mu=0.15") as file:
        results.put_system(file, "system", first)
        results.put(file, "response/mu=0.15", replace(found, converged=converged))
        results.put_system(file, "response/mu=0.15/system", second)
    results.flush()
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(snippet, names)
    assert ("again" in names) == bool(lost)
    if lost:
        expected = found.amplitude[list(lost)]
        np.testing.assert_allclose(names["again"].amplitude, expected, rtol=1e-8)
