"""Sizes that the project holds itself to, of the working tree, of a commit, or of two commits.

    python tools/targets.py [COMMIT [COMMIT]] [--trial COMMIT]

prints a column for the working tree's tracked files or for each commit, and of two commits the
difference. How it counts:

- lines and code by folder are those of `tools/budget.py`; the product is all of them but tests;
- public names are classes and functions at the top level of the product's modules whose names have
  no underscore in front; what a package hands on (imports, `_modules`) is not counted again, and
  constants and type aliases, names that are assigned, have a row of their own;
- names that say no type are parameters of functions and lambdas, and annotated fields of classes,
  in the product, that are called just `found`, `given` and so on (`SAY_NO_TYPE`);
- keys are the leaves of the study's schema by their dotted names: a table inside a table is not
  one, nor are the swept keys, which name others (`[sweep]`, `[rows]`); keys of lists count once;
- words, between white space, are those of guides and theory, without the page of every key;
- the last is how long a file `vanelock init` writes.

Keys and that file come from the program of the tree or commit in question, in a process of its own.
With `--trial`, also how many files a commit touched, such as one that only adds an analysis.
"""

import argparse
import ast
import io
import os
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any, get_args

from budget import BUDGET, ROOT, count, folder_of

SAY_NO_TYPE = {
    *("at", "base", "each", "first", "found", "given", "kept"),
    *("known", "own", "place", "still", "wanted", "whole"),
}
MANUAL = ("docs", "docs/start", "docs/theory")
SWEPT = ("sweep", "rows")


def sizes(root: Path, paths: list[str]) -> dict[str, int]:
    """All rows of the table for files below a folder, by their titles."""
    folders = list(tomllib.loads(BUDGET.read_text("utf-8"))["code"])
    sources = [path for path in paths if folder_of(path) in folders and path.endswith(".py")]
    product = [path for path in sources if folder_of(path) != "tests"]
    sums = count(root, sources, folders)
    tests = sums.pop("tests")
    sums |= {"product": [sum(row) for row in zip(*sums.values(), strict=True)], "tests": tests}
    rows: dict[str, int] = {}
    for folder, (lines, code, _) in sums.items():
        rows |= {f"{folder}: lines": lines, f"{folder}: code": code}
    rows |= {"product: files": len(product), "tests: files": len(sources) - len(product)}
    modules = [ast.parse((root / path).read_text("utf-8")) for path in product]
    rows["public names"] = sum(len(list(defined(module))) for module in modules)
    rows["public constants and aliases"] = sum(len(list(assigned(module))) for module in modules)
    rows["names that say no type"] = sum(
        name in SAY_NO_TYPE for module in modules for name in parameters_and_fields(module)
    )
    rows["keys of a study"], init = _of_program(root)
    rows["words of guides and theory"] = sum(
        len((root / path).read_text("utf-8").split())
        for path in map(PurePosixPath, paths)
        if str(path.parent) in MANUAL and path.suffix == ".md" and path.name != "keys.md"
    )
    return rows | {"lines of `vanelock init`": init}


def defined(module: ast.Module) -> Iterator[str]:
    """Public classes and functions at the top level of a module."""
    for node in module.body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            if not node.name.startswith("_"):
                yield node.name


def assigned(module: ast.Module) -> Iterator[str]:
    """Public names that are assigned at the top level of a module."""
    for node in module.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        for target in [node.target] if isinstance(node, ast.AnnAssign) else targets:
            for name in ast.walk(target):
                if isinstance(name, ast.Name) and not name.id.startswith("_"):
                    yield name.id


def parameters_and_fields(module: ast.Module) -> Iterator[str]:
    """Names of all parameters and of the annotated fields of classes."""
    for node in ast.walk(module):
        if isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.ClassDef):
            for field in node.body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                    yield field.target.id


def keys(model: Any, table: str = "") -> set[str]:
    """Dotted names of the leaves of a pydantic model."""
    leaves = set()
    for name, field in model.model_fields.items():
        key = f"{table}.{name}".lstrip(".")
        tables = list(_models(field.annotation))
        leaves |= {key} if not tables else set().union(*(keys(inner, key) for inner in tables))
    return leaves - set(SWEPT)


def _models(annotation: Any) -> Iterator[Any]:
    if hasattr(annotation, "model_fields"):
        yield annotation
    for part in get_args(annotation):
        yield from _models(part)


def _of_program(root: Path) -> tuple[int, int]:
    """Keys and lines of `vanelock init`, by the program below a folder."""
    code = (
        "import vanelock, targets\n"
        "print(vanelock.__file__)\n"
        "print(len(targets.keys(vanelock.Study)))\n"
        "print(len(vanelock.template_text().splitlines()))"
    )
    path = os.pathsep.join([str(root), str(Path(__file__).parent)])
    said = subprocess.check_output(
        [sys.executable, "-c", code], cwd=root, env=os.environ | {"PYTHONPATH": path}, text=True
    )
    file, leaves, lines = said.splitlines()
    if not Path(file).is_relative_to(root):
        raise RuntimeError(f"vanelock of {root} expected, {file} imported")
    return int(leaves), int(lines)


def _git(*arguments: str) -> bytes:
    return subprocess.check_output(["git", *arguments], cwd=ROOT)


def working_tree() -> dict[str, int]:
    """Rows of what git tracks, as it stands in the folder."""
    paths = _git("ls-files", "-z").decode().split("\0")
    return sizes(ROOT, [path for path in paths if path and (ROOT / path).is_file()])


def of_commit(commit: str) -> dict[str, int]:
    """Rows of a commit, from a copy of its files."""
    with (
        tempfile.TemporaryDirectory() as folder,
        tarfile.open(fileobj=io.BytesIO(_git("archive", commit))) as archive,
    ):
        archive.extractall(folder, filter="data")
        return sizes(Path(folder).resolve(), [m.name for m in archive if m.isfile()])


def _commit(text: str) -> str:
    try:
        return _git("rev-parse", "--verify", "--quiet", f"{text}^{{commit}}").decode().strip()
    except subprocess.CalledProcessError:
        raise argparse.ArgumentTypeError(f"a commit expected, not {text!r}") from None


def main(arguments: list[str] | None = None) -> None:
    """Print the table; the command line's arguments if none are named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("commits", nargs="*", type=_commit, metavar="COMMIT", help="none to two")
    parser.add_argument("--trial", type=_commit, metavar="COMMIT", help="files that it touched")
    options = parser.parse_args(arguments)
    if len(options.commits) > 2:
        parser.error("at most two commits")
    columns = [(commit[:8], of_commit(commit)) for commit in options.commits]
    columns = columns or [("as it is", working_tree())]
    print(f"{'':<48}" + "".join(f"{title:>12}" for title, _ in columns), end="")
    print(f"{'difference':>12}" if len(columns) == 2 else "")
    for row in columns[0][1]:
        numbers = [rows[row] for _, rows in columns]
        print(f"{row:<48}" + "".join(f"{number:>12,}" for number in numbers), end="")
        print(f"{numbers[1] - numbers[0]:>+12,}" if len(columns) == 2 else "")
    if options.trial:
        touched = _git("show", "--format=", "--name-only", options.trial).splitlines()
        print(f"{f'files touched by {options.trial[:8]}':<48}{len(touched):>12,}")


if __name__ == "__main__":
    main()
