"""Measured responses: columns of frequency or rotor speed, and amplitude, from CSV files.

The first line that is not blank and does not begin with # names the columns, with units:

    frequency (Hz), amplitude (um), sigma (um)
    speed [rpm]; strain [um/m]

A comma, semicolon or tab separates columns; with the latter two, decimal commas are read too. An
amplitude is half the peak-to-peak of displacement or strain; a column called peak-to-peak is
halved.
"""

import re
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError, raised
from vanelock.common.files.files import contents
from vanelock.common.quantities import si
from vanelock.input.cases.values import Given, ring_of
from vanelock.input.messages import show
from vanelock.input.schema.comparison import MeasuredCurve
from vanelock.input.schema.study import Study

Floats = NDArray[np.float64]

DISPLACEMENT, STRAIN = "displacement", "strain"
NAMES = {
    "frequency": ("frequency", "freq", "f", "excitation frequency", "hz"),
    "speed": ("speed", "rotor speed", "n", "rpm", "revolutions"),
    "amplitude": (
        "amplitude", "amp", "a", "displacement", "deflection", "response", "strain", "x", "peak",
    ),
    "peak-to-peak": ("peak-to-peak", "peak to peak", "pk-pk", "p-p", "pp"),
    "sigma": ("sigma", "std", "standard deviation", "uncertainty", "s"),
}  # fmt: skip
TURN = 2 * np.pi
UNITS = {
    "frequency": {"Hz": 1.0, "kHz": 1e3, "1/s": 1.0, "rad/s": 1 / TURN},
    "speed": {
        "rpm": 1.0, "1/min": 1.0, "min-1": 1.0, "rev/min": 1.0, "krpm": 1e3,
        "1/s": 60.0, "rev/s": 60.0, "Hz": 60.0, "rad/s": 60 / TURN,
    },
}  # fmt: skip
"""In Hz and rpm. Not by a library of units, to which a revolution is 2π."""
STRAINS = {"ustrain": 1e-6, "microstrain": 1e-6, "µε": 1e-6, "με": 1e-6, "1": 1.0, "-": 1.0}

LARGEST = 10_000_000
"""Bytes of the largest file of a measured curve."""


@dataclass(frozen=True)
class Measured:
    """A measured response.

    Attributes
    ----------
    name : str
        What legends call it.
    frequency : (p,) float
        Hz, ascending.
    amplitude : (p,) float
        Half the peak-to-peak: displacement, m, or strain.
    quantity : str
        "displacement", of the monitored one, or "strain".
    sigma : (p,) float or None
        Standard deviation of each amplitude, where it is known.
    engine_order : int
        EO > 0, so that the rotor's speed is 60 f / EO.
    gauge : int or None
        Place of the strain gauge among the study's, from 0.
    direction : str
        "up" or "down", as the frequency was swept.
    load : float
        The load over that of the study.
    """

    name: str
    frequency: Floats
    amplitude: Floats
    quantity: str = DISPLACEMENT
    sigma: Floats | None = None
    engine_order: int = 1
    gauge: int | None = None
    direction: str = "up"
    load: float = 1.0

    @property
    def label(self) -> str:
        """Its name, with the load where that is another."""
        return self.name if self.load == 1 else f"{self.name}, load × {self.load:g}"

    @property
    def speed(self) -> Floats:
        """(p,) rotor speed, rpm."""
        return 60 * self.frequency / self.engine_order


def load_measured(given: Given) -> tuple[Measured, ...]:
    """The measured curves of a study or a scene.

    Raises
    ------
    InputError
        One line with file, line and column for what cannot be read.
    """
    return tuple(_read(given, i) for i in range(len(given.measured)))


def curve_mistakes(given: Given) -> list[str]:
    """What is wrong with the files of measured curves, each by itself."""
    return [
        f"measured[{i}].file: {line}"
        for i in range(len(given.measured))
        for line in raised(partial(_read, given, i))
    ]


def _read(given: Given, i: int) -> Measured:
    order, gauges = ring_of(given)[1], 0
    if isinstance(given, Study):
        order, gauges = (given.excitation.engine_orders or (order,))[0], len(given.outputs.gauges)
    return read_measured(given.measured[i], abs(order) or 1, gauges, f"measured[{i}]")


def read_measured(keys: MeasuredCurve, order: int, gauges: int, where: str) -> Measured:
    """A measured curve.

    Parameters
    ----------
    keys : MeasuredCurve
        Its table of the study.
    order : int
        Engine order of the study, for a file that says none.
    gauges : int
        Number of strain gauges of the study.
    where : str
        What the table is called in errors.
    """
    columns = _Columns(Path(keys.file))
    own = keys.engine_order or order
    abscissa, scale = columns.one_of("frequency"), 1.0
    if abscissa is None:
        abscissa, scale = columns.one_of("speed"), own / 60
    if abscissa is None:
        raise InputError(f"{columns.where}: needs a column frequency (Hz) or speed (rpm)")
    column = columns.one_of("amplitude")
    half = 1.0
    if column is None:
        column, half = columns.one_of("peak-to-peak"), 0.5
    if column is None:
        raise InputError(f"{columns.where}: needs a column amplitude with its unit, such as (um)")
    frequency = scale * columns.numbers(abscissa, positive=True)
    amplitude, quantity = columns.amplitude(column)
    spread = columns.one_of("sigma")
    sigma = None
    if spread is not None:
        unit = columns.unit(spread) or columns.unit(column)
        sigma = half * _factor(unit, quantity, columns.at(spread)) * columns.numbers(spread, True)
    elif keys.sigma is not None:
        factor = _factor(columns.unit(column), quantity, columns.at(column))
        sigma = np.full(len(amplitude), half * keys.sigma * factor)
    known = ~np.isnan(frequency) & ~np.isnan(amplitude)
    if sigma is not None:
        known &= ~np.isnan(sigma)
    if known.sum() < 2:
        raise InputError(f"{columns.path}: {known.sum()} points: at least 2 are needed")
    order_of = np.argsort(frequency[known], kind="stable")
    return Measured(
        name=keys.name or columns.path.stem,
        frequency=frequency[known][order_of],
        amplitude=half * amplitude[known][order_of],
        quantity=quantity,
        sigma=None if sigma is None else sigma[known][order_of],
        engine_order=own,
        gauge=_gauge(keys, quantity, gauges, where),
        direction=keys.direction,
        load=keys.load,
    )


def _gauge(keys: MeasuredCurve, quantity: str, gauges: int, where: str) -> int | None:
    """Place of the gauge that a strain belongs to."""
    if quantity == DISPLACEMENT:
        if keys.gauge is not None:
            raise InputError(f"{where}.gauge = {keys.gauge}: {keys.file} holds no strain")
        return None
    if keys.gauge is None and gauges != 1:
        have = f"of {gauges} gauges" if gauges else "outputs.gauges has none"
        raise InputError(f"{where}: {keys.file} holds a strain: give gauge, its number ({have})")
    return (keys.gauge or 1) - 1


class _Columns:
    """The cells of a CSV file under its header."""

    def __init__(self, path: Path) -> None:
        self.path = path
        lines = [
            (i, line)
            for i, line in enumerate(_text(path).splitlines(), 1)
            if line.strip() and not line.lstrip().startswith("#")
        ]
        if not lines:
            raise InputError(f"{path}: empty: a header and numbers are needed")
        self._line, header = lines[0]
        self.where = f"{path}: line {self._line}"
        self._mark = max(";\t,", key=header.count)
        self._rows = [(i, self._split(line)) for i, line in lines[1:]]
        self._heads = [_head(cell) for cell in self._split(header)]
        for i, row in self._rows:
            if len(row) > len(self._heads) and any(row[len(self._heads) :]):
                raise InputError(
                    f"{path}: line {i}: {len(row)} cells under {len(self._heads)} columns"
                )

    def _split(self, line: str) -> list[str]:
        return [cell.strip().strip('"').strip() for cell in line.split(self._mark)]

    def one_of(self, kind: str) -> int | None:
        """Place of the column of a kind, None where there is none."""
        found = [i for i, (name, _) in enumerate(self._heads) if name in NAMES[kind]]
        if len(found) > 1:
            names = " and ".join(str(i + 1) for i in found)
            raise InputError(f"{self.where}: columns {names} both hold the {kind}")
        return found[0] if found else None

    def unit(self, column: int) -> str:
        """Unit that the header names, or ""."""
        return self._heads[column][1]

    def at(self, column: int) -> str:
        """Where its header is, for errors."""
        return f"{self.where}, column {self._heads[column][0]}"

    def amplitude(self, column: int) -> tuple[Floats, str]:
        """Amplitudes in SI, and what they are of."""
        name, unit = self._heads[column]
        if not unit:
            raise InputError(f'{self.at(column)}: needs a unit, such as "{name} (um)" or (um/m)')
        quantity = STRAIN if unit in STRAINS or "/" in unit else DISPLACEMENT
        return _factor(unit, quantity, self.at(column)) * self.numbers(column), quantity

    def numbers(self, column: int, positive: bool = False) -> Floats:
        """(p,) numbers of a column, of a frequency or speed in Hz or rpm; NaN where empty."""
        name, unit = self._heads[column]
        kind = next((kind for kind in UNITS if name in NAMES[kind]), None)
        factor = 1.0
        if kind is not None and unit:
            known = {name.lower(): value for name, value in UNITS[kind].items()}
            if unit.lower() not in known:
                allowed = ", ".join(UNITS[kind])
                raise InputError(f'{self.at(column)}: unit "{unit}": expected one of {allowed}')
            factor = known[unit.lower()]
        found = []
        for i, row in self._rows:
            text = row[column] if column < len(row) else ""
            decimal = text.replace(",", ".") if self._mark != "," else text
            try:
                number = float(decimal) if text else float("nan")
            except ValueError:
                number = float("inf")
            low = number <= 0 if positive else number < 0
            if low or number == float("inf"):
                what = "a number > 0" if positive else "a number >= 0"
                raise InputError(
                    f"{self.path}: line {i}, column {name}: {show(text)}: expected {what}"
                )
            found.append(factor * number)
        return np.array(found, float)


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


def _factor(unit: str, quantity: str, where: str) -> float:
    """SI value of one unit of an amplitude."""
    if quantity == STRAIN:
        return STRAINS[unit] if unit in STRAINS else _converted(unit, "dimensionless", where)
    return _converted(unit, "m", where)


def _converted(unit: str, to: str, where: str) -> float:
    try:
        value: Any = si(f"1 {unit}", to)
    except ValueError:
        meant = "a length such as um" if to == "m" else "a strain such as um/m"
        raise InputError(f'{where}: unit "{unit}": expected {meant}') from None
    return float(value)


def _text(path: Path) -> str:
    raw = contents(path, "a CSV file", LARGEST)
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return raw.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise InputError(f"{path}: not a text file")
