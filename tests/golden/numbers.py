"""The numbers of a run that a user reads, and how they compare with others."""

import csv
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tests.golden.runs import GoldenRun
from tests.vanelock.results.one_file import card, on_page, plain

Numbers = dict[str, list[float]]
"""By table or file and column; NaN where there is nothing."""

OF_THE_MACHINE = {"stages", "time", "seconds", "cpu", "cost", "memory", "meshed"}
"""Tables, columns and arrays that say how fast a machine was."""
FEW = 40
"""Of longer columns of a file a test keeps the least, the largest and how many there are."""
PAGES = "default", "sweep"
"""Runs whose pages are read, too."""
PAGE = "page "
"""How names of what stands on a page begin: numbers of three or four digits."""
TITLES = (
    "All cases at their largest", "Worst location of each feature", "The critical location of",
    "Power of one sector at the peak", "Joints of one sector at the peak", "Finite-element meshes",
)  # fmt: skip
ROUND_OFF = 1e-9
"""Below it, in the units that are shown, numbers are round-off of larger ones."""


def shown(run: GoldenRun) -> Numbers:
    """All tables that the run gave, and the curves and lists beside its pictures."""
    found: Numbers = {}
    counted: dict[str, int] = {}
    for event in run.events:
        key = getattr(event, "key", "")
        if hasattr(event, "columns") and key not in OF_THE_MACHINE:
            counted[key] = counted.get(key, 0) + 1
            rows = event.record()["rows"]
            for name in rows[0] if rows else ():
                keep(found, f"table {key} {counted[key]}: {name}", [row[name] for row in rows])
    if run.folder.name in PAGES:
        on_its_page(found, (run.folder / "report.html").read_text("utf-8"))
    for path in sorted(run.folder.glob("figures/*.csv")):
        with open(path, encoding="utf-8") as file:
            lines = list(csv.reader(line for line in file if not line.startswith("#")))
        for head, *column in zip(*lines, strict=True):
            keep(found, f"{path.name}: {head}", column)
    return found


def on_its_page(found: Numbers, page: str) -> None:
    """Add the cards of a page and its tables of what is computed of each case."""
    for title in TITLES:
        if title in page:
            heads, rows = on_page(page, title)
            for head, *column in zip(heads, *rows, strict=True):
                keep(found, f"{PAGE}{title}: {head}", column)
    for label in re.findall(r'<div class="label">(.*?)</div>', page):
        value, note = card(page, re.escape(label))
        words = re.findall(r"-?\d[\d.,]*", f"{value} {note}")
        keep(found, f"{PAGE}{plain(label)}: numbers", [each.strip(".,") for each in words])


def keep(found: Numbers, name: str, column: list[Any]) -> None:
    """Add a column if it holds numbers, and those of the model."""
    words = set(name.rpartition(": ")[2].replace("_", " ").replace("(", " ").split())
    values = [number(cell) for cell in column]
    if not words & OF_THE_MACHINE and not all(map(math.isnan, values)):
        found[name] = values


def number(cell: Any) -> float:
    """A cell's number, NaN where it has none."""
    try:
        return float(cell.replace(",", "") if isinstance(cell, str) else cell)
    except (TypeError, ValueError):
        return math.nan


def short(numbers: Numbers) -> Numbers:
    """The same to ten digits; of long columns the least, the largest and how many there are."""
    return {
        name: [float(f"{value:.10g}") for value in values]
        if len(values) <= FEW
        else [float(f"{value:.10g}") for value in (np.nanmin(values), np.nanmax(values))]
        for name, values in numbers.items()
    }


def stored(folder: Path) -> Numbers:
    """Every number of the results file, by the path of its array."""
    found: Numbers = {}

    def walk(group: h5py.Group, path: str) -> None:
        for name in group:
            item = group[name]
            if isinstance(item, h5py.Group):
                walk(item, f"{path}/{name}")
            elif item.dtype.kind in "fciub" and name not in OF_THE_MACHINE:
                array = np.atleast_1d(item[()]).reshape(-1)
                found[f"{path}/{name}"] = array.astype(complex).view(float).tolist()

    with h5py.File(folder / "results.h5") as file:
        for name in set(file) - {"provenance"}:
            walk(file[name], name)
    return found


def kind(name: str) -> str:
    """What columns of one file and unit have in common; a column of a table stands alone."""
    file, _, head = name.partition(": ")
    unit = head.rpartition("(")[2]
    return f"{file} {unit}" if unit.endswith(")") else name


def differences(
    one: Mapping[str, list[float]],
    other: Mapping[str, list[float]],
    tolerance: float,
    least: float = 0.0,
) -> Iterator[str]:
    """A line for each column that only one has, or that differs by more than so much.

    So much of the largest number of its column, or of all columns of its file and unit, and more
    than the least that counts.
    """
    largest: dict[str, float] = {}
    for name, values in one.items():
        scale = float(np.nanmax(np.abs(values), initial=0.0))
        largest[kind(name)] = max(scale, largest.get(kind(name), 0.0))
    for name in one.keys() | other.keys():
        a, b = np.array(one.get(name, [])), np.array(other.get(name, []))
        if a.shape != b.shape:
            yield f"{name}: {len(a)} numbers, {len(b)} numbers"
            continue
        scale = largest[kind(name)]
        missing = np.isnan(a) != np.isnan(b)
        apart = np.abs(a - b) > tolerance * scale + least
        if (missing | apart).any():
            worst = int(np.nanargmax(np.where(missing, np.inf, np.abs(a - b))))
            yield f"{name}: {a[worst]:.12g}, {b[worst]:.12g} (place {worst} of {len(a)})"
