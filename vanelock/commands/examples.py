"""The example studies, which are installed with the program, written to be changed and run."""

import os
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

import vanelock
from vanelock.common.errors import InputError
from vanelock.common.files.files import writing

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
    if os.path.lexists(target):
        raise InputError(f"{target}: exists already; name another {_kind(source)}")
    if not target.parent.is_dir():
        raise InputError(f"{target}: cannot be written: {target.parent} is not a folder")
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


def how_to_use(path: Path) -> str:
    """What to do with an example that was written."""
    for file in (path, path / "scene.toml", path / "study.toml"):
        if file.is_file():
            return f"run it with: vanelock run {file}"
    return "open its notebooks with Jupyter"


def _kind(source: Path) -> str:
    return "folder" if source.is_dir() else "file"
