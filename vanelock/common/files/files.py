"""Files of the user, and files that are written as a whole or not at all.

Every path that a study file names goes through `beside`, every file of the user that is read as a
whole through `contents`, and every file that is written through `placed`.
"""

import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from glob import escape
from pathlib import Path

from vanelock.common.errors import FolderError, InputError, printable

PathLike = str | os.PathLike[str]
LARGEST = 1 << 30
"""Bytes of the largest file that is read as a whole."""


def beside(folder: PathLike, given: str, key: str, outside: bool = False) -> Path:
    """The place of a file that a study names, in the study file's folder or below.

    A path that leaves that folder, by `..`, from the root or through a link, is refused: a study
    that somebody sends should read what was sent with it and nothing else.
    """
    shown = printable(given)
    where = f'{key} = "{shown if len(shown) <= 80 else shown[:77] + "..."}"'
    place = Path(folder) / given
    try:
        real, root = place.resolve(), Path(folder).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise InputError(f"{where}: no path of a file: {reason}") from None
    possible(place, where)
    if not outside and not real.is_relative_to(root):
        how = "a link leads" if Path(os.path.normpath(root / given)).is_relative_to(root) else "is"
        raise InputError(
            f"{where}: {how} outside the study file's folder; put the file there, or allow it with "
            "--allow-outside"
        )
    return place


def possible(place: PathLike, where: str) -> None:
    """Refuse what can be no path: too long, or with a NUL; `where` is what errors call it."""
    try:
        with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
            os.lstat(place)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{where}: no path of a file: {reason}") from None


def contents(path: PathLike, needed: str, largest: int = LARGEST) -> bytes:
    """All bytes of a file of the user."""
    regular(path, needed)
    try:
        with open(path, "rb") as file:
            found = file.read(largest + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    if len(found) > largest:
        raise InputError(f"{path}: more than {largest:,} bytes: at most that are read")
    return found


def regular(path: PathLike, needed: str) -> int:
    """Bytes of a regular file of the user that a library will read."""
    try:
        found = os.stat(path)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except ValueError:  # a NUL
        raise InputError(f"{printable(str(path))}: no path of a file") from None
    if stat.S_ISDIR(found.st_mode):
        raise InputError(f"{path}: is a folder, {needed} is needed")
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{path}: is no regular file, {needed} is needed")
    return found.st_size


def default_folder(file: Path) -> Path:
    """Where what a study or a scene gives goes, unless another place is given."""
    return Path("runs") / file.stem


@contextmanager
def writing(path: PathLike) -> Iterator[None]:
    """Turn a failure to write (no permission, full disk) into one line about `path`."""
    try:
        yield
    except (OSError, RuntimeError) as error:  # HDF5 raises either when the disk is full
        text = str(error) or type(error).__name__
        inner = re.search(r"error message = '([^']+)'", text)  # HDF5's report of the system's error
        reason = inner[1] if inner else (getattr(error, "strerror", None) or text).splitlines()[0]
        raise FolderError(f"{path}: cannot be written: {reason}") from None


@contextmanager
def placed(path: PathLike) -> Iterator[Path]:
    """A path beside `path` to write to, which takes its place in the end; folders are made.

    Where `path` is a link, it is replaced: what it leads to is not written. What was left beside it
    by writers that were killed on this machine is removed.
    """
    target = Path(path)
    begins = f".{target.name}.{os.uname().nodename}-"
    temporary = target.with_name(f"{begins}{os.getpid()}.tmp")
    with writing(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        for left in target.parent.glob(f"{escape(begins)}*.tmp"):
            process = left.name.removeprefix(begins).removesuffix(".tmp")
            if process.isdecimal() and not _runs(int(process)):
                left.unlink(missing_ok=True)
        temporary.unlink(missing_ok=True)  # a link of that name would be followed
        try:
            yield temporary
            os.replace(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)


def _runs(process: int) -> bool:
    """Whether there is a process of that number."""
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True
