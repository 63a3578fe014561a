"""What runs leave, read whole: results as one, and tables and cards of a page."""

import html
import json
import re
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vanelock.common.files.digests import BLOCK, stamp


def everything(group: h5py.Group, place: str = "") -> Iterator[tuple[str, Any]]:
    """All that a group holds, links to other files followed, by its place."""
    for name, item in group.items():
        yield f"{place}/{name}", item
        if isinstance(item, h5py.Group):
            yield from everything(item, f"{place}/{name}")


TIMES = ("date", "seconds", "cached")


def contents(path: Path) -> dict[str, str]:
    """All of complete results but times: attributes and bytes of the data sets, by place."""
    found: dict[str, Any] = {}
    with h5py.File(path) as file:
        assert file.attrs["complete"]
        assert len(file["response"]) > 2
        for name, item in everything(file):
            if name.startswith("/provenance"):  # which holds what was computed when
                continue
            if name.endswith("/about"):
                found[name] = json.loads(item[()], object_hook=_without_times)
            elif isinstance(item, h5py.Dataset) and not name.endswith("/seconds"):
                data = item[()]
                found[name] = data.tolist() if item.dtype.kind == "O" else np.array(data).tobytes()
            for key, value in item.attrs.items():
                if key not in TIMES:
                    found[f"{name}@{key}"] = np.asarray(value).tolist()
    return {name: repr(value) for name, value in found.items()}


def _without_times(stored: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in stored.items() if key not in (*TIMES, "cost")}


@contextmanager
def in_one_file(path: Path) -> Generator[h5py.File, None, None]:
    """Take all parts of results into their index, and open it; what it then holds is whole."""
    single = path.with_suffix(".single")
    with h5py.File(path) as file, h5py.File(single, "w", userblock_size=BLOCK) as target:
        for name in file:
            file.copy(name, target, expand_external=True)
        target.attrs.update(file.attrs)
    single.replace(path)
    with h5py.File(path, "a") as file:
        yield file
    stamp(path)


def plain(text):
    text = html.unescape(re.sub(r"<[^>]*>", " ", text))
    return text.replace("\xa0", " ").replace("−", "-").strip()


def number(cell):
    return float(cell.replace(",", "")) if re.fullmatch(r"-?[\d.,e+-]+", cell) else cell


def on_page(page, title):
    """Header cells, with their units, and rows of a table."""
    start = page.index(html.escape(title).replace("&#x27;", "&#39;"))
    whole = page[start : page.index("</table>", start)]
    head = [plain(cell) for cell in re.findall(r"<th[^>]*>(.*?)</th>", whole)]
    rows = [
        [number(plain(cell)) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        for row in re.findall(r"<tr>(.*?)</tr>", whole)
    ]
    return [" ".join(cell.split()) for cell in head], [row for row in rows if row]


def card(page, label):
    found = re.search(
        rf'<div class="label">{label}</div>\s*<div class="value">(.*?)</div>(.*?)</li>', page, re.S
    )
    assert found is not None
    return plain(found[1]), plain(found[2])
