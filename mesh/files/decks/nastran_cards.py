"""Cards of a Nastran deck: comments left out, continuations joined (Quick Reference Guide)."""

from collections.abc import Iterator


def lines_of(text: str) -> list[str]:
    """A deck's lines, without comments and tabs."""
    return [line.partition("$")[0].rstrip().expandtabs(8) for line in text.splitlines()]


def cards(lines: list[str]) -> Iterator[tuple[int, str, list[str]]]:
    """Each card of the bulk data: its line's number, its name, its data fields.

    The bulk data begin after `BEGIN BULK`, or with the first line where there is none. A line has
    8 fields, 4 if they are large, empty ones too.
    """
    heads = (line.upper().split()[:2] for line in lines)
    begin = next((i for i, head in enumerate(heads, start=1) if head == ["BEGIN", "BULK"]), 0)
    current: tuple[int, str, list[str]] | None = None
    for number, line in enumerate(lines[begin:], start=begin + 1):
        if not line.strip():
            continue
        head, fields = _fields(line)
        if head == "" or head[0] in "+*":
            if current is not None:
                current[2].extend(fields)
            continue
        if current is not None:
            yield current
        if head.upper().startswith("ENDDATA"):
            return
        words = head.upper().split()  # control statements are not in fields
        current = number, words[0].rstrip("*"), fields
    if current is not None:
        yield current


def _fields(line: str) -> tuple[str, list[str]]:
    """First field of a line, and its data fields."""
    if "," in line:
        head, *rest = (word.strip() for word in line.split(","))
        count = 4 if head.endswith("*") or head.startswith("*") else 8
    else:
        head = line[:8].strip()
        large = head.endswith("*") or head.startswith("*")
        width, count = (16, 4) if large else (8, 8)
        rest = [line[8 + i * width : 8 + (i + 1) * width].strip() for i in range(count)]
    return head, (rest + [""] * count)[:count]
