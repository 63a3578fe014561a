"""Lines of code by folder, held against what `budget.toml` allows: exit status 1 above it.

    python tools/budget.py

prints lines in all, of code (apart from imports, docstrings, comments and blank ones), and of
docstrings, as `ruff format` leaves them. A budget only falls: a commit that raises one says what
left instead.
"""

import ast
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUDGET = ROOT / "tools" / "budget.toml"
SMALL = ("common", "input", "pipeline")
"""Rooms of vanelock/ that are counted together, as are `STEPS`, `SHOWN` and all others."""
STEPS = ("stages", "analyses")
SHOWN = ("quantities", "results", "render", "report")


def folder_of(path: str) -> str:
    """What a file counts for."""
    top, _, rest = path.partition("/")
    room = rest.partition("/")[0]
    if top != "vanelock":
        return "mesh, fem, rom" if top in ("mesh", "fem", "rom") else top
    for rooms in (SMALL, STEPS, SHOWN):
        if room in rooms:
            return ", ".join(rooms)
    return "commands, vanelock/*.py"


def counted(text: str) -> tuple[int, int, int]:
    """Lines in all, of code, and of docstrings."""
    lines, described, imported = text.splitlines(), set[int](), set[int]()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            imported.update(range(node.lineno, (node.end_lineno or 0) + 1))
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            if isinstance(node.value.value, str):
                described.update(range(node.lineno, (node.end_lineno or 0) + 1))
    code = sum(
        number not in described | imported and bool(line.split("#")[0].strip())
        for number, line in enumerate(lines, 1)
    )
    return len(lines), code, len(described)


def count(root: Path, paths: Iterable[str], folders: Iterable[str]) -> dict[str, list[int]]:
    """Sums of `counted` by folder, of those of the sources below `root` that are there."""
    sums = {folder: [0, 0, 0] for folder in folders}
    for path in paths:
        if (folder := folder_of(path)) in sums and (root / path).is_file():
            lines = counted((root / path).read_text("utf-8"))
            sums[folder] = [a + b for a, b in zip(sums[folder], lines, strict=True)]
    return sums


def main() -> int:
    """Print the table; 1 if a folder has more code than its budget."""
    listed = subprocess.run(
        ["git", "ls-files", "*.py"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split()
    allowed = tomllib.loads(BUDGET.read_text("utf-8"))["code"]
    sums = count(ROOT, listed, allowed)
    print(f"{'folder':<40}{'lines':>8}{'code':>8}{'allowed':>9}{'docstrings':>12}")
    for folder, most in allowed.items():
        lines, code, described = sums[folder]
        over = f"  above its budget by {code - most}" if code > most else ""
        print(f"{folder:<40}{lines:>8,}{code:>8,}{most:>9,}{described:>12,}{over}")
    return int(any(sums[folder][1] > most for folder, most in allowed.items()))


if __name__ == "__main__":
    sys.exit(main())
