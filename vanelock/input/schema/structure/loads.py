"""Loads at rest of a study: gas forces on the aerofoils, and what thermal growth needs."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from vanelock.common.checked import Check, Location, value_in
from vanelock.common.errors import printable
from vanelock.common.quantities import Force, number_within, quantity
from vanelock.input.schema.structure.own_mesh import OwnVane
from vanelock.input.schema.structure.structure import KeyTable

GAS = ("axial", "tangential", "torque")


def _is_field(value: object) -> bool:
    """Whether a value is the name of a CSV file."""
    return isinstance(value, str) and value.lower().endswith(".csv")


def _pressure(value: object) -> object:
    """A pressure in Pa, or the name of a CSV file."""
    if _is_field(value):
        return value
    needed = (
        'expected a pressure of at most 1e9 Pa, such as "0.2 MPa", or a CSV file of x, y, z '
        "and pressure"
    )
    return number_within(value, "Pa", -1e9, 1e9, needed)


Pressed = Annotated[Any, BeforeValidator(_pressure)]


class RestLoadKeys(KeyTable):
    """Mean gas loads: the same on each aerofoil of a segment, or pressures on sets of a mesh."""

    axial: Force | None = Field(
        default=None, ge=-1e6, le=1e6, description="axial gas force on an aerofoil [N]"
    )
    tangential: Force | None = Field(
        default=None, ge=-1e6, le=1e6, description="circumferential gas force on an aerofoil [N]"
    )
    torque: Annotated[float, quantity("N*m")] | None = Field(
        default=None, ge=-1e5, le=1e5, description="gas moment on an aerofoil [N*m]"
    )
    pressure: dict[str, Pressed] = Field(
        default={}, description="mean pressure on the faces of a set of vane.mesh [Pa]"
    )


def files_named(data: Mapping[str, Any]) -> Iterator[tuple[Location, str]]:
    """Each key of a study's tables that names a file, and the file.

    What is no name is left out, for the schema to refuse.
    """
    measured, pressure = data.get("measured"), value_in(data, ("loads", "pressure"))
    keys: list[Location] = [("vane", "mesh"), ("casing", "mesh")]
    keys += [("temperature", "field"), ("measured", "file")]
    if isinstance(measured, list | tuple):
        keys += [("measured", i, "file") for i in range(len(measured))]
    if isinstance(pressure, dict):
        keys += [("loads", "pressure", name) for name in pressure if _is_field(pressure[name])]
    for key in keys:
        value = value_in(data, key)
        if value and isinstance(value, str):
            yield key, value


def _of_aerofoils_or_sets(study: Any) -> Iterator[str]:
    """A vane of dimensions has aerofoils, one from a mesh has sets."""
    if (keys := study.loads) is None:
        return
    own = isinstance(study.vane, OwnVane)
    for name in GAS:
        if own and (value := getattr(keys, name)) is not None:
            yield (
                f"loads.{name} = {value:g}: needs aerofoils by dimensions, while vane.mesh is "
                "given: give loads.pressure on its sets"
            )
    for name in keys.pressure:
        where = f'loads.pressure."{printable(name)}"'
        if not name or "/" in name:
            yield f"{where}: a set's name must not be empty or have a /"
        if not own:
            yield (
                f"{where}: needs vane.mesh, which has such sets: of aerofoils by dimensions give "
                f"loads.{', loads.'.join(GAS)}"
            )


def _has_no_estimate(study: Any) -> Iterator[str]:
    given = "loads" if study.loads is not None else ""
    given = given or ("material.vane.expansion" if grows(study) else "")
    if study.accuracy is not None and given:
        yield f"accuracy = {study.accuracy:g}: {given}: loads at rest have no estimate of errors"


def _grows_in_both(study: Any) -> Iterator[str]:
    """Thermal growth is that of the vane over the casing's: both must be known."""
    known, metal = study.temperature, study.material
    parts = [part for part in ("vane", "casing") if getattr(metal, part).expansion]
    lacking = [f"material.{p}.expansion" for p in ("vane", "casing") if p not in parts]
    if known.field is not None:
        if lacking:
            yield f"temperature.field: needs {' and '.join(lacking)}"
        if isinstance(known.vane, tuple):
            yield "temperature.field: is that of one speed, while temperature.vane has several"
    if known.vane is None and known.field is None:
        lacking.append("temperature.vane")
    if known.casing is None:
        lacking.append("temperature.casing")
    if parts and lacking:
        value = getattr(metal, parts[0]).expansion
        yield (
            f"material.{parts[0]}.expansion = {value:g}: needs {' and '.join(lacking)}: the vane "
            "grows against the casing"
        )


def grows(study: Any) -> bool:
    """Whether a `Study` has thermal growth."""
    return bool(study.material.vane.expansion or study.material.casing.expansion)


LOAD_CHECKS: tuple[Check, ...] = (_of_aerofoils_or_sets, _has_no_estimate, _grows_in_both)
"""Of a `Study`."""
