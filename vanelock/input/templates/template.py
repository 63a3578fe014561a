"""The commented files that `vanelock init` writes: a study, or a scene of matrices."""

import os
from importlib.resources import files
from pathlib import Path

from vanelock.common.errors import InputError
from vanelock.common.files.files import placed


def template_text(kind: str = "study") -> str:
    """The text of a commented file, "study" or "scene"."""
    return files("vanelock.input.templates").joinpath(f"{kind}.toml").read_text("utf-8")


def write_template(path: str | os.PathLike[str], kind: str = "study") -> None:
    """Write it to a file that is not there yet.

    Raises
    ------
    InputError
        If the file exists or cannot be written.
    """
    if os.path.lexists(path):
        raise InputError(f"{path}: exists already; name another file")
    if not (folder := Path(path).parent).is_dir():
        raise InputError(f"{path}: cannot be written: {folder} is not a folder")
    with placed(path) as temporary:
        temporary.write_text(template_text(kind), "utf-8")
