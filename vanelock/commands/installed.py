"""What is installed with the program: pages of the manual, examples, and files to begin with."""

import os
import posixpath
import re
import shutil
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import vanelock
from vanelock.common.errors import InputError
from vanelock.common.files.files import placed, writing

PAGES = Path(vanelock.__path__[0]) / "manual"
PARTS = {
    "start": "First steps",
    "": "Guides",
    "theory": "Theory",
    "evidence": "Evidence",
    "benchmarks": "Benchmarks",
    "verification": "Verification",
}
"""Folders of pages in the order in which they are listed."""
_LINK = re.compile(r"(!?)\[((?:`[^`]*`|[^]`])*)\]\(([^)\s]*)\)")
_DIRECTIVE = re.compile(r"^```\{(\w+)\}.*?^```\n+", re.MULTILINE | re.DOTALL)


@lru_cache
def pages() -> dict[str, Path]:
    """Files of the pages by name: "sweeps", "start/install"."""
    found = [path for part in PARTS for path in sorted((PAGES / part).glob("*.md"))]
    names = {path.relative_to(PAGES).with_suffix("").as_posix(): path for path in found}
    names.pop("index", None)  # the list takes its place
    return names


def page_names(incomplete: str) -> list[str]:
    """Pages that a word may become."""
    return [name for name in pages() if name.startswith(incomplete)]


def contents_list() -> str:
    """All pages, a line each: name and title."""
    lines = []
    wide = max(map(len, pages()))
    for part, heading in PARTS.items():
        inside = [name for name in pages() if posixpath.dirname(name) == part]
        titles = (pages()[name].read_text("utf-8").partition("\n")[0] for name in inside)
        rows = [f"  {n:<{wide}}  {t.lstrip('# ')}" for n, t in zip(inside, titles, strict=True)]
        lines += [f"{heading}:", *rows, ""]
    return "\n".join([*lines, "One of them: vanelock manual PAGE"])


def page_text(name: str) -> str:
    """A page of the manual in Markdown, to be read on its own.

    Links to other pages are replaced by their names, pictures by their captions.
    """
    if name not in pages():
        guides = ", ".join(each for each in pages() if posixpath.dirname(each) in ("", "start"))
        others = ", ".join(f"{part}/..." for part in PARTS if part not in ("", "start"))
        raise InputError(
            f'manual: "{name}" is no page; expected one of {guides}, {others} '
            "(`vanelock manual` lists all)"
        )
    text = _DIRECTIVE.sub("", pages()[name].read_text("utf-8"))
    folder = posixpath.dirname(name)

    def without_link(link: re.Match[str]) -> str:
        picture, words, target = link.groups()
        if picture:
            return f"(picture: {words})"
        if "://" in target:
            return f"{words} ({target})"
        place = posixpath.normpath(posixpath.join(folder, target.partition("#")[0]))
        page = place.removesuffix(".md")
        if not target.count(".md") or page not in pages():
            return words
        same = words.removesuffix(".md").replace(" ", "_") == page
        return f"`{page}`" if same else f"{words} (`{page}`)"

    return _outside_code(text, lambda prose: _LINK.sub(without_link, prose))


def _outside_code(text: str, change: Callable[[str], str]) -> str:
    parts = text.split("```")
    return "```".join(part if i % 2 else change(part) for i, part in enumerate(parts))


def _formulas_as_code(prose: str) -> str:
    """Formulas between backquotes, where Markdown takes no `_` or `*` of theirs for its own."""
    shown = re.sub(r"^\$\$\n(.*?)\n\$\$$", r"~~~\n\1\n~~~", prose, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"\$([^$`]+)\$", r"`\1`", shown)


def show(name: str | None) -> None:
    """Print a page, or without a name the list of all, laid out where a terminal shows it."""
    if name is None:
        print(contents_list())
    elif sys.stdout.isatty():
        from rich.console import Console
        from rich.markdown import Markdown
        from rich.theme import Theme

        plain = Theme({"markdown.code": "bold", "markdown.code_block": "none"})
        text = _outside_code(page_text(name), _formulas_as_code)
        page = Markdown(text, code_theme="ansi_dark", hyperlinks=False)
        Console(theme=plain).print(page)
    else:
        print(page_text(name), end="")


EXAMPLES = Path(vanelock.__path__[0]) / "examples"
_LEFT = shutil.ignore_patterns("runs", "__pycache__", ".*")
"""What running an example leaves beside it."""


def examples() -> dict[str, Path]:
    """The examples by name: a study file, or the folder of a study or scene with what it needs."""
    found = sorted(each for each in EXAMPLES.iterdir() if not each.name.startswith(("_", ".")))
    return {each.stem: each for each in found if each.is_dir() or each.suffix == ".toml"}


def example_names(incomplete: str) -> list[str]:
    """Examples that a word may become."""
    return [name for name in examples() if name.startswith(incomplete)]


def write_example(name: str, path: Path | None = None) -> Path:
    """Write an example, all of it or nothing."""
    if name not in examples():
        raise InputError(f'--example "{name}": expected one of {", ".join(examples())}')
    source = examples()[name]
    target = Path(source.name) if path is None else path
    _refuse_taken(target, "folder" if source.is_dir() else "file")
    with (
        writing(target),
        TemporaryDirectory(prefix=f".{target.name}.", dir=target.parent) as folder,
    ):
        made = Path(folder) / target.name
        if source.is_dir():
            shutil.copytree(source, made, ignore=_LEFT, copy_function=shutil.copyfile)
        else:
            shutil.copyfile(source, made)
        os.rename(made, target)
    return target


def _refuse_taken(path: Path, kind: str) -> None:
    """Refuse a path that is there already, or whose folder is not."""
    if os.path.lexists(path):
        raise InputError(f"{path}: exists already; name another {kind}")
    if not path.parent.is_dir():
        raise InputError(f"{path}: cannot be written: {path.parent} is not a folder")


def how_to_use(path: Path) -> str:
    """What to do with an example that was written."""
    for file in (path, path / "scene.toml", path / "study.toml"):
        if file.is_file():
            return f"run it with: vanelock run {file}"
    return "open its notebooks with Jupyter"


TEMPLATES = Path(vanelock.__path__[0]) / "input" / "templates"


def template_text(kind: str = "study", all_keys: bool = False) -> str:
    """The text of a commented file, "study" or "scene": the first keys to set, or every key."""
    if not all_keys:
        return (TEMPLATES / f"first_{kind}.toml").read_text("utf-8")
    from vanelock.analyses import ANALYSES

    text = (TEMPLATES / f"{kind}.toml").read_text("utf-8")
    joint = "contacts.lap" if kind == "scene" else "joints.interlock"
    tables = [a.template for a in ANALYSES if kind == "study" or a.scene_keys is not None]
    return "\n".join([text, *(each.replace("JOINT", joint) for each in tables if each)])


def write_template(
    path: str | os.PathLike[str], kind: str = "study", all_keys: bool = False
) -> None:
    """Write it to a file that is not there yet.

    Raises
    ------
    InputError
        If the file exists or cannot be written.
    """
    _refuse_taken(Path(path), "file")
    with placed(path) as temporary:
        temporary.write_text(template_text(kind, all_keys), "utf-8")
