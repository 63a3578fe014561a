"""Text and numbers as a page shows them, as safe HTML."""

import math
import re
from pathlib import Path
from typing import Final

from markupsafe import Markup, escape

_RAISED: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_MARKS: Final = re.compile(r"\*\*(?P<bold>.+?)\*\*|`(?P<code>[^`]+)`")


def number(value: float, digits: int = 4) -> str:
    """A number to four significant digits: 250.9, 16,940, 0.3, 1.67×10⁷; "–" if there is none."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    text = f"{value:.{digits - 1}e}"
    mantissa, _, power = text.partition("e")
    if value == 0 or -4 < int(power) < 6:
        # No zeros at the end.
        text = f"{float(text):,.{max(digits - 1 - int(power), 0)}f}"
        return _signed(text.rstrip("0").rstrip(".") if "." in text else text)
    return _signed(f"{mantissa.rstrip('0').rstrip('.')}e{power}")


def _signed(text: str) -> str:
    """A formatted number with a minus sign, and its power of ten raised."""
    mantissa, e, power = text.partition("e")
    raised = f"×10{str(int(power)).translate(_RAISED)}" if e else ""
    return f"{mantissa.replace('-', '−')}{raised}"


def cell(value: str | float | None, form: str = "") -> Markup:
    """What a table shows of a cell, its numbers by a format such as ".1f"."""
    if value is None:
        return Markup("")
    if isinstance(value, bool):
        return Markup("yes") if value else Markup("no")
    if isinstance(value, str):
        return marked(value)
    if math.isfinite(value) and (isinstance(value, int) or (form and form[-1] not in "g")):
        return escape(_signed(format(value, form or ",")))  # counts are given in full
    sign = "+" if form.startswith("+") and value > 0 else ""
    return escape(sign + number(value, int(form.strip("+,.efg") or 4)))


def sentence(text: str) -> str:
    """A line as a sentence."""
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


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


def file_text(file: Path | str, folder: Path) -> str:
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
