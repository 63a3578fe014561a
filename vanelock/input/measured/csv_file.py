"""Measured points from CSV files.

The first line that is not blank and does not begin with # names the columns, with units:

    frequency (Hz), amplitude (um), sigma (um)
    speed [rpm]; strain [um/m]

A comma, semicolon or tab separates columns; with the latter two, decimal commas are read too. An
amplitude is half the peak-to-peak of displacement or strain; a column called peak-to-peak is
halved.
"""

import re
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.checked import show
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import rows_of_cells
from vanelock.common.files.files import contents
from vanelock.common.quantities import factor
from vanelock.common.tables import counted
from vanelock.input.measured.units import (
    DISPLACEMENT,
    STRAIN,
    STRAINS,
    UNITS,
    Points,
)

NAMES = {
    "frequency": ("frequency", "freq", "f", "excitation frequency", "hz"),
    "speed": ("speed", "rotor speed", "n", "rpm", "revolutions"),
    "amplitude": (
        "amplitude", "amp", "a", "displacement", "deflection", "response", "strain", "x", "peak",
    ),
    "peak-to-peak": ("peak-to-peak", "peak to peak", "pk-pk", "p-p", "pp"),
    "sigma": ("sigma", "std", "standard deviation", "uncertainty", "s"),
}  # fmt: skip
LARGEST = 10_000_000
"""Bytes of the largest file of a measured curve."""


def read_csv(path: Path, engine_order: int) -> Points:
    """The points of a file; those over speed are at that engine order."""
    columns = _Columns(path)
    abscissa, per_unit = columns.one_of("frequency"), 1.0
    if abscissa is None:
        abscissa, per_unit = columns.one_of("speed"), engine_order / 60
    if abscissa is None:
        raise InputError(f"{columns.where}: needs a column frequency (Hz) or speed (rpm)")
    column = columns.one_of("amplitude")
    half = 1.0
    if column is None:
        column, half = columns.one_of("peak-to-peak"), 0.5
    if column is None:
        raise InputError(f"{columns.where}: needs a column amplitude with its unit, such as (um)")
    frequency = per_unit * columns.numbers(abscissa, positive=True)
    name, unit = columns.heads[column]
    if not unit:
        raise InputError(f'{columns.at(column)}: needs a unit, such as "{name} (um)" or (um/m)')
    quantity = STRAIN if unit in STRAINS or "/" in unit else DISPLACEMENT
    scale = half * _amplitude_factor(unit, quantity, columns.at(column))
    amplitude = scale * columns.numbers(column)
    sigma = None
    if (spread := columns.one_of("sigma")) is not None:
        own = columns.heads[spread][1] or unit
        one = half * _amplitude_factor(own, quantity, columns.at(spread))
        sigma = one * columns.numbers(spread, True)
    return Points(frequency, amplitude, quantity, np.full(len(amplitude), scale), sigma)


class _Columns:
    """The cells of a CSV file under its header."""

    def __init__(self, path: Path) -> None:
        self.path = path
        lines = rows_of_cells(_text(path))
        if not lines:
            raise InputError(f"{path}: empty: a header and numbers are needed")
        (number, header), *self._rows = lines
        self.where = f"{path}: line {number}"
        self.heads = [_head(cell) for cell in header]
        for i, row in self._rows:
            if len(row) > len(self.heads) and any(row[len(self.heads) :]):
                raise InputError(
                    f"{path}: line {i}: {counted(len(row), 'cell')} under "
                    f"{counted(len(self.heads), 'column')}"
                )

    def one_of(self, kind: str) -> int | None:
        """Place of the column of a kind, None where there is none."""
        found = [i for i, (name, _) in enumerate(self.heads) if name in NAMES[kind]]
        if len(found) > 1:
            names = " and ".join(str(i + 1) for i in found)
            raise InputError(f"{self.where}: columns {names} both hold the {kind}")
        return found[0] if found else None

    def at(self, column: int) -> str:
        """Where its header is, for errors."""
        return f"{self.where}, column {self.heads[column][0]}"

    def numbers(self, column: int, positive: bool = False) -> Floats:
        """(p,) numbers of a column, of a frequency or speed in Hz or rpm; NaN where empty."""
        name, unit = self.heads[column]
        kind = next((kind for kind in UNITS if name in NAMES[kind]), None)
        size = 1.0
        if kind is not None and unit:
            known = {name.lower(): value for name, value in UNITS[kind].items()}
            size = known.get(unit.lower(), 0.0)
            if not size:
                allowed = ", ".join(UNITS[kind])
                raise InputError(f'{self.at(column)}: unit "{unit}": expected one of {allowed}')
        found = []
        for i, row in self._rows:
            text = row[column] if column < len(row) else ""
            try:
                number = float(text.replace(",", ".")) if text else float("nan")
            except ValueError:
                number = float("inf")
            low = number <= 0 if positive else number < 0
            if low or number == float("inf"):
                what = "a number > 0" if positive else "a number >= 0"
                raise InputError(
                    f"{self.path}: line {i}, column {name}: {show(text)}: expected {what}"
                )
            found.append(size * number)
        return np.array(found, float)


def _amplitude_factor(unit: str, quantity: str, where: str) -> float:
    """SI value of one unit of an amplitude."""
    try:
        if quantity == STRAIN:
            return STRAINS[unit] if unit in STRAINS else factor(unit, "dimensionless")
        return factor(unit, "m")
    except ValueError:
        meant = "a strain such as um/m" if quantity == STRAIN else "a length such as um"
        raise InputError(f'{where}: unit "{unit}": expected {meant}') from None


def _head(cell: str) -> tuple[str, str]:
    """Name and unit of a column: `name (unit)`, `name [unit]`, `name, unit` or `name_unit`."""
    opened = re.search(r"[(\[]", cell)
    if opened and cell.endswith((")", "]")):
        name, unit = cell[: opened.start()], cell[opened.end() : -1]
    else:
        name, _, unit = cell.partition(" in ")
        if not unit and cell.count("_") == 1:
            name, unit = cell.split("_")
    name = re.sub(r"[\s_]+", " ", name).strip().lower()
    if name in ("hz", "rpm") and not unit:
        unit = {"hz": "Hz", "rpm": "rpm"}[name]
    return name, unit.strip()


def _text(path: Path) -> str:
    raw = contents(path, "a CSV file", LARGEST)
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return raw.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise InputError(f"{path}: not a text file")
