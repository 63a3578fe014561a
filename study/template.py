"""The commented files that `vanelock init` writes: a study, or a scene of matrices."""

from importlib.resources import files
from pathlib import Path

from vanelock.errors import InputError
from vanelock.files import writing


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
    text = template_text(package)
    try:
        with writing(path), path.open("x", encoding="utf-8") as file:
            file.write(text)
    except InputError:
        if path.exists():
            raise InputError(f"{path}: exists already; name another file") from None
        raise
