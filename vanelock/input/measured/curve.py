"""Measured responses: what files and the study say of them, in SI."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.checked import show
from vanelock.common.errors import InputError, raised
from vanelock.common.tables import counted
from vanelock.input.cases.values import Problem, ring_of
from vanelock.input.measured.csv_file import read_csv
from vanelock.input.measured.units import DISPLACEMENT, Points
from vanelock.input.measured.universal import ENDINGS, read_universal
from vanelock.input.schema.comparison import MeasuredCurve
from vanelock.input.schema.study import Study


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
    def shown(self) -> list[str | list[float]]:
        """All of it that pictures depend on, as JSON can hold it."""
        curves = self.frequency, self.speed, self.amplitude
        return [self.label, self.quantity, *(each.tolist() for each in curves)]

    @property
    def speed(self) -> Floats:
        """(p,) rotor speed, rpm."""
        return 60 * self.frequency / self.engine_order


def load_measured(problem: Problem) -> tuple[Measured, ...]:
    """The measured curves of a study or a scene."""
    return tuple(_read(problem, i) for i in range(len(problem.measured)))


def curve_mistakes(problem: Problem) -> list[str]:
    """What is wrong with the files of measured curves, each by itself."""
    return [
        f"measured[{i}].file: {line}"
        for i in range(len(problem.measured))
        for line in raised(partial(_read, problem, i))
    ]


def _read(problem: Problem, i: int) -> Measured:
    order, gauges = ring_of(problem)[1], 0
    if isinstance(problem, Study):
        gauges = len(problem.outputs.gauges)
    return _read_measured(problem.measured[i], abs(order) or 1, gauges, f"measured[{i}]")


def _read_measured(keys: MeasuredCurve, order: int, gauges: int, where: str) -> Measured:
    """A measured curve."""
    (path, record), own = _place(keys.file), keys.engine_order or order
    points = _points(keys, path, record, own, where)
    sigma = points.sigma
    if sigma is None and keys.sigma is not None:
        sigma = keys.sigma * points.factor
    known = ~np.isnan(points.frequency) & ~np.isnan(points.amplitude)
    if sigma is not None:
        known &= ~np.isnan(sigma)
    inside = ""
    if keys.range is not None:
        low, high = keys.range
        known &= (points.frequency >= low) & (points.frequency <= high)
        inside = f" from {low:g} to {high:g} Hz"
    if known.sum() < 2:
        raise InputError(f"{path}: {counted(known.sum(), 'point')}{inside}: at least 2 are needed")
    ascending = np.flatnonzero(known)[np.argsort(points.frequency[known], kind="stable")]
    return Measured(
        name=keys.name or path.stem,
        frequency=points.frequency[ascending],
        amplitude=points.amplitude[ascending],
        quantity=points.quantity,
        sigma=None if sigma is None else sigma[ascending],
        engine_order=own,
        gauge=_gauge(keys, points.quantity, gauges, where),
        direction=keys.direction,
        load=keys.load,
    )


def _place(file: str) -> tuple[Path, int | None]:
    """The file, and the number of a record of a Universal File behind a colon."""
    name, _, record = file.rpartition(":")
    if record.isdecimal() and name.lower().endswith(ENDINGS):
        return Path(name), int(record)
    return Path(file), None


def _points(
    keys: MeasuredCurve, path: Path, record: int | None, engine_order: int, where: str
) -> Points:
    """What the file says, by the reader of its format."""
    if path.suffix.lower() in ENDINGS:
        return read_universal(path, engine_order, record, keys.unit, keys.force)
    for name in ("unit", "force"):
        if (given := getattr(keys, name)) is not None:
            allowed = ", ".join(ENDINGS)
            raise InputError(f"{where}.{name} = {show(given)}: is for Universal Files ({allowed})")
    return read_csv(path, engine_order)


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
