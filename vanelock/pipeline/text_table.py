"""A table as lines of text that fit a width, in characters that every terminal has.

Heads stand on as many lines as they have words if need be, above their units. Where a table is too
wide, minor columns go, those on the right first; if that is not enough, columns fold into blocks
one below the other, whose rows begin alike. Words are never broken.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from vanelock.common.errors import printable
from vanelock.common.tables import Column, Shown, Table

WIDEST = 1000
"""Characters of a line where nothing limits it: in a file, or before another program."""
GAP = 2
LABEL = 3
"""Of a line, one part in so many is what the columns that name its rows may take."""
HEAD = 6
"""Characters of a head that always stand on one line."""
NARROW = 24
"""Characters below which a column of text rather has a block of its own."""

_PLAIN = str.maketrans({"µ": "u", "μ": "mu", "²": "^2", "³": "^3", "ζ": "zeta"})
_WORD = re.compile(r"[^ ,]+[ ,]*|[ ,]+")


@dataclass(frozen=True)
class _Block:
    """A column: its head and cells, as lines of text each."""

    head: list[str]
    cells: list[list[str]]
    numbers: bool

    @property
    def width(self) -> int:
        return max(len(line) for lines in (self.head, *self.cells) for line in lines or [""])

    def line(self, lines: Sequence[str], i: int) -> str:
        text = lines[i] if 0 <= i < len(lines) else ""
        return text.rjust(self.width) if self.numbers else text.ljust(self.width)


def text_lines(table: Table, width: int = WIDEST) -> list[str]:
    """A table under its title, and what stands below it; lines longer only than one word is."""
    made = [_block(c, [row[i] for row in table.shown]) for i, c in enumerate(table.columns)]
    named = next((i for i, each in enumerate(made[:2]) if each.numbers), min(2, len(made)))
    share = width // LABEL if named < len(made) else width
    made[:named] = [_narrowed(each, share // max(named, 1)) for each in made[:named]]
    texts = [each for each in made[named:] if not each.numbers]
    beside = _total([each for each in made if each not in texts]) + GAP * len(texts)
    room = (width - 1 - beside) // max(len(texts), 1)
    if room < NARROW:
        room = width - 1 - _total(made[:named]) - GAP
    made[named:] = [each if each.numbers else _narrowed(each, room) for each in made[named:]]
    chosen = _without_minor(table.columns, made, width)
    lines = ["", *wrapped(_plain(table.title), width)]
    for i, block in enumerate(_folded(made, chosen, named, width)):
        lines += [""] * (i > 0) + _drawn(block)
    for text in table.lines:
        first, *more = wrapped(_plain(text), width - 2)
        lines += [first, *(f"  {line}" for line in more)]
    return lines


def wrapped(text: str, width: int) -> list[str]:
    """Text on lines of some width, broken after spaces and commas alone; at least one line."""
    lines = [""]
    for word in _WORD.findall(text):
        if lines[-1] and len((lines[-1] + word).rstrip()) > width:
            lines.append("")
        lines[-1] += word
    return [line.rstrip() for line in lines]


def _plain(text: str) -> str:
    return printable(text.translate(_PLAIN))


def _block(column: Column, values: list[Shown]) -> _Block:
    cells = [[_plain(text)] for text in _digits(column, values)]
    unit = [f"[{_plain(column.unit)}]"] if column.unit else []
    widest = max([HEAD, *(len(text) for lines in [unit, *cells] for text in lines)])
    return _Block(
        wrapped(_plain(column.head), widest) + unit,
        cells,
        any(isinstance(v, int | float) for v in values) or not any(values),
    )


def _digits(column: Column, values: Sequence[Shown]) -> list[str]:
    """Cells as text, those of a column with the same decimals, zeros at all their ends aside.

    They are those of the largest number, one more where the least has less than three digits;
    where that is not enough, each has its own.
    """
    found = re.fullmatch(r"\.(\d+)g", column.form or ".4g")
    numbers = [v for v in values if isinstance(v, float) and math.isfinite(v) and v]
    if not found or not numbers:
        return [column.text(v) for v in values]
    sizes = [math.floor(math.log10(abs(float(f"{v:{found[0]}}")))) for v in numbers]
    wanted = int(found[1]) - 1 - max(sizes)
    decimals = max(wanted, min(2, int(found[1]) - 1) - min(sizes), 0)
    if decimals > max(wanted, 0) + 1 or wanted < 0:
        return [column.text(v) for v in values]
    texts = {i: f"{v:.{decimals}f}" for i, v in enumerate(values) if isinstance(v, float)}
    while decimals and all(text.endswith("0") for text in texts.values()):
        decimals -= 1
        texts = {i: text[:-1].rstrip(".") for i, text in texts.items()}
    return [texts.get(i, column.text(v)) for i, v in enumerate(values)]


def _narrowed(block: _Block, width: int) -> _Block:
    """A column of text on lines of some width."""
    cells = [[line for text in lines for line in wrapped(text, width)] for lines in block.cells]
    return _Block(block.head, cells, block.numbers)


def _total(blocks: Sequence[_Block]) -> int:
    return sum(each.width for each in blocks) + GAP * max(len(blocks) - 1, 0)


def _without_minor(columns: Sequence[Column], made: Sequence[_Block], width: int) -> list[int]:
    """Places of the columns that stay: all where those without the minor ones must fold too."""
    every = list(range(len(made)))
    kept = list(every)
    for i in reversed(every):
        if 1 + _total([made[j] for j in kept]) <= width:
            return kept
        if columns[i].minor:
            kept.remove(i)
    return kept if 1 + _total([made[j] for j in kept]) <= width else every


def _folded(
    made: Sequence[_Block], chosen: Sequence[int], named: int, width: int
) -> list[list[_Block]]:
    """Columns side by side as far as they fit, each time behind those that name the rows."""
    label = list(made[:named])
    found = [list(label)]
    for each in (made[i] for i in chosen if i >= named):
        if len(found[-1]) > named and 1 + _total([*found[-1], each]) > width:
            found.append(list(label))
        found[-1].append(each)
    return found


def _drawn(blocks: Sequence[_Block]) -> list[str]:
    """Heads, which end on one line, a rule, and rows."""
    height = max((len(each.head) for each in blocks), default=0)
    rows = [
        [each.line(each.head, i - height + len(each.head)) for each in blocks]
        for i in range(height)
    ]
    rows.append(["─" * (_total(blocks))])
    for cells in zip(*(each.cells for each in blocks), strict=True):
        rows += [
            [each.line(lines, i) for each, lines in zip(blocks, cells, strict=True)]
            for i in range(max(map(len, cells)))
        ]
    return [(" " + (" " * GAP).join(row)).rstrip() for row in rows]
