"""Reference pages: every public name, from the lists in the packages' `__init__`.

Before Sphinx looks for pages, reference/<package>.md is written for every package that lists names,
so that a new package or name needs no page of its own.
"""

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from typer.testing import CliRunner

import vanelock
from vanelock.__main__ import app as cli

HEADINGS = {"function": "Functions", "class": "Classes", "data": "Constants"}
INDEX = """# Python reference

Every public name. Each stage is a function, or a few, from one product to the next; products are
frozen, and save and load themselves. Examples: [From Python](../python.md).

| package | what |
|---|---|
{table}

```{{toctree}}
:hidden:
:titlesonly:

{names}
```
"""
OPTIONS = {"function": "autofunction", "class": "autoclass", "data": "autodata"}


def packages() -> list[str]:
    """Full names of the packages that list public names."""
    root = Path(vanelock.__file__).parent
    folders = [root, *(link for link in root.iterdir() if (link / "__init__.py").exists())]
    found = [folders[0] / "__init__.py", *(i for f in folders[1:] for i in f.rglob("__init__.py"))]
    listing = [init.parent for init in found if "__all__" in init.read_text("utf-8")]
    return sorted(".".join(("vanelock", *folder.relative_to(root).parts)) for folder in listing)


def _home(value: Any) -> str:
    """The package that lists what is defined in a module, if one does."""
    module = getattr(value, "__module__", None) or ""
    inside = [name for name in packages() if f"{module}.".startswith(f"{name}.")]
    return max(inside, key=len, default="")


def page(package: str) -> str:
    """Markdown of the reference page of a package."""
    module = importlib.import_module(package)
    names: dict[str, list[str]] = {kind: [] for kind in HEADINGS}
    elsewhere = []
    for name in sorted(module.__all__, key=str.lower):
        value = getattr(module, name)
        if (home := _home(value)) not in ("", package):
            elsewhere.append(f"[`{name}`](#{home}.{name})")
        else:
            names[_kind(value)].append(name)
    lines = [f"# {package}", "", module.__doc__ or "", ""]
    lines += [_table(module, [n for kind in HEADINGS for n in names[kind]]), ""]
    if elsewhere:
        lines += [f"Also here: {', '.join(elsewhere)}.", ""]
    for kind, heading in HEADINGS.items():
        if names[kind]:
            lines += [f"## {heading}", "", "```{eval-rst}"]
            for name in names[kind]:
                value = getattr(module, name)
                lines += [f".. {OPTIONS[kind]}:: {package}.{name}"]
                if inspect.isclass(value) and issubclass(value, BaseModel):
                    lines += ["   :no-members:"]
                elif kind == "data":
                    lines += ["   :no-value:"] if not isinstance(value, str | int | float) else []
                lines += [""]
            lines += ["```", ""]
    return "\n".join(lines)


def _purpose(package: str) -> str:
    return (importlib.import_module(package).__doc__ or "").partition("\n")[0]


def _kind(value: Any) -> str:
    if inspect.isclass(value):
        return "class"
    return "function" if callable(value) else "data"


def _table(module: Any, names: list[str]) -> str:
    lines = ["| name | what |", "|---|---|"]
    for name in names:
        value = getattr(module, name)
        documented = _kind(value) != "data"
        first = (inspect.getdoc(value) or "").partition("\n")[0] if documented else "constant"
        cell = first.replace("|", "\\|").replace("<", "&lt;")
        lines.append(f"| [`{name}`](#{module.__name__}.{name}) | {cell} |")
    return "\n".join(lines)


def commands() -> str:
    """Markdown of the page of commands: the help that each prints."""
    lines = ["# Commands", "", "What `--help` prints, command by command.", ""]
    runner = CliRunner()
    for name in [
        "",
        *sorted(each.name or each.callback.__name__ for each in cli.registered_commands),
    ]:
        words = [name, "--help"] if name else ["--help"]
        printed = runner.invoke(cli, words, prog_name="vanelock", terminal_width=96).output
        lines += [f"## {f'vanelock {name}'.strip()}", "", "```text", printed.strip(), "```", ""]
    return "\n".join(lines)


def _write(app: Any, config: Any) -> None:
    folder = Path(app.srcdir) / "reference"
    folder.mkdir(exist_ok=True)
    names = packages()
    pages = {f"{name}.md": page(name) for name in names}
    table = "\n".join(f"| [{name}]({name}.md) | {_purpose(name)} |" for name in names)
    pages["index.md"] = INDEX.format(table=table, names="\n".join(names))
    pages["commands.md"] = commands()
    for old in folder.glob("*.md"):
        if old.name not in pages:
            old.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")


def _literal_bars(app: Any, what: str, name: str, value: Any, options: Any, lines: Any) -> None:
    """The docstrings' bars are absolute values, never substitutions."""
    lines[:] = [re.sub(r"(?<!\\)\|", r"\\|", line) for line in lines]


def _short(app: Any, what: str, name: str, value: Any, options: Any, text: str, gives: str) -> Any:
    """Arrays by their name alone; the docstrings have shapes and kinds of numbers."""
    array = re.compile(r"ndarray\[tuple\[(?:Any|int), \.\.\.\], dtype\[\w+\]\]")
    return tuple(part and array.sub("ndarray", part) for part in (text, gives))


def setup(app: Any) -> dict[str, bool]:
    """Write the pages, and read docstrings as they are meant."""
    app.connect("config-inited", _write)
    app.connect("autodoc-process-docstring", _literal_bars)
    app.connect("autodoc-process-signature", _short)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
