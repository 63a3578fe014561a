"""Files of the user, and files that are written as a whole or not at all.

Every path that a study file names goes through `beside`, every file of the user that is read as a
whole through `contents`, and every file that is written through `placed`.

Work on a user's file in a forked child of bounded memory and time, for libraries that trust it.

A damaged file makes such a library crash, loop, or ask for any amount of memory; if the child
falls, only the child does.
"""

import contextlib
import faulthandler
import io
import os
import re
import resource
import signal
import stat
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from glob import escape
from pathlib import Path
from typing import TypeVar

from vanelock.common.errors import FolderError, InputError, cut_short, printable, raised
from vanelock.common.process import ENDING

PathLike = str | os.PathLike[str]
LARGEST = 1 << 30
"""Bytes of the largest file that is read as a whole."""


def beside(folder: PathLike, name: str, key: str, outside: bool = False) -> Path:
    """The place of a file that a study names, in the study file's folder or below.

    A path that leaves that folder, by `..`, from the root or through a link, is refused: a study
    that somebody sends should read what was sent with it and nothing else.
    """
    where = f'{key} = "{cut_short(printable(name), 80)}"'
    place = Path(folder) / name
    try:
        real, root = place.resolve(), Path(folder).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise InputError(f"{where}: no path of a file: {reason}") from None
    possible(place, where)
    if not outside and not real.is_relative_to(root):
        how = "a link leads" if Path(os.path.normpath(root / name)).is_relative_to(root) else "is"
        raise InputError(
            f"{where}: {how} outside the study file's folder; put the file there, or allow it with "
            "--allow-outside"
        )
    return place


def possible(location: PathLike, where: str) -> None:
    """Refuse what can be no path: too long, or with a NUL; `where` is what errors call it."""
    try:
        with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
            os.lstat(location)
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


T = TypeVar("T")

FULL = 3
"""Exit status of a child that ran out of memory."""
SECONDS, MEMORY = 10, 300_000_000
"""What reading a small file may take; each 2 MB more add a second, and each byte EACH bytes."""
EACH = 20


def limited(work: Callable[[], str], seconds: int, memory: int, before: str = "") -> str:
    """What some work says, done in a child process; or, behind `before`, why that fell."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        status = 0
        try:
            os.close(reading)
            _limit(seconds, memory)
            os.write(writing, b"." + work().encode("utf-8", "replace")[:4000])
        except MemoryError:
            status = FULL
        finally:
            os._exit(status)  # without anything that the parent would do at its end
    os.close(writing)
    try:
        with open(reading, "rb") as pipe:
            text = pipe.read().decode("utf-8", "replace")
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if text and ended == 0:
        return text[1:]
    if ended == FULL:
        return before + "it asks for too much memory"
    slow = -ended in (signal.SIGXCPU, signal.SIGKILL)
    why = "reading it does not end" if slow else "it makes the library that reads it fail"
    return before + why


def by_library(read: Callable[[], T], where: str, size: int, what: str) -> T:
    """What a library reads from a user's file, in a child first: libraries need not fail well."""
    printed, begins = io.StringIO(), f"{where}: not {what} that can be read: "

    def quietly() -> T:
        try:
            with (
                contextlib.redirect_stdout(printed),
                contextlib.redirect_stderr(printed),
                warnings.catch_warnings(),
            ):
                warnings.simplefilter("ignore")
                # numpy's way to say that numbers were expected and something else was found
                warnings.filterwarnings("error", message="string or file could not be read")
                return read()
        except (InputError, MemoryError):
            raise
        except (Exception, SystemExit) as error:
            reason = "" if isinstance(error, SystemExit) else str(error)
            lines = [line for line in (reason or printed.getvalue()).splitlines() if line.strip()]
            said = printable((lines or [type(error).__name__])[0]).strip()[:160]
            raise InputError(begins + said) from None

    limits = SECONDS + size // 2_000_000, MEMORY + EACH * size
    if trouble := limited(lambda: "".join(raised(quietly)), *limits, begins):
        raise InputError(trouble)
    return quietly()


def _limit(seconds: int, memory: int) -> None:
    """Bound what this process may take; a crash leaves no core file and no message."""
    with open("/proc/self/statm") as file:
        taken = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    for what, limit in (
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_AS, taken + memory),
        (resource.RLIMIT_CORE, 0),
    ):
        most = resource.getrlimit(what)[1]
        limit = limit if most == resource.RLIM_INFINITY else min(limit, most)
        resource.setrlimit(what, (limit, most))
    for number in ENDING:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)
    faulthandler.disable()
    for stream in (1, 2):  # what a C library says as it aborts
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
