"""Signals that end a command, raised so that what is under way is tidied up, and those of others.

SIGINT, SIGTERM and SIGHUP are raised as `Stopped`, which no library takes for an error of its own.
Where Python drops what is raised, as in `__del__` and in callbacks of weak references or of C
code, it is raised again a moment later; where a library drops it, at the next step or point.
"""

import ctypes
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

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
