"""What a function record's numbers are of, and their unit in SI."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vanelock.common.errors import InputError, printable
from vanelock.common.quantities import si
from vanelock.input.measured.units import DISPLACEMENT, STRAIN, STRAINS

NAMES = {3: STRAIN, 8: DISPLACEMENT, 11: "velocity", 12: "acceleration"}
"""Types of an ordinate, by the format's numbers; 0 and 1 say none."""
DERIVATIVES = {STRAIN: 0, DISPLACEMENT: 0, "velocity": 1, "acceleration": 2}
SI_UNITS = {STRAIN: "", DISPLACEMENT: "m", "velocity": "m/s", "acceleration": "m/s^2"}
FORCES = (9, 13)
"""Types of a denominator: a reaction, or the force of excitation."""
GRAVITY = 9.80665
ALIKE = 1e-3
"""Relative difference of two units that are meant to be the same."""


@dataclass(frozen=True)
class Ordinate:
    """What a record holds.

    Attributes
    ----------
    kind : str
        "displacement", "velocity", "acceleration" or "strain".
    factor : float
        What one unit is in SI: m, m/s, m/s² or 1, over N where it is per force.
    per_force : bool
    """

    kind: str
    factor: float
    per_force: bool

    @property
    def derivative(self) -> int:
        """How often it is differentiated in time."""
        return DERIVATIVES[self.kind]


def ordinate(
    record: Mapping[str, Any], units: Mapping[str, Any] | None, given: str | None, where: str
) -> Ordinate:
    """What a record is of: by the unit that the study gives, else by the file.

    The file says it twice, by a label and by the system of units of its data set 164, and where
    the two do not agree the study has to.
    """
    kind = int(record.get("ordinate_spec_data_type", 0))
    below = int(record.get("orddenom_spec_data_type", 0))
    label, under = (_label(record, of) for of in ("ordinate", "orddenom"))
    if below not in (0, 1, *FORCES):
        raise InputError(f"{where}: over a quantity of type {below}: only force can be below")
    text = given or label
    if kind not in (0, 1, *NAMES):
        raise InputError(f"{where}: of type {kind}: {', '.join(SI_UNITS)} can be read")
    name = NAMES.get(kind)
    per_force = below in FORCES or text.endswith("/N")
    numerator = re.sub(r"^\((.*)\)$", r"\1", text.removesuffix("/N"))
    known = _labelled(name, numerator, where, bool(given))
    if known is None:
        if units is None or name is None:
            raise InputError(f'{where}: says no unit: give unit, such as "um" or "m/s^2/N"')
        known = name, _of_system(name, units)
    elif not given and units is not None:
        other = _of_system(known[0], units)
        if known[0] != STRAIN and abs(known[1] / other - 1) > ALIKE:
            raise InputError(
                f"{where}: in {printable(label)} by its label, in {other:g} "
                f"{SI_UNITS[known[0]]} by the file's units (data set 164): give unit"
            )
    force = _newtons(under, units, where) if below in FORCES and not given else 1.0
    return Ordinate(known[0], known[1] / force, per_force)


def _label(record: Mapping[str, Any], of: str) -> str:
    """The unit that an axis is labelled with, as a library of units reads it."""
    text = str(record.get(f"{of}_axis_units_lab", "") or "").strip().replace("**", "^")
    text = re.sub(r"\bs(ec)?2\b", "s^2", text.replace(" ", ""))
    return "" if text.upper() in ("NONE", "UNKNOWN") else text


def _labelled(name: str | None, unit: str, where: str, given: bool) -> tuple[str, float] | None:
    """Kind and SI value of a unit that is written; None where there is none."""
    if not unit:
        return None
    for kind in SI_UNITS if name is None else (name,):
        try:
            return kind, _si(unit, kind)
        except ValueError:
            continue
    meant = ", ".join(filter(None, SI_UNITS.values())) if name is None else SI_UNITS[name] or "um/m"
    origin = "unit" if given else "label"
    raise InputError(f'{where}: {origin} "{printable(unit)}": expected one like {meant}')


def _si(unit: str, kind: str) -> float:
    """SI value of one unit of a kind."""
    if kind == STRAIN and unit in STRAINS:
        return STRAINS[unit]
    if kind == "acceleration" and unit in ("g", "gn", "G"):
        return GRAVITY
    return float(si(f"1 {unit}", SI_UNITS[kind] or "dimensionless"))  # type: ignore[arg-type]


def _of_system(kind: str, units: Mapping[str, Any]) -> float:
    """SI value of one unit of a kind in the file's system of units, whose factors lead there."""
    return 1.0 if kind == STRAIN else 1.0 / float(units["length"])


def _newtons(label: str, units: Mapping[str, Any] | None, where: str) -> float:
    """Newtons in one unit of the force below."""
    if label:
        try:
            return float(si(f"1 {label}", "N"))  # type: ignore[arg-type]
        except ValueError:
            raise InputError(f'{where}: over "{printable(label)}": expected a force') from None
    return 1.0 if units is None else 1.0 / float(units["force"])
