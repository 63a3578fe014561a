"""Standard output and error of the command: closed, full, or no longer read by anybody."""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from typing import Any, TextIO, cast


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
