"""Text and numbers as a page shows them, as safe HTML."""

import math
import re
from pathlib import Path
from typing import Final

from markupsafe import Markup, escape

from vanelock.report.blocks import Cell

_RAISED: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_MARKS: Final = re.compile(r"\*\*(?P<bold>.+?)\*\*|`(?P<code>[^`]+)`")


def number(value: float) -> str:
    """A number to four significant digits: 250.9, 16,940, 0.3, 1.67×10⁷; "–" if there is none."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    mantissa, _, power = f"{value:.3e}".partition("e")
    exponent = int(power)
    if value == 0 or -4 < exponent < 6:
        # At most three decimals below the first digit; no zeros at the end.
        text = f"{float(f'{value:.4g}'):,.{max(3 - exponent, 0)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        text = f"{mantissa.rstrip('0').rstrip('.')}×10{str(exponent).translate(_RAISED)}"
    return text.replace("-", "−")


def cell(value: Cell) -> Markup:
    """What a table shows of a cell."""
    if value is None:
        return Markup("")
    if isinstance(value, bool):
        return Markup("yes") if value else Markup("no")
    if isinstance(value, str):
        return marked(value)
    # Counts are told in full.
    return escape(f"{value:,}".replace("-", "−") if isinstance(value, int) else number(value))


def marked(text: str) -> Markup:
    """A line of text with **bold** and `code` as HTML; all else literal."""
    pieces, end = [], 0
    for found in _MARKS.finditer(text):
        pieces.append(escape(text[end : found.start()]))
        bold = found["bold"] is not None
        tag, inside = ("strong", found["bold"]) if bold else ("code", found["code"])
        pieces.append(Markup(f"<{tag}>{{}}</{tag}>").format(marked(inside) if bold else inside))
        end = found.end()
    return Markup("").join([*pieces, escape(text[end:])])


def paragraphs(text: str) -> Markup:
    """Text as paragraphs, parted by empty lines."""
    parts = [part.strip() for part in re.split(r"\n\s*\n", text) if part.strip()]
    return Markup("\n").join(Markup("<p>{}</p>").format(marked(part)) for part in parts)


def anchor(title: str) -> str:
    """A title as a name in addresses: "High-cycle fatigue" becomes "high-cycle-fatigue"."""
    return re.sub(r"\W+", "-", title.lower()).strip("-") or "section"


def told(file: Path | str, folder: Path) -> str:
    """A file's name as seen from a folder, if it lies in it, else its name alone."""
    path = Path(file)
    if path.is_absolute():
        root = folder.resolve()
        path = path.relative_to(root) if path.is_relative_to(root) else Path(path.name)
    elif path.is_relative_to(folder):
        path = path.relative_to(folder)
    return path.as_posix()


def quantity(label: str) -> tuple[str, str]:
    """Name and unit of "amplitude (µm)": ("amplitude", "µm"); no unit where there is none."""
    found = re.fullmatch(r"(.*\S)\s+\(([^()]*)\)", label)
    if not found or found[2] in {"", "–", "-", "1"}:
        return (found[1] if found else label), ""
    return found[1], found[2]
