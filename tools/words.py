"""Find house words in what users read: the manual, and the strings and docstrings of the program.

The field has terms for these (docs/glossary.md). Run by `make lint`; prints a line for each word
found, and ends with status 1 if there is one.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("vanelock", "mesh", "fem", "rom", "nonlinear")
PAGES = ("README.md", "CONTRIBUTING.md", "docs/**/*.md", "examples/**/*.toml", "vanelock/**/*.toml")
GENERATED = ("docs/verification", "docs/project", "docs/reference")
"""Pages of recorded figures, the changelog, and what `make docs` makes of docstrings."""

INSTEAD = {
    r"told(?!(?:\s+\w+)?\s+apart)": "given, estimated, reported",
    r"tells?(?!(?:\s+[\w-]+){0,4}\s+apart)": "gives, shows, decides",
    r"rubs?|rubbing": "slips, slides",
    r"of linear (?:free|stuck)": "relative to the linear peak",
    r"may grow": "margin, safety factor",
    r"reserve n|HCF reserve": "safety factor",
    r"other rule": "the name of the criterion",
    r"governing (?:place|stress)": "critical location, critical stress",
    r"knobs?": "setting, parameter",
    r"rivals?": "competing peak",
    r"accessory": "output node",
    r"people tell": "are given in",
    r"/ CAD - 1": "volume error",
}
"""Words that nobody else in the field uses so, and what to say."""
ALLOWED = {
    "docs/glossary.md": "accessory",  # a former name, explained
    "docs/fatigue_and_wear.md": "rubbing",  # the title of a paper
    "vanelock/quantities/contacts/wear.py": "rubbing",
    "vanelock/input/schema/own_mesh.py": "accessory",  # messages for old files
    "vanelock/input/schema/study.py": "accessory",
    "mesh/matching/own_part.py": "accessory",
    "nonlinear/following/peak_response.py": "rival",  # a public name, documented
    "vanelock/published/maps/optimum.py": "rival",
}


def house_words(text: str) -> list[tuple[int, str, str]]:
    """Line from 0, word, and what to say instead."""
    return [
        (text.count("\n", 0, match.start()), match[0], better)
        for word, better in INSTEAD.items()
        for match in re.finditer(rf"(?<!\w)(?:{word})(?!\w)", text, re.IGNORECASE)
    ]


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """First line and text of all that a file lets users read."""
    content = path.read_text("utf-8")
    if path.suffix != ".py":
        yield 1, content
        return
    for node in ast.walk(ast.parse(content)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.lineno, node.value


def files() -> Iterator[Path]:
    """Pages of the manual, examples and sources."""
    for pattern in PAGES:
        for path in sorted(ROOT.glob(pattern)):
            if not path.relative_to(ROOT).as_posix().startswith(GENERATED):
                yield path
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            if not any(parent.is_symlink() for parent in path.parents):
                yield path


def main() -> int:
    """Print what is found; how many."""
    count = 0
    for path in files():
        name = path.relative_to(ROOT).as_posix()
        for start, text in texts(path):
            for line, word, instead in house_words(text):
                if word.casefold() != ALLOWED.get(name):
                    count += 1
                    print(f"{name}:{start + line}: {word}: {instead}")
    return count


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
