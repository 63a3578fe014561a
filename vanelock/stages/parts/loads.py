"""Loads at rest of a study's vane: gas forces and pressures, and growth against the casing.

Clamped flanges grow with the casing, as the rings beside it do. Measured from there the casing has
no thermal strain, and the vane that by which it would outgrow the casing:

    ε(x) = α_vane (T_vane(x) - T_ref) - α_casing (T_casing - T_ref).

A vane is reduced with each load in unit size, and scaled loads act on the system: neither other
loads nor other temperatures reduce anything again, but for those that a file holds, nor do limits
without them change.

Young's modulus of the parts at their temperatures.

A field over a part's surface, such as a flow's pressure, comes from a CSV file of points:

    x (mm), y (mm), z (mm), pressure (kPa)

The first line that is not blank and does not begin with # names the columns, in whatever order and
with units, of which SI is meant where there is none. Between points: the mean of the nearest, the
nearer the more (D. Shepard, A two-dimensional interpolation function for irregularly-spaced data,
Proceedings of the 23rd ACM National Conference 1968, 517-524).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from vanelock import fem
from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import rows_of_cells
from vanelock.common.files.digests import content_digest
from vanelock.common.files.files import contents
from vanelock.common.quantities import si
from vanelock.fem import Model
from vanelock.fem.loads import centroid, faces_of
from vanelock.input.schema.structure.loads import GAS, grows
from vanelock.input.schema.structure.temperature import PARTS
from vanelock.input.schema.study import Study
from vanelock.mesh import Part, VaneDimensions
from vanelock.mesh.cells import exterior, solid

HEAT = "heat"
_NEAREST = 4  # points whose mean is taken
_FAR = 0.1  # distance of a node from the nearest point, over the nodes' extent, that is refused
_ON = 1e-5  # nodes lie on a shroud's surface within this, m


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
    return _nodal_field(Path(file), "temperature", "degC", part.points)


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
            value[on] = _nodal_field(Path(load.file), "pressure", "Pa", part.points[on])
        found = fem.pressure(model, load.faces, value)
    else:
        assert dimensions is not None
        found = _on_aerofoils(model, dimensions, load.name)
    if load.file and content_digest(load.file) not in load.name:
        raise InputError(f"{load.file}: changed while it was read: run again")
    return found


def _on_aerofoils(model: Model, dimensions: VaneDimensions, name: str) -> Floats:
    found, none = np.zeros(model.K.shape[0]), np.zeros(3)
    for faces in _aerofoil_faces(model.part, dimensions):
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


def _nodal_field(path: Path, name: str, unit: str, places: Floats) -> Floats:
    """Values of a field at nodes."""
    columns = {"x": "m", "y": "m", "z": "m", name: unit}
    table = _numbers(path, columns)
    points, values = table[:, :3], table[:, 3]
    distance, near = KDTree(points).query(places, min(_NEAREST, len(points)))
    distance, near = (np.reshape(each, (len(places), -1)) for each in (distance, near))
    extent = float(np.linalg.norm(np.ptp(places, axis=0)))
    if (worst := int(np.argmax(distance[:, 0]))) >= 0 and distance[worst, 0] > _FAR * extent:
        where = ", ".join(f"{1e3 * each:.4g}" for each in places[worst])
        raise InputError(
            f"{path}: the node at {where} mm lies {1e3 * distance[worst, 0]:.3g} mm from the "
            "nearest point: are the units and axes those of the mesh?"
        )
    weight = 1 / np.maximum(distance, 1e-9 * (extent or 1.0)) ** 2
    return np.asarray((weight * values[near]).sum(axis=1) / weight.sum(axis=1))


def _numbers(path: Path, columns: dict[str, str]) -> Floats:
    """(p, len(columns)) numbers of the columns, in their units."""
    try:
        text = contents(path, "a CSV file").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None
    lines = rows_of_cells(text)
    if len(lines) < 2:
        raise InputError(f"{path}: needs a line of names and one of numbers at least")
    (number, heads), *rows = lines
    where, scales = f"{path}: line {number}", []
    named = [head.replace("[", "(").partition("(") for head in heads]
    names = [each[0].strip().lower() for each in named]
    for name, unit in columns.items():
        if names.count(name) != 1:
            needed = ", ".join(f"{each} ({own})" for each, own in columns.items())
            raise InputError(f"{where}: {names.count(name)} columns {name}: needed are {needed}")
        given = named[names.index(name)][2].rstrip("]) ") or unit
        try:
            of = [n if given == unit else si(f"{n} {given}", unit) for n in (0, 1)]
        except ValueError:
            raise InputError(f"{where}: {name} ({given}): not a unit like {unit}") from None
        scales.append(np.array(of, float))
    order = [names.index(name) for name in columns]
    numbers = np.empty((len(rows), len(order)))
    for k, (i, row) in enumerate(rows):
        try:
            numbers[k] = [float(row[j]) for j in order]
        except (ValueError, IndexError):
            raise InputError(f"{path}: line {i}: needs a number in each column") from None
    if not np.isfinite(numbers).all():
        bad = rows[int(np.flatnonzero(~np.isfinite(numbers).all(axis=1))[0])][0]
        raise InputError(f"{path}: line {bad}: numbers must be finite")
    none, one = np.array(scales).T
    return np.asarray(numbers * (one - none) + none)


def _aerofoil_faces(part: Part, dimensions: VaneDimensions) -> tuple[Integers, ...]:
    """(f, 6) nodes of the faces of each aerofoil, by ascending angle, root fillets included."""
    inner, outer = dimensions.inner_shroud_outer_radius, dimensions.outer_shroud_inner_radius
    faces = exterior(part.cells, solid(part.cell_type))
    radius = np.hypot(*part.points.T[:2])[faces]
    between = ((radius > inner - _ON) & (radius < outer + _ON)).all(axis=1)
    shroud = (radius < inner + _ON).all(axis=1) | (radius > outer - _ON).all(axis=1)
    faces = faces[between & ~shroud]
    rows = np.repeat(np.arange(len(faces)), faces.shape[1])
    shape = len(faces), len(part.points)
    touches = csr_array((np.ones(faces.size), (rows, faces.ravel())), shape=shape)
    count, piece = connected_components(touches @ touches.T, directed=False)
    if count != dimensions.aerofoils:
        raise InputError(f"{part.name}: {count} surfaces between the shrouds, not one an aerofoil")
    middle = [part.points[faces[piece == i, :3]].mean(axis=(0, 1)) for i in range(count)]
    order = np.argsort([np.arctan2(y, x) for x, y, _ in middle])
    return tuple(faces[piece == i] for i in order)
