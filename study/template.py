"""The commented files that `vanelock init` writes: a study, or a scene of matrices."""

import os
from importlib.resources import files
from pathlib import Path

from vanelock.errors import InputError
from vanelock.files import placed


def template_text(package: str = "study") -> str:
    """The text of a package's commented file, "study" or "assembly"."""
    return files(f"vanelock.{package}").joinpath("template.toml").read_text("utf-8")


def write_template(path: Path, package: str = "study") -> None:
    """Write it to a file that is not there yet.

    Raises
    ------
    InputError
        If the file exists or cannot be written.
    """
    if os.path.lexists(path):
        raise InputError(f"{path}: exists already; name another file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: cannot be written: {path.parent} is not a folder")
    with placed(path) as temporary:
        temporary.write_text(template_text(package), "utf-8")
