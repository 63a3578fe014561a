"""A page of blocks as one HTML file that needs nothing else, neither a folder nor a network.

The page's own policy (Content-Security-Policy) forbids every request, so what it shows is what it
holds: plotly.js, packed, pictures and arrays are inside.

Pictures inside a page: the file's pixels, packed anew as WebP, which every browser reads.

Animations and drawings of lines stay exact and take a third to two thirds of a GIF's or PNG's
bytes; shaded pictures, of many colours, are kept to what the eye tells apart, in a quarter.
"""

import gzip
import io
import json
import os
import re
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from functools import cache
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, TypeAlias

import jinja2
from markupsafe import Markup
from PIL import Image, ImageSequence, UnidentifiedImageError, features

from vanelock.common.errors import InputError
from vanelock.common.files.files import placed
from vanelock.common.tables import Table
from vanelock.report import plots, views, wording
from vanelock.report.blocks import Block, OfCase, Page, Picture, Plot, Section, Text, View

_FORMATS: Final = {"PNG": "image/png", "GIF": "image/gif"}
_FEW: Final = 2500  # colours among every ninth pixel: a drawing of lines, smooth edges included
_EXACT: Final[dict[str, Any]] = {"lossless": True, "method": 2, "quality": 20}
_SHADED: Final[dict[str, Any]] = {"quality": 90, "method": 2, "use_sharp_yuv": True}


def embedded(path: Path) -> tuple[str, tuple[int, int]]:
    """A PNG or GIF file as a data URI, and its width and height in pixels."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        with Image.open(io.BytesIO(data), formats=list(_FORMATS)) as picture:
            size, kind = picture.size, _FORMATS[picture.format or ""]
            packed = _webp(picture) if features.check("webp") else data
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError):
        raise InputError(f"{path}: is neither a PNG nor a GIF picture") from None
    if len(packed) < len(data):
        data, kind = packed, "image/webp"
    return f"data:{kind};base64,{b64encode(data).decode('ascii')}", size


def _webp(picture: Image.Image) -> bytes:
    target = io.BytesIO()
    if getattr(picture, "is_animated", False):
        frames, shown = [], []
        for frame in ImageSequence.Iterator(picture):
            frames.append(frame.convert("RGB"))
            shown.append(frame.info.get("duration", 100))  # ms
        rest: dict[str, Any] = {"append_images": frames[1:], "duration": shown, "loop": 0}
        frames[0].save(target, "WEBP", save_all=True, **rest, **_EXACT)
    else:
        whole = picture.convert("RGBA" if "A" in picture.getbands() else "RGB")
        sample = whole.resize((max(whole.width // 3, 1), max(whole.height // 3, 1)), 0)
        drawn = sample.getcolors(_FEW) is not None
        whole.save(target, "WEBP", **(_EXACT if drawn else _SHADED))
    return target.getvalue()


_Packed: TypeAlias = tuple[str, tuple[int, int]]
"""A picture as a data URI, and its width and height in pixels."""
_HERE: Final = Path(__file__).resolve().parent / "page"
_MARKS: Final = {"good": "✓", "warn": "!", "bad": "✗"}
_WORDS: Final = {"good": "good", "warn": "caution", "bad": "not met"}
_DASHES: Final = {"solid": "none", "dash": "7 4", "dot": "2 4", "dashdot": "7 3 2 3"}


def write_page(path: str | os.PathLike[str], page: Page) -> Path:
    """Write the page, whole or not at all, and return its path.

    Parameters
    ----------
    path : path
        HTML file to write.
    page : Page
        What it shows. A picture's `data` in the folder of `path` is linked relative to it.

    Raises
    ------
    InputError
        If a block's arrays do not fit each other, a picture is neither PNG nor GIF, or a file
        cannot be read or written.
    """
    target = Path(path)
    text = _html(page, target.parent)
    with placed(target) as temporary:
        temporary.write_bytes(text.encode("utf-8", "replace"))
    return target


def _html(page: Page, folder: Path) -> str:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_HERE), autoescape=True, undefined=jinja2.StrictUndefined
    )
    for shows in (wording.cell, wording.marked, wording.paragraphs, wording.sentence):
        environment.filters[shows.__name__] = shows
    blocks = [block for section in page.sections for block in section.blocks]
    inner = [each for block in blocks if isinstance(block, OfCase) for each in block.blocks]
    kinds = {type(block).__name__ for block in (*blocks, *inner)}
    paths = [Path(block.path) for block in (*blocks, *inner) if isinstance(block, Picture)]
    with ThreadPoolExecutor() as pool:  # packing lets other threads run
        plotly = pool.submit(_plotly) if "Plot" in kinds else None
        packed = dict(zip(paths, pool.map(embedded, paths), strict=True))
    sections = list(_sections(page.sections, folder, packed))
    cases = list(dict.fromkeys(block.case for block in blocks if isinstance(block, OfCase)))
    return environment.get_template("page.html").render(
        title=page.title,
        subtitle=page.subtitle,
        sections=sections,
        cases=cases if len(cases) > 1 else [],
        plotly=plotly.result() if plotly else "",
        style=Markup(_own("page.css").replace("TITLE", _quoted(f"{page.title} · {page.subtitle}"))),
        scripts=[_script("page.js"), *([_script("view3d.js")] if "View" in kinds else [])],
        marks=_MARKS,
        words=_WORDS,
        dashes=_DASHES,
    )


def _own(name: str) -> str:
    return (_HERE / name).read_text("utf-8")


def _quoted(text: str) -> str:
    """Text inside a string of a style sheet: what could end it is written by its number."""
    return re.sub(r'["\\<\n\r]', lambda match: f"\\{ord(match[0]):x} ", text)


@cache
def _plotly() -> str:
    """plotly.js, packed to a third; the page's script unpacks it."""
    from plotly.offline import get_plotlyjs

    return b64encode(gzip.compress(get_plotlyjs().encode("utf-8"), mtime=0)).decode("ascii")


def _script(name: str) -> Markup:
    return Markup(_own(name).replace("</script", r"<\/script").replace("<!--", r"<\!--"))


def _sections(
    sections: Sequence[Section], folder: Path, packed: Mapping[Path, _Packed]
) -> Iterator[dict[str, Any]]:
    taken: set[str] = {"content"}
    names = (f"figure-{number}" for number in count(1))
    for section in sections:
        blocks = [_shown(block, names, folder, packed) for block in section.blocks]
        name = base = wording.anchor(section.id or section.title)
        number = 1
        while name in taken:
            number += 1
            name = f"{base}-{number}"
        taken.add(name)
        yield {"title": section.title, "id": name, "blocks": blocks, "folded": section.folded}


def _shown(
    block: Block, names: Iterator[str], folder: Path, packed: Mapping[Path, _Packed]
) -> SimpleNamespace:
    """What the template needs of a block."""
    shown: dict[str, Any] = {field.name: getattr(block, field.name) for field in fields(block)}
    shown |= {"kind": type(block).__name__, "id": next(names)}
    match block:
        case OfCase():
            shown["blocks"] = [_shown(each, names, folder, packed) for each in block.blocks]
        case Text():
            pass
        case Table():
            shown["classes"] = [Markup(f' class="{each}"') for each in _classes(block)]
            shown |= {"rows": block.shown, "lines": block.lines}
        case Picture():
            shown["data"] = [wording.file_text(file, folder) for file in block.data]
            shown["source"], shown["size"] = packed[Path(block.path)]
        case Plot():
            shown["data"] = [wording.file_text(file, folder) for file in block.data]
            shown["legend"] = plots.legend(block)
            shown["json"] = _json(plots.figure(block))
        case View():
            scene = views.scene(block)
            shown["motions"] = [motion.name for motion in block.motions]
            shown["sectors"] = scene["sectors"]
            shown["colours"] = ", ".join(scene["colours"])
            shown["json"] = _json(scene)
    return SimpleNamespace(**shown)


def _classes(table: Table) -> Iterator[str]:
    """Class of each column: numbers "n", words "s" on one line, longer text "t"."""
    width = len(table.columns)
    for row in table.rows:
        if len(row) != width:
            raise InputError(f"{table.title}: a row of {len(row)} cells: {width} are needed")
    if table.flags and len(table.flags) != len(table.rows):
        raise InputError(
            f"{table.title}: {len(table.flags)} flags: {len(table.rows)}, or none, are needed"
        )
    return (_kind([row[i] for row in table.shown]) for i in range(width))


def _kind(cells: Sequence[str | float | None]) -> str:
    texts = [cell for cell in cells if isinstance(cell, str)]
    longest = max((len(text) for text in texts), default=0)
    known = [text for text in texts if text not in ("-", "same")]
    if known and all(map(_is_number, known)):
        return "n"
    if longest <= 12 and any(isinstance(cell, int | float) for cell in cells):
        return "n"
    return "s" if longest <= 22 else "t"


def _is_number(text: str) -> bool:
    """Whether it is one, with or without a unit."""
    return re.fullmatch(r"[-+]?\d[\d,]*(\.\d+)?(e[-+]?\d+)?( \S+)?", text) is not None


def _json(value: Any) -> Markup:
    """JSON that may stand inside a script element."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c"))
