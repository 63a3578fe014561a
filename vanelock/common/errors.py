"""Errors that a user can mend, and how they are reported."""

from collections.abc import Callable


class InputError(ValueError):
    """Input that cannot be used.

    The message is one line that names the key or file, what was given and what is allowed. The
    command line prints it and exits with status 2; a library user catches it as a `ValueError`.
    """


def raised(check: Callable[[], object]) -> list[str]:
    """The lines of the `InputError` that a check raises; none where it does not."""
    try:
        check()
    except InputError as error:
        return str(error).splitlines()
    return []


MOST_MISTAKES = 20
"""Mistakes of one file that are reported, a line each; of the rest their number."""


def printable(text: str) -> str:
    """Text for one line of a terminal: control characters, which could steer it, become "?"."""
    return "".join(c if c.isprintable() else "?" for c in text)


LONGEST = 1000
"""Characters of a line that is reported; the longest list of known keys has half of that."""


def cut_short(text: str, longest: int = LONGEST) -> str:
    """What quotes a file, cut where it quotes too much."""
    return text if len(text) <= longest else f"{text[: longest - 3]}..."


def first_mistakes(lines: list[str]) -> list[str]:
    """The first of many lines about mistakes, and how many more there are."""
    if len(lines) <= MOST_MISTAKES + 1:  # the last may be such a number itself
        return lines
    return [*lines[:MOST_MISTAKES], f"and {len(lines) - MOST_MISTAKES:,} more mistakes"]


class FolderError(InputError):
    """A file or folder that cannot be written: nothing can go on."""
