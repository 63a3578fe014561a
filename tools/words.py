"""Find house words: in what users read, in all strings and docstrings, and in the names of code.

The field has terms for these (docs/glossary.md). Run by `make lint`; prints a line for each word
found, and ends with status 1 if there is one.
"""

import ast
import json
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CODE = ("vanelock", "mesh", "fem", "rom", "nonlinear", "benchmarks", "tools", "docs", "tests")
PAGES = (
    *("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**/*.md", "vanelock/**/*.toml"),
    *("examples/**/*.toml", "examples/**/*.ipynb"),
)
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
    r"rivals?": "second peak",
    r"accessory": "output node",
    r"people tell": "are given in",
    r"/ CAD - 1": "volume error",
}
"""Words that nobody else in the field uses so, and what to say."""
NAMES = {"told", "rub", "rubs", "rubbing", "rival", "rivals", "knob", "knobs", "ledger", "crew"} | {
    *("gallery", "easel", "exhibit", "inventory", "rescue", "accessory"),
}
"""Words that no name in code has as a part, between underscores."""
ALLOWED = {
    "CHANGELOG.md": "rival",  # a former name
    "docs/glossary.md": "accessory",  # what papers say
    "docs/fatigue_and_wear.md": "rubbing",  # the title of a paper
    "vanelock/quantities/contacts.py": "rubbing",
    "benchmarks/mesh/blocks.py": "tell",  # which are the same
}
SPARED = ("tools/words.py",)
"""Files whose subject the words are."""


NOT_YET = (
    "benchmarks/accuracy/",
    "benchmarks/mesh/",
)
"""Folders whose names are not looked at yet."""


def house_words(text: str) -> list[tuple[int, str, str]]:
    """Line from 0, word, and what to say instead."""
    return [
        (text.count("\n", 0, match.start()), match[0], better)
        for word, better in INSTEAD.items()
        for match in re.finditer(rf"(?<!\w)(?:{word})(?!\w)", text, re.IGNORECASE)
    ]


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """First line and text of all that a file lets users read; of a notebook, its cells."""
    content = path.read_text("utf-8")
    if path.suffix == ".ipynb":
        for cell in json.loads(content)["cells"]:
            yield 1, "".join(cell["source"])
    elif path.suffix != ".py":
        yield 1, content
    else:
        for node in ast.walk(ast.parse(content)):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
                yield node.lineno, node.value


def house_names(path: Path) -> Iterator[tuple[int, str]]:
    """Line and name of each name in a source that has a house word as a part."""
    with tokenize.open(path) as file:
        for token in tokenize.generate_tokens(file.readline):
            parts = token.string.casefold().replace("told_apart", "").split("_")
            if token.type == tokenize.NAME and NAMES.intersection(parts):
                yield token.start[0], token.string


def files() -> Iterator[Path]:
    """Pages of the manual, examples and sources."""
    for pattern in PAGES:
        for path in sorted(ROOT.glob(pattern)):
            if not path.relative_to(ROOT).as_posix().startswith(GENERATED):
                yield path
    for folder in CODE:
        for path in sorted((ROOT / folder).rglob("*.py")):
            if not any(parent.is_symlink() for parent in path.parents):
                yield path


def found_in(path: Path) -> Iterator[tuple[int, str, str]]:
    """Line, word, and what to say instead."""
    for start, text in texts(path):
        for line, word, instead in house_words(text):
            yield start + line, word, instead
    place = path.relative_to(ROOT).as_posix()
    if path.suffix == ".py" and not place.startswith(NOT_YET):
        for line, name in house_names(path):
            yield line, name, "a name of the field's words"


def main() -> int:
    """Print what is found; how many."""
    count = 0
    for path in files():
        name = path.relative_to(ROOT).as_posix()
        for line, word, instead in found_in(path) if name not in SPARED else ():
            if word.casefold() != ALLOWED.get(name):
                count += 1
                print(f"{name}:{line}: {word}: {instead}")
    return count


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
