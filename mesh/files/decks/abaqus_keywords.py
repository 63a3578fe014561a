"""Keywords of a deck of Abaqus or CalculiX, with their options and their lines of data."""

from collections.abc import Iterator

from vanelock.common.errors import InputError

Line = tuple[int, list[str]]
"""A line's number and its words between commas."""


def keywords(source: str, text: str) -> Iterator[tuple[int, str, dict[str, str], list[Line]]]:
    """Each keyword: its line's number, its name, its options by name, its lines of data.

    Names are in upper case; a keyword's has no blanks: `USERELEMENT`.
    """
    current: tuple[int, str, dict[str, str], list[Line]] | None = None
    pending: list[str] = []  # a keyword's line that ends in a comma goes on
    for number, line in enumerate(text.splitlines(), start=1):
        line = line.strip()
        if not line or line.startswith("**"):
            continue
        if pending or line.startswith("*"):
            pending.append(line)
            if line.endswith(","):
                continue
            if current is not None:
                yield current
            name, *given = (word.strip() for word in "".join(pending)[1:].split(","))
            pending = []
            pairs = (word.partition("=") for word in given if word)
            options = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
            current = number, "".join(name.upper().split()), options, []
        elif current is not None:
            current[3].append((number, [word.strip() for word in line.split(",")]))
        else:
            raise InputError(f"{source}: line {number}: not an Abaqus deck: no keyword before it")
    if pending:
        raise InputError(f"{source}: ends within a keyword's options")
    if current is not None:
        yield current
