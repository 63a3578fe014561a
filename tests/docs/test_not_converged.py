"""The page on convergence has every message that the program has, word by word."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "not_converged.md").read_text("utf-8")
TOLD = re.compile(
    r"did not converge|DID NOT CONVERGE|NOT CONVERGED|no converged|not converged \("
    r"|needs a converged|point[^.]* converged|no solution|something is not held|rigid[- ]body"
    r"|end of the frequency range|WARNING"
)
ELSEWHERE = {
    "points not converged",  # a column of a campaign's CSV files
    "solved: 1 where the point converged; the others are not to be trusted",  # a caption
    "WARNING: ",  # taken off a warning, or put before one
}


def messages() -> set[str]:
    """The fixed parts of every text in the code that tells of convergence, docstrings apart."""
    found = set()
    stages = [init.parent for init in (ROOT / "vanelock").glob("*/__init__.py")]
    for source in [path for stage in stages for path in stage.glob("*.py")]:
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
            found |= {str(part) for part in parts if TOLD.search(str(part))}
    return {each for each in found - ELSEWHERE if "percent; a cell is unknown" not in each}


def test_every_message_is_on_the_page() -> None:
    """Its longest run of words, since what is around differs from place to place."""
    found = messages()
    assert len(found) > 15
    page = " ".join(PAGE.replace("`", "").split())
    missing = {text for text in found if core(text) not in page}
    assert missing == set(), "tell in docs/not_converged.md what it means and what to try"


def core(text: str) -> str:
    """The part between punctuation that tells of convergence."""
    parts = [part.strip() for part in re.split(r"[,;:()]|\.(?=\s|$)", text) if TOLD.search(part)]
    return parts[0] if parts else text.strip(" ;:,.()")


def test_every_message_on_the_page_has_an_advice() -> None:
    rows = [line for line in PAGE.splitlines() if line.startswith("|") and "---" not in line]
    cells = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]
    assert len(cells) > 20
    assert [row[0] for row in cells if len(row) != 3 or not row[2]] == []
