"""The process: its memory, signals that end it, standard streams, version.

Signals that end a command, raised so that what is under way is tidied up, and those of others.

SIGINT, SIGTERM and SIGHUP are raised as `Stopped`, which no library takes for an error of its own.
Where Python drops what is raised, as in `__del__` and in callbacks of weak references or of C
code, it is raised again a moment later; where a library drops it, at the next step or point.
"""

import ctypes
import errno
import os
import resource
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, MutableMapping
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple, NoReturn, TextIO, TypeVar, cast

K = TypeVar("K")
V = TypeVar("V")
LEAST, LEAST_SPACE = 0.5e9, 1.5e9
"""Bytes that the libraries and the smallest run take, and of address space."""
SPACE = "the address space that `ulimit -v` allows"
MACHINE, GROUP = "this machine's memory", "this control group's memory"
OF_ITS_OWN = 2**28
"""Bytes from which on an array gets memory of its own, which it returns."""
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
_PROC, _GROUPS = Path("/proc"), Path("/sys/fs/cgroup")


class _Bound(NamedTuple):
    """What bounds a process: bytes in all, bytes still left, and its name."""

    total: float
    left: float
    name: str


def _bounds() -> list[_Bound]:
    """What the machine, control groups and `ulimit` let this process take; empty if not known."""
    machine = _numbers(_PROC / "meminfo")
    found = list(_of_groups())
    if "MemTotal" in machine:
        total = machine["MemTotal"]
        found.append(_Bound(total, machine.get("MemAvailable", total), MACHINE))
    own = _numbers(_PROC / "self" / "status")
    for limit, field, name in (
        (resource.RLIMIT_AS, "VmSize", SPACE),
        (resource.RLIMIT_DATA, "VmData", "the data that `ulimit -d` allows"),
    ):
        total = resource.getrlimit(limit)[0]
        if total != resource.RLIM_INFINITY:
            found.append(_Bound(total, total - own.get(field, 0.0), name))
    return found


def capacity() -> float:
    """Bytes that this process may take in all, whatever else runs now; infinite if not known."""
    return min((each.total for each in _bounds()), default=float("inf"))


def require(needed: float, what: str) -> None:
    """Refuse what takes more bytes than are left."""
    for each in _bounds():
        if needed > each.left:
            has = f"{gigabytes(max(each.left, 0.0))} of {each.name} are left"
            raise MemoryError(f"{what} takes about {gigabytes(needed)}, {has}")


def largest() -> float:
    """Bytes that this process, or one of those that it started, has held at most."""
    ended = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return 1024.0 * max(resource.getrusage(who).ru_maxrss for who in ended)


def keep_freed() -> None:
    """Have the C library keep what arrays leave for the next ones, all but the largest.

    It returns what an array of 128 kB or more took to the system at once, which then clears each
    page of the next one: a tenth of a run's time. Other C libraries than glibc stay as they are.
    """
    with suppress(AttributeError, OSError):
        set_option = ctypes.CDLL(None).mallopt
        set_option(_MMAP_THRESHOLD, OF_ITS_OWN)
        set_option(_TRIM_THRESHOLD, 2**30)


def require_least() -> None:
    """Refuse to begin where not even the smallest run fits: libraries then fail, or hang.

    OpenBLAS tries for ever to get its buffers.
    """
    for each in _bounds():
        least = LEAST_SPACE if each.name == SPACE else LEAST
        if each.total < least:
            has = f"{gigabytes(each.total)} is all of {each.name}"
            raise MemoryError(f"the smallest run takes {gigabytes(least)}, {has}")


def refusal(error: MemoryError) -> str:
    """The line for an error that comes from too little memory."""
    reason = f" ({error})" if str(error) else ""
    return f"not enough memory{reason}: a coarser mesh, fewer harmonics or points take less"


def is_shortage(error: BaseException | None) -> bool:
    """Whether a library could not be loaded for want of memory, as the error or its origin says."""
    if error is None:
        return False
    text = str(error).lower()
    if "failed to map segment" in text or "cannot allocate memory" in text:
        return True
    return is_shortage(error.__cause__ or error.__context__)


def gigabytes(count: float) -> str:
    """Bytes in words."""
    return f"{count / 1e9:.2g} GB" if count < 9.5e9 else f"{count / 1e9:.0f} GB"


def latest(cache: MutableMapping[K, V], key: K, make: Callable[[], V], most: int) -> V:
    """A value that is kept, or made after those that were used longest ago have gone."""
    if key in cache:
        cache[key] = cache.pop(key)
    else:
        while len(cache) >= most:
            del cache[next(iter(cache))]
        cache[key] = make()
    return cache[key]


def _numbers(path: Path) -> dict[str, float]:
    """Fields of a file of the kernel that are numbers, bytes."""
    found = {}
    with suppress(OSError, ValueError):
        for line in path.read_text().splitlines():
            name, *rest = line.replace(":", " ").split() or [""]
            if rest and rest[0].isdecimal():
                found[name] = int(rest[0]) * (1024.0 if rest[1:] == ["kB"] else 1.0)
    return found


def _of_groups() -> Iterator[_Bound]:
    """Limits of the control groups that this process is in, versions 1 and 2."""
    try:
        lines = (_PROC / "self" / "cgroup").read_text().splitlines()
    except OSError:
        return
    for line in lines:
        _, kinds, own = line.split(":", 2)
        if kinds not in ("", "memory"):
            continue
        root = _GROUPS / kinds
        names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        most, used, cached = names if kinds else ("memory.max", "memory.current", "inactive_file")
        place = Path(os.path.normpath(f"{root}/{own}"))
        while root == place or root in place.parents:
            total, taken = _number(place / most), _number(place / used)
            if total is not None and taken is not None and total < 1 << 60:
                # files that the limit counts give way
                left = total - taken + _numbers(place / "memory.stat").get(cached, 0.0)
                yield _Bound(total, left, GROUP)
            place = place.parent


def _number(path: Path) -> float | None:
    try:
        return float(int(path.read_text()))
    except (OSError, ValueError):  # "max": none
        return None


ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
AGAIN = 0.02
"""Seconds after which a signal whose exception Python dropped is raised again."""
_ROOM = 1024
"""Bytes for the C library's record of how a signal is handled; it takes some 150."""


class Stopped(BaseException):
    """A signal that ends the command."""

    def __init__(self, number: int) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.number, self.status = number, 128 + number


_arrived: list[int] = []
"""The signal that was raised in the block of `raised` and is not answered."""


@contextmanager
def raised() -> Iterator[None]:
    """Raise `Stopped` in this block where a signal of `ENDING` arrives.

    What is ignored, as by `nohup` and in a shell's background, stays ignored.
    """
    unraisable, timers = sys.unraisablehook, list[threading.Timer]()

    def lost(dropped: "sys.UnraisableHookArgs") -> None:
        if not isinstance(dropped.exc_value, Stopped):
            unraisable(dropped)
            return
        main = threading.main_thread().ident or 0
        timer = threading.Timer(AGAIN, signal.pthread_kill, (main, dropped.exc_value.number))
        timer.daemon = True
        timers.append(timer)
        timer.start()

    sys.unraisablehook = lost
    _arrived.clear()
    before = {number: signal.getsignal(number) for number in ENDING}
    before = {number: known for number, known in before.items() if known != signal.SIG_IGN}
    for number in before:
        signal.signal(number, _raise)
    try:
        yield
        raise_dropped()
    finally:
        for number, known in before.items():
            signal.signal(number, known)
        for timer in timers:
            timer.cancel()
        sys.unraisablehook = unraisable


def answered() -> None:
    """What came is seen to: it is not raised again."""
    _arrived.clear()


def raise_dropped() -> None:
    """Raise `Stopped` once more if a signal has come, and whoever caught it went on."""
    if _arrived and threading.current_thread() is threading.main_thread():
        raise Stopped(_arrived[0])


def _raise(number: int, frame: FrameType | None) -> NoReturn:
    _arrived[:] = [number]
    raise Stopped(number)


@contextmanager
def held() -> Iterator[None]:
    """Let signals of `ENDING` that have a handler wait until the end of this block."""
    if threading.current_thread() is not threading.main_thread():  # which alone handles signals
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    handlers = {number: signal.getsignal(number) for number in ENDING}
    kept = {number: known for number, known in handlers.items() if callable(known)}
    for number in kept:
        signal.signal(number, lambda *arrived: came.append(arrived))
    try:
        yield
    finally:
        for number, known in kept.items():
            signal.signal(number, known)
        for first, frame in came[:1]:
            kept[signal.Signals(first)](first, frame)


@contextmanager
def preserved() -> Iterator[None]:
    """Undo what a library does to the handling of signals in this block; they wait meanwhile.

    Handlers of C code are restored, too, which Python's `signal` module does not see.
    """
    library = ctypes.CDLL(None)
    known = {number: ctypes.create_string_buffer(_ROOM) for number in signal.valid_signals()}
    for number, record in known.items():
        library.sigaction(number, None, record)
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    try:
        yield
    finally:
        for number, record in known.items():
            library.sigaction(number, record, None)  # refused for SIGKILL and SIGSTOP
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Lost(BaseException):
    """A standard stream that cannot be written, which no library takes for an error of its own."""

    def __init__(self, name: str, error: OSError) -> None:
        super().__init__(f"{name}: cannot be written: {error.strerror or error}")
        self.unread = error.errno == errno.EPIPE


class _Stream:
    """A stream whose failures are `Lost`; all else is its own."""

    def __init__(self, stream: Any, name: str) -> None:
        self._stream, self._name = stream, name

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text."""
        try:
            return int(self._stream.write(text))
        except OSError as error:
            raise self._lost(error) from None

    def flush(self) -> None:
        """Write what is held back."""
        try:
            self._stream.flush()
        except OSError as error:
            raise self._lost(error) from None

    def _lost(self, error: OSError) -> Lost:
        """Let what is held back go nowhere when Python ends."""
        os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
        return Lost(self._name, error)


@contextmanager
def guarded() -> Iterator[None]:
    """Have a standard stream that cannot be written raise `Lost` in this block.

    What goes to a closed one is dropped; on a terminal without UTF-8 other characters become "?".
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # or its descriptor would be that of the next file opened
            setattr(sys, name, open(os.devnull, mode))
            os.set_inheritable(getattr(sys, name).fileno(), True)
    before = sys.stdout, sys.stderr
    for stream in before:
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")
    sys.stdout = cast(TextIO, _Stream(sys.stdout, "standard output"))
    sys.stderr = cast(TextIO, _Stream(sys.stderr, "standard error"))
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def missing_libraries(names: Iterable[str]) -> list[str]:
    """Those shared libraries that the loader does not find."""
    missing = []
    for name in names:
        try:
            ctypes.CDLL(name)
        except OSError:
            missing.append(name)
    return missing


def installed(distribution: str) -> str:
    """Installed version of a distribution, "none" where it is not there.

    A build leaves vanelock.egg-info in the source, which is found first from there; only what was
    installed has a RECORD.
    """
    from importlib.metadata import distributions  # too slow for every command

    found = [*distributions(name=distribution)]
    recorded = (each for each in found if each.read_text("RECORD") is not None)
    chosen = next(recorded, found[0] if found else None)
    return "none" if chosen is None else chosen.version


def release(of: str) -> str:
    """A version without what counts commits since a tag: "0.1.0" of "0.1.0.dev12".

    What is kept on the disk is known by this and by a digest of the code, so that a commit that
    changes no code of a step leaves what the step has computed valid.
    """
    return of.partition(".dev")[0]


__version__ = installed("vanelock")
