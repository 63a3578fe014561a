"""Measured points from Universal Files: a function record, data set 58, in text or binary.

By pyuff (an optional library). A complex response counts by its modulus; velocities and
accelerations are taken to displacements of a harmonic motion, x = v / ω = a / ω²; a response per
force is multiplied by the force that the study gives. The format: SDRC, Universal File Datasets
Summary; units are in data set 164, where there is one.
"""

import re
import warnings
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError, printable
from vanelock.common.files.files import by_library, regular
from vanelock.common.lazy import library
from vanelock.common.quantities import factor
from vanelock.common.tables import counted
from vanelock.input.measured.units import DISPLACEMENT, STRAIN, STRAINS, TURN, UNITS, Points

NAMES = {3: STRAIN, 8: DISPLACEMENT, 11: "velocity", 12: "acceleration"}
"""Types of an ordinate, by the format's numbers; 0 and 1 say none."""
DERIVATIVES = {STRAIN: 0, DISPLACEMENT: 0, "velocity": 1, "acceleration": 2}
SI_UNITS = {STRAIN: "", DISPLACEMENT: "m", "velocity": "m/s", "acceleration": "m/s^2"}
FORCES = (9, 13)
"""Types of a denominator: a reaction, or the force of excitation."""
GRAVITY = 9.80665
ALIKE = 1e-3
"""Relative difference of two units that are meant to be the same."""


class _RecordOrdinate(NamedTuple):
    """What a record holds: a kind of `SI_UNITS`, and what one unit of it is in SI, maybe over N."""

    kind: str
    factor: float
    per_force: bool


def _ordinate(
    record: Mapping[str, Any], units: Mapping[str, Any] | None, study_unit: str | None, where: str
) -> _RecordOrdinate:
    """What a record is of: by the unit that the study gives, else by the file.

    The file says it twice, by a label and by the system of units of its data set 164, and where
    the two do not agree the study has to.
    """
    kind = int(record.get("ordinate_spec_data_type", 0))
    below = int(record.get("orddenom_spec_data_type", 0))
    label, under = (_label(record, of) for of in ("ordinate", "orddenom"))
    if below not in (0, 1, *FORCES):
        raise InputError(f"{where}: over a quantity of type {below}: only force can be below")
    text = study_unit or label
    if kind not in (0, 1, *NAMES):
        raise InputError(f"{where}: of type {kind}: {', '.join(SI_UNITS)} can be read")
    name = NAMES.get(kind)
    per_force = below in FORCES or text.endswith("/N")
    numerator = re.sub(r"^\((.*)\)$", r"\1", text.removesuffix("/N"))
    known = _labelled(name, numerator, where, bool(study_unit))
    if known is None:
        if units is None or name is None:
            raise InputError(f'{where}: says no unit: give unit, such as "um" or "m/s^2/N"')
        known = name, _of_system(name, units)
    elif not study_unit and units is not None:
        other = _of_system(known[0], units)
        if known[0] != STRAIN and abs(known[1] / other - 1) > ALIKE:
            raise InputError(
                f"{where}: in {printable(label)} by its label, in {other:g} "
                f"{SI_UNITS[known[0]]} by the file's units (data set 164): give unit"
            )
    force = _newtons(under, units, where) if below in FORCES and not study_unit else 1.0
    return _RecordOrdinate(known[0], known[1] / force, per_force)


def _label(record: Mapping[str, Any], of: str) -> str:
    """The unit that an axis is labelled with, as a library of units reads it."""
    text = str(record.get(f"{of}_axis_units_lab", "") or "").strip().replace("**", "^")
    text = re.sub(r"\bs(ec)?2\b", "s^2", text.replace(" ", ""))
    return "" if text.upper() in ("NONE", "UNKNOWN") else text


def _labelled(
    name: str | None, unit: str, where: str, from_study: bool
) -> tuple[str, float] | None:
    """Kind and SI value of a unit that is written; None where there is none."""
    if not unit:
        return None
    for kind in SI_UNITS if name is None else (name,):
        try:
            return kind, _si(unit, kind)
        except ValueError:
            continue
    meant = ", ".join(filter(None, SI_UNITS.values())) if name is None else SI_UNITS[name] or "um/m"
    origin = "unit" if from_study else "label"
    raise InputError(f'{where}: {origin} "{printable(unit)}": expected one like {meant}')


def _si(unit: str, kind: str) -> float:
    """SI value of one unit of a kind."""
    if kind == STRAIN and unit in STRAINS:
        return STRAINS[unit]
    if kind == "acceleration" and unit in ("g", "gn", "G"):
        return GRAVITY
    return factor(unit, SI_UNITS[kind] or "dimensionless")


def _of_system(kind: str, units: Mapping[str, Any]) -> float:
    """SI value of one unit of a kind in the file's system of units, whose factors lead there."""
    return 1.0 if kind == STRAIN else 1.0 / float(units["length"])


def _newtons(label: str, units: Mapping[str, Any] | None, where: str) -> float:
    """Newtons in one unit of the force below."""
    if label:
        try:
            return factor(label, "N")
        except ValueError:
            raise InputError(f'{where}: over "{printable(label)}": expected a force') from None
    return 1.0 if units is None else 1.0 / float(units["force"])


ENDINGS = (".uff", ".unv", ".uf")
LARGEST = 200_000_000
"""Bytes of the largest file that is read."""
MOST = 12
"""Records that a message lists."""
RECORD, UNITS_OF_FILE = 58, 164
"""Data sets that are read."""
FUNCTIONS = {
    0: "function", 1: "time response", 2: "auto spectrum", 3: "cross spectrum",
    4: "frequency response", 5: "transmissibility", 6: "coherence", 9: "power spectral density",
    10: "energy spectral density", 12: "spectrum", 27: "order function",
}  # fmt: skip
AMPLITUDES = (0, 4, 12, 27)
"""Of these, what amplitudes can be read off."""
DIRECTIONS = ("", "x", "y", "z", "rx", "ry", "rz")
FREQUENCY, SPEED = 18, 19
"""What an abscissa is of."""


def read_universal(
    path: Path, engine_order: int, record: int | None, unit: str | None, force: float | None
) -> Points:
    """The points of a record."""
    size = regular(path, "a Universal File")
    if size > LARGEST:
        raise InputError(f"{path}: more than {LARGEST:,} bytes: at most that are read")
    with warnings.catch_warnings():  # the library changes the filters as it is imported
        pyuff = library("pyuff", "uff", str(path))
    read = partial(_sets, pyuff, path)
    records, units = by_library(read, str(path), size, "a Universal File")
    number, found = _chosen(path, records, record)
    where = f"{path}: record {number}"
    kind = int(found.get("func_type", 0))
    if kind not in AMPLITUDES:
        raise InputError(f"{where}: a {FUNCTIONS.get(kind, 'function')}, which has no amplitudes")
    count, said = len(np.atleast_1d(found["data"])), int(found.get("num_pts", -1))
    if count != said:
        raise InputError(f"{where}: {counted(said, 'point')} by its header, {count} are there")
    frequency = _frequency(found, engine_order, where)
    found_unit = _ordinate(found, units, unit, where)
    scale = _scale(found_unit, frequency, force, where)
    amplitude = scale * np.abs(np.asarray(found["data"]))
    known = np.isfinite(amplitude) & (frequency > 0)
    return Points(
        np.where(known, frequency, np.nan),
        np.where(known, amplitude, np.nan),
        STRAIN if found_unit.kind == STRAIN else DISPLACEMENT,
        scale,
    )


def _sets(pyuff: Any, path: Path) -> tuple[list[dict[str, Any]], dict[str, Any] | None]:
    """Function records, and the units of the file."""
    file = pyuff.UFF(str(path))
    kinds = np.asarray(file.get_set_types()).astype(int)
    if not (kinds == RECORD).any():
        held = ", ".join(map(str, dict.fromkeys(kinds.tolist()))) or "no data set"
        raise ValueError(f"no function record, data set {RECORD}: it holds {held}")
    units = [file.read_sets(int(i)) for i in np.flatnonzero(kinds == UNITS_OF_FILE)]
    records = [file.read_sets(int(i)) for i in np.flatnonzero(kinds == RECORD)]
    return records, units[0] if units else None


def _chosen(
    path: Path, records: Sequence[dict[str, Any]], record: int | None
) -> tuple[int, dict[str, Any]]:
    """The record that is wanted, and its number."""
    if record is None and len(records) == 1:
        record = 1
    if record is not None and 1 <= record <= len(records):
        return record, records[record - 1]
    some = [f"{i} ({_described(each)})" for i, each in enumerate(records[:MOST], 1)]
    if len(records) > MOST:
        some.append(f"... {len(records)}")
    wrong = f"several records: give {path.name}:1" if record is None else f"no record {record}"
    raise InputError(f"{path}: {wrong}: {', '.join(some)}")


def _described(record: dict[str, Any]) -> str:
    """A record in a few words: what it is, where, in which unit, and how many points."""
    what = FUNCTIONS.get(int(record.get("func_type", 0)), "function")
    places = [_dof(record, "rsp"), _dof(record, "ref")]
    label = str(record.get("ordinate_axis_units_lab", "")).strip()
    unit = f" in {label}" if label not in ("", "NONE") else ""
    points = len(np.atleast_1d(record["data"]))
    return printable(
        f"{what} {'/'.join(filter(None, places))}{unit}, {counted(points, 'point')}"[:80]
    )


def _dof(record: dict[str, Any], which: str) -> str:
    """Node and direction, such as "12+z"; "" where the record has none."""
    node, direction = (int(record.get(f"{which}_{of}", 0) or 0) for of in ("node", "dir"))
    sign = "-" if direction < 0 else "+"
    name = DIRECTIONS[abs(direction)] if abs(direction) < len(DIRECTIONS) else "?"
    return f"{node}{sign}{name}" if direction else ""


def _frequency(record: dict[str, Any], engine_order: int, where: str) -> Floats:
    """(p,) Hz."""
    kind = int(record.get("abscissa_spec_data_type", 0))
    label = str(record.get("abscissa_axis_units_lab", "")).strip()
    of = "speed" if kind == SPEED or (kind == 0 and label.lower() == "rpm") else "frequency"
    known = {name.lower(): value for name, value in UNITS[of].items()}
    if kind not in (0, FREQUENCY, SPEED):
        raise InputError(f"{where}: not over frequency or speed (abscissa of type {kind})")
    if kind == 0 and label.lower() not in known and int(record.get("func_type", 0)) == 0:
        raise InputError(f"{where}: does not say what it is over: needs frequency or speed")
    if int(record.get("abscissa_spacing", 0)):  # evenly: the library may be one too far
        steps = np.arange(len(np.atleast_1d(record["data"])))
        x = np.asarray(float(record["abscissa_min"]) + float(record["abscissa_inc"]) * steps)
    else:
        x = np.asarray(record["x"]).real.astype(float)
    x = known.get(label.lower(), 1.0) * x
    return x * engine_order / 60 if of == "speed" else x


def _scale(held: _RecordOrdinate, frequency: Floats, force: float | None, where: str) -> Floats:
    """(p,) displacement or strain of one unit of the ordinate."""
    if held.per_force and force is None:
        raise InputError(f"{where}: a response per force: give force, what it is multiplied by")
    if not held.per_force and force is not None:
        raise InputError(f"{where}: no response per force: leave out force")
    omega = TURN * np.where(frequency > 0, frequency, np.nan)
    scale = held.factor * (1.0 if force is None else force)
    return np.asarray(scale / omega ** DERIVATIVES[held.kind])
