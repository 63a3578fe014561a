"""Work on a user's file in a forked child of bounded memory and time, for libraries that trust it.

A damaged file makes such a library crash, loop, or ask for any amount of memory; if the child
falls, only the child does.
"""

import contextlib
import faulthandler
import io
import os
import resource
import signal
import warnings
from collections.abc import Callable
from typing import TypeVar

from vanelock.common.errors import InputError, printable, raised
from vanelock.common.process.signals import ENDING

T = TypeVar("T")

FULL = 3
"""Exit status of a child that ran out of memory."""
SECONDS, MEMORY = 10, 300_000_000
"""What reading a small file may take; each 2 MB more add a second, and each byte EACH bytes."""
EACH = 20


class Fallen(Exception):
    """The child did not come to an end: the message says why."""


def limited(work: Callable[[], str], seconds: int, memory: int) -> str:
    """What some work says, done in a child process."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        status = 0
        try:
            os.close(reading)
            _limit(seconds, memory)
            os.write(writing, work().encode("utf-8", "replace")[:4000])
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
        _, status = os.waitpid(child, 0)
    if text and status == 0:
        return text
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) == FULL:
        raise Fallen("it asks for too much memory")
    slow = os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL)
    raise Fallen("reading it does not end" if slow else "it makes the library that reads it fail")


def by_library(read: Callable[[], T], where: str, size: int, what: str) -> T:
    """What a library reads from a user's file, in a child first: libraries need not fail well."""
    printed = io.StringIO()

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
            raise InputError(f"{where}: not {what} that can be read: {said}") from None

    try:
        trouble = limited(
            lambda: "".join(raised(quietly)) or FINE,
            SECONDS + size // 2_000_000,
            MEMORY + EACH * size,
        )
    except Fallen as fallen:
        trouble = f"{where}: not {what} that can be read: {fallen}"
    if trouble != FINE:
        raise InputError(trouble)
    return quietly()


FINE = "fine"
"""What a child says of a file that it could read."""


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
