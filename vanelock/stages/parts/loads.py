"""Loads at rest of a study's vane: gas forces and pressures, and growth against the casing.

Clamped flanges grow with the casing, as the rings beside it do. Measured from there the casing has
no thermal strain, and the vane that by which it would outgrow the casing:

    ε(x) = α_vane (T_vane(x) - T_ref) - α_casing (T_casing - T_ref).

A vane is reduced with each load in unit size, and scaled loads act on the system: neither other
loads nor other temperatures reduce anything again, but for those that a file holds, nor do limits
without them change.

Young's modulus of the parts at their temperatures.

What a study or a scene is excited with, in words: directions as they act, and resultants.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vanelock import fem
from vanelock.common.arrays import Floats, unit_vectors
from vanelock.common.errors import InputError
from vanelock.common.tables import counted
from vanelock.fem import Model
from vanelock.fem.loads import centroid, faces_of
from vanelock.input.cases.values import Problem, ring_of
from vanelock.input.schema.scene import Scene
from vanelock.input.schema.structure.loads import GAS, grows
from vanelock.input.schema.structure.temperature import PARTS
from vanelock.input.schema.study import Study
from vanelock.mesh import Part, VaneDimensions
from vanelock.mesh.files.nodal_field import nodal_field
from vanelock.mesh.geometry.aerofoil import aerofoil_faces
from vanelock.pipeline.cache import content_digest

if TYPE_CHECKING:
    from vanelock.stages.matrices.gather import Gathered

HEAT = "heat"


@dataclass(frozen=True)
class RestLoad:
    """A load at rest of a vane."""

    cause: str
    """Either "gas" or "heat"."""
    name: str
    """Which it is; with the digest of what its file holds."""
    size: float = 1.0
    """Times its unit: N, N m, Pa, thermal strain; of a field's 1, or the vane's expansion, 1/K."""
    faces: str = ""
    """Set that a pressure acts on."""
    file: str = ""
    """Of a field, which may be moved."""

    @property
    def unit(self) -> "RestLoad":
        """The same in unit size."""
        return replace(self, size=1.0)


def loads_of(study: Study) -> tuple[RestLoad, ...]:
    """Loads at rest of the vane of a study."""
    return (*_gas(study), *_heat(study))


def _gas(study: Study) -> Iterator[RestLoad]:
    if study.loads is None:
        return
    for name in GAS:
        if size := getattr(study.loads, name):
            yield RestLoad("gas", name, float(size))
    for faces, value in study.loads.pressure.items():
        if isinstance(value, str):
            name = f"pressure {content_digest(value)}"
            yield RestLoad("gas", f"{name} on {faces}", faces=faces, file=value)
        elif value:
            yield RestLoad("gas", f"pressure on {faces}", float(value), faces)


def _heat(study: Study) -> Iterator[RestLoad]:
    if not grows(study):
        return
    yield RestLoad(HEAT, HEAT, _uniform(study))
    if file := study.temperature.field:
        size = study.material.vane.expansion or 0.0
        yield RestLoad(HEAT, f"{HEAT} {content_digest(file)}", size, file=file)


def _uniform(study: Study) -> float:
    """Thermal strain over the casing's, that of a field of degC in the vane left out."""
    known, found = study.temperature, []
    for name in PARTS:
        at = 0.0 if name == "vane" and known.field else known.of(name, known.speed or 0.0)
        assert at is not None
        found.append(getattr(study.material, name).expansion * (at - known.reference))
    return float(found[0] - found[1])


def growth(study: Study, name: str, part: Part) -> float | Floats | None:
    """Thermal strain of a part over the casing's, (nodes,) where its temperature is a field.

    At the temperatures of the response; None where nothing grows.
    """
    if name == "casing" or not grows(study):
        return None
    whole, expansion = _uniform(study), study.material.vane.expansion
    if study.temperature.field is None or expansion is None:
        return whole
    return np.asarray(whole + expansion * _temperatures(study.temperature.field, part))


def _temperatures(file: str, part: Part) -> Floats:
    return nodal_field(Path(file), "temperature", "degC", part.points)


def unit_load(model: Model, dimensions: VaneDimensions | None, load: RestLoad) -> Floats:
    """Nodal loads (n,) of a unit: 1 N or 1 N m on each aerofoil, 1 Pa, thermal strain 1.

    Of a field of pressure in Pa, or of the thermal strain that a field of degC is for 1/K.
    """
    part, found = model.part, np.empty(0)
    if load.cause == HEAT:
        found = fem.thermal(model, _temperatures(load.file, part) if load.file else 1.0)
    elif load.faces:
        value: float | Floats = 1.0
        if load.file:
            value, on = np.zeros(len(part.points)), np.unique(faces_of(part, load.faces))
            value[on] = nodal_field(Path(load.file), "pressure", "Pa", part.points[on])
        found = fem.pressure(model, load.faces, value)
    else:
        assert dimensions is not None
        found = _on_aerofoils(model, dimensions, load.name)
    if load.file and content_digest(load.file) not in load.name:
        raise InputError(f"{load.file}: changed while it was read: run again")
    return found


def _on_aerofoils(model: Model, dimensions: VaneDimensions, name: str) -> Floats:
    found, none = np.zeros(model.K.shape[0]), np.zeros(3)
    for faces in aerofoil_faces(model.part, dimensions):
        x, y, _ = centroid(model, faces)
        radial, axial = np.array([x, y, 0.0]) / np.hypot(x, y), np.array([0.0, 0.0, 1.0])
        across = {"axial": axial, "tangential": np.cross(axial, radial)}
        moment = radial if name == "torque" else none
        found += fem.traction(model, faces, across.get(name, none), moment)
    return found


def strained(loads: Iterable[RestLoad]) -> tuple[str, ...]:
    """Names of those that grow with the modulus."""
    return tuple(load.name for load in loads if load.cause == HEAT)


def modulus(study: Study, part: str, speed: float | None = None) -> float:
    """Young's modulus of a part, Pa: at a rotor speed, rpm, or that of the study's response."""
    heat, metal = study.temperature, getattr(study.material, part)
    if getattr(heat, part) is None or not metal.moduli:
        return float(metal.modulus(heat.reference))
    speed = heat.speed if speed is None else speed
    if speed is None and isinstance(getattr(heat, part), tuple):
        raise InputError("temperature.speed: must be given: the temperatures depend on the speed")
    temperature = heat.of(part, 0.0 if speed is None else speed)
    assert temperature is not None
    return float(metal.modulus(temperature))


def reference(study: Study, part: str) -> float:
    """Young's modulus at which a part is reduced, Pa; other moduli scale what comes of it.

    With an accuracy that of the response, whose meshes and reductions are chosen by their errors.
    """
    if study.accuracy is not None:
        return modulus(study, part)
    return float(getattr(study.material, part).modulus(study.temperature.reference))


def described(study: Study) -> str:
    """What a run says of a study's temperatures; "" without any."""
    heat = study.temperature
    if not heat.given:
        return ""
    words = []
    for part in PARTS:
        E = f"E = {1e-9 * modulus(study, part):.5g} GPa"
        temperature = heat.of(part, heat.speed or 0.0)
        words.append(
            f"{part} {E}" if temperature is None else f"{part} {temperature:.4g} degC, {E}"
        )
    where = "" if heat.speed is None else f" at {heat.speed:,.0f} rpm"
    return f"temperatures of the response{where}: {'; '.join(words)}"


UNIT = 1e-9
"""Difference of a vector's length from 1 that is rounding."""


def load_lines(
    problem: Problem, nodes: int | None, lists: "Gathered | None" = None
) -> Iterator[str]:
    """A line for each load."""
    sectors, _ = ring_of(problem)
    if not isinstance(problem, Scene):
        if (force := problem.excitation.force_per_node) and nodes:
            yield f"excitation: {_each(force, nodes, sectors)}, radial"
        return
    if lists is None:
        return
    tables = {f"loads[{i}]": keys for i, keys in enumerate(problem.loads)}
    for load in lists.loads:
        keys = tables[load.where]
        direction = np.array(keys.direction, float)
        text = f"{load.where}: {_each(keys.amplitude or 0.0, len(load.nodes), sectors)}, along "
        text += _vector(unit_vectors(direction, load.where))
        if abs(np.linalg.norm(direction) - 1) > UNIT:
            text += f", the direction {_vector(direction)} at length 1"
        yield text
    for each in lists.forces:
        total = abs(each.factor) * each.forces.sum(axis=0)
        yield f"{each.where}: forces on {counted(len(each.nodes), 'node')}, sum {_vector(total)} N"


def _vector(values: Floats) -> str:
    return f"[{', '.join(f'{value:.4g}' for value in values.tolist())}]"


def _each(force: float, nodes: int, sectors: int) -> str:
    """A force on each of some nodes, and what it comes to."""
    text = f"{force:,.6g} N on {'each of ' if nodes > 1 else ''}{counted(nodes, 'node')}"
    if nodes > 1:
        text += f", {force * nodes:,.6g} N together"
    return text if sectors == 1 else f"{text}, {force * nodes * sectors:,.6g} N around the ring"
