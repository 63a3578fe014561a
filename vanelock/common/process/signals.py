"""Signals that end a command, raised so that what is under way is tidied up, and those of others.

SIGINT, SIGTERM and SIGHUP are raised as `Stopped`, which no library takes for an error of its own.
"""

import ctypes
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_ROOM = 1024
"""Bytes for the C library's record of how a signal is handled; it takes some 150."""


class Stopped(BaseException):
    """A signal that ends the command.

    Parameters
    ----------
    number : int
        Of the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.status = 128 + number


@contextmanager
def raised() -> Iterator[None]:
    """Raise `Stopped` in this block where a signal of `ENDING` arrives.

    What is ignored, as by `nohup` and in a shell's background, stays ignored.
    """
    before = {number: signal.getsignal(number) for number in ENDING}
    before = {number: known for number, known in before.items() if known != signal.SIG_IGN}
    for number in before:
        signal.signal(number, _raise)
    try:
        yield
    finally:
        for number, known in before.items():
            signal.signal(number, known)


def _raise(number: int, frame: FrameType | None) -> NoReturn:
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
