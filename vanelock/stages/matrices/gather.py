"""What a scene file names, read: node lists, tables of pairs, contact frames, loads."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vanelock.common.arrays import Floats, Integers, unit_vectors
from vanelock.common.errors import InputError
from vanelock.common.quantities import bounds
from vanelock.fem.matrix_files import load_nodes
from vanelock.input.schema.scene import (
    GROUND,
    ContactKeys,
    ElementKeys,
    LoadKeys,
    Scene,
    TieKeys,
)
from vanelock.rom import Element
from vanelock.rom.joining.connections import Load, Output, Tie, Touching
from vanelock.stages.matrices.piece import NodalForces, read_forces, read_table

NUMBERS = ("kn", "kt", "mu", "interference")
COLUMNS = {
    **dict.fromkeys(("node", "mate"), ""),
    **dict.fromkeys(("nx", "ny", "nz"), "normal"),
    **dict.fromkeys(("tx", "ty", "tz"), "tangent"),
    **{key: key for key in NUMBERS},
}
"""Columns of a table of pairs, and the key that each stands in for."""
PARALLEL = 1e-6


def nodes(value: Any, where: str) -> Integers:
    """Node numbers from a list or a file."""
    if isinstance(value, str):
        return np.asarray(load_nodes(Path(value)))
    found = np.array(value, np.int64)
    if len(np.unique(found)) < len(found):
        raise InputError(f"{where}: a node is listed twice")
    return found


@dataclass(frozen=True)
class Gathered:
    """What a scene's lists and tables of nodes say.

    Attributes
    ----------
    contacts, ties, loads : tuples of Touching, Tie, Load
        What acts on the components; nonlinear elements follow the contacts.
    forces : tuple of NodalForces
        Loads from files.
    outputs : tuple of Output
        Output nodes; the loaded ones where none are named.
    components : tuple of str
    """

    contacts: tuple[Touching, ...]
    ties: tuple[Tie, ...]
    loads: tuple[Load, ...]
    forces: tuple[NodalForces, ...]
    outputs: tuple[Output, ...]
    components: tuple[str, ...]

    @cached_property
    def kept(self) -> dict[str, tuple[Integers, Integers]]:
        """By component: nodes that are named, and those of them whose rotations are kept."""
        joined: list[tuple[str, Touching | Tie, bool]]
        joined = [(f"{each.where}.between", each, False) for each in self.contacts]
        joined += [(f"ties.{each.name}.between", each, True) for each in self.ties]
        asked = [(where, *side, turns) for where, each, turns in joined for side in _sides(each)]
        asked += [(f"{each.where}.component", each.part, each.nodes, False) for each in self.loads]
        asked += [(f"{f.where}.component", f.part, f.nodes[:0], False) for f in self.forces]
        asked += [(each.where, each.part, each.nodes, False) for each in self.outputs]
        named: dict[str, set[int]] = {name: set() for name in self.components}
        turned: dict[str, set[int]] = {name: set() for name in self.components}
        for where, name, numbers, turns in asked:
            if name not in named:
                have = ", ".join(named)
                raise InputError(f'{where}: no component "{name}"; there are {have}')
            named[name].update(numbers.tolist())
            turned[name].update(numbers.tolist() if turns else ())
        rows, turns_of = (
            {name: np.array(sorted(numbers), np.int64) for name, numbers in each.items()}
            for each in (named, turned)
        )
        return {name: (rows[name], turns_of[name]) for name in self.components}

    def joining(self, name: str) -> Integers:
        """Nodes of a component that contacts, elements and ties join."""
        pairs: tuple[Touching | Tie, ...] = (*self.contacts, *self.ties)
        sides = [side for each in pairs for side in _sides(each)]
        ends = [own for part, own in sides if part == name]
        return np.unique(np.concatenate([np.empty(0, np.int64), *ends]))

    def followed(self, name: str) -> tuple[tuple[tuple[int, ...], ...], tuple[int, ...]]:
        """A component's loaded sets of nodes, and its output nodes, where nothing joins them."""
        joining = self.joining(name)
        sets = {tuple(load.nodes.tolist()): None for load in self.loads if load.part == name}
        shown = {n: None for each in self.outputs if each.part == name for n in each.nodes.tolist()}
        free = tuple(each for each in sets if not np.isin(each, joining).any())
        return free, tuple(n for n in shown if n not in joining)

    def forces_on(self, name: str) -> tuple[NodalForces, ...]:
        """A component's loads from files, one of each content."""
        found: dict[str, NodalForces] = {}
        for each in self.forces:
            if each.part == name:
                found.setdefault(each.digest, each)
        return tuple(found.values())

    def apart(self) -> Iterator[str]:
        """A line for each component that nothing joins to another, where there are several."""
        links = [(each.own_part, each.mate) for each in self.contacts]
        links += [(each.own_part, each.mate) for each in self.ties]
        joined = {name for own, mate in links for name in (own, mate) if mate and own != mate}
        for name in self.components if len(self.components) > 1 else ():
            if name not in joined:
                yield f"components.{name}: no contact or tie joins it to another component"


def _sides(pairs: Touching | Tie) -> list[tuple[str, Integers]]:
    """Components of pairs of nodes, and their nodes; the ground has none."""
    mate = [(pairs.mate, pairs.mate_nodes)] if pairs.mate else []
    return [(pairs.own_part, pairs.own_nodes), *mate]


def gathered(scene: Scene) -> Gathered:
    """Read what the scene names; a scene of a joined system names nothing."""
    if scene.system is not None:
        return Gathered((), (), (), (), (), ())
    contacts = (
        *(_touching(name, keys, scene) for name, keys in scene.contacts.items()),
        *(_elements(name, keys, scene) for name, keys in scene.elements.items()),
    )
    ties = tuple(_tie(name, keys) for name, keys in scene.ties.items())
    loads = tuple(_load(i, load) for i, load in enumerate(scene.loads) if load.file is None)
    forces = tuple(_forces(i, load) for i, load in enumerate(scene.loads) if load.file is not None)
    outputs = tuple(_outputs(scene, loads))
    found = Gathered(contacts, ties, loads, forces, outputs, tuple(scene.components))
    _ = found.kept  # refuses names of no component
    return found


def _outputs(scene: Scene, loads: Sequence[Load]) -> Iterator[Output]:
    found: dict[str, Integers] = {}
    for name, given in scene.outputs.nodes.items():
        found[name] = nodes(given, f"outputs.nodes.{name}")
    for load in loads if not found else ():
        every = [*found.get(load.part, ()), *load.nodes]
        found[load.part] = np.array(list(dict.fromkeys(every)), np.int64)
    turned = scene.ring.sectors > 1 and scene.ring.coordinates != "cylindrical"
    for name, own in found.items():
        yield Output(f"outputs.nodes.{name}", name, own, [f"{name} {n}" for n in own], turned)


def _ends(
    name: str, where: str, keys: ContactKeys | ElementKeys, scene: Scene
) -> tuple[dict[str, Any], Mapping[str, Any]]:
    """What keys say of both ends of contacts or elements, and the other columns of their pairs."""
    own, mate = keys.between or ("", "")
    if own == GROUND:
        raise InputError(f'{where}.between: "{GROUND}" goes second')
    if keys.next_sector and scene.ring.sectors < 2:
        raise InputError(f"{where}.next_sector: needs ring.sectors of at least 2")
    if keys.next_sector and mate == GROUND:
        raise InputError(f"{where}.next_sector: {GROUND} has no sectors")
    mine, theirs, table = _pairs(keys.pairs, mate == GROUND, f"{where}.pairs")
    found = {
        "name": name,
        "own_part": own,
        "mate": "" if mate == GROUND else mate,
        "own_nodes": mine,
        "mate_nodes": theirs,
        "next_sector": keys.next_sector,
    }
    return found, table


def _elements(name: str, keys: ElementKeys, scene: Scene) -> Touching:
    """Nonlinear elements, which act along their first direction alone."""
    where = f"elements.{name}"
    if name in scene.contacts:
        raise InputError(f"{where}: contacts have that name already")
    ends, table = _ends(name, where, keys, scene)
    count = len(ends["own_nodes"])
    if more := [column for column in table if column not in ("node", "mate")]:
        raise InputError(f"{keys.pairs}: column {more[0]!r}: an element has node and mate only")
    frames = np.zeros((count, 3, 3))
    frames[:, 0] = unit_vectors(np.array(keys.direction, float), f"{where}.direction")
    try:
        element = Element(force=keys.law, places=[0], parameters=keys.parameters, name=name)
    except InputError as error:
        raise InputError(f"{where}: {str(error).partition(': ')[2]}") from None
    still = np.zeros(count)
    return Touching(
        **ends,
        frames=frames,
        kn=np.ones(count),  # joining gives them the structure's own
        kt=np.ones((count, 2)),
        mu=still,
        interference=still,
        element=element,
    )


def _touching(name: str, keys: ContactKeys, scene: Scene) -> Touching:
    where = f"contacts.{name}"
    ends, table = _ends(name, where, keys, scene)
    count = len(ends["own_nodes"])
    for column, key in COLUMNS.items():
        if key and column in table and getattr(keys, key) is not None:
            raise InputError(f"{where}.{key}: {keys.pairs} has it too: give either")
    numbers: dict[str, Any] = {key: _each(table, keys, key, count, where) for key in NUMBERS}
    for key, values in numbers.items():
        _refuse_outside(f"{where}.pairs", key, values, keys.pairs)
    frames = _frames(table, keys, count, where)
    _refuse_twice(where, ends["own_nodes"], ends["mate_nodes"], frames[:, 0])
    both = np.column_stack([numbers["kt"]] * 2)
    return Touching(**ends, frames=frames, **{**numbers, "kt": both})


def _refuse_outside(where: str, key: str, values: Floats, source: Any) -> None:
    """What a column holds must be what the key of its name may be."""
    field = ContactKeys.model_fields[key]
    allowed, unit = bounds(field), (field.description or "").partition(" [")[2].rstrip("]")
    high_enough = values > allowed.low if allowed.above else values >= allowed.low
    if np.any(wrong := ~(high_enough & (values <= allowed.high))):
        least = f"{'>' if allowed.above else '>='} {allowed.low:g}"
        text = f"must be {least} and <= {allowed.high:g} {unit}".rstrip()
        raise InputError(f"{where}: {key} = {values[wrong][0]:g} in {source}: {text}")


def _refuse_twice(where: str, mine: Integers, theirs: Integers, normal: Floats) -> None:
    """Two elements between the same nodes along the same normal are a slip of the pen."""
    seen = set()
    for a, b, n in zip(mine.tolist(), theirs.tolist(), normal.round(6).tolist(), strict=True):
        if (a, b, *n) in seen:
            text = f"node {a}" if a == b else f"pair {a}, {b}"
            raise InputError(f"{where}.pairs: {text} is listed twice with the same normal")
        seen.add((a, b, *n))


def _tie(name: str, keys: TieKeys) -> Tie:
    mine, theirs, table = _pairs(keys.pairs, False, f"ties.{name}.pairs")
    if more := [column for column in table if column not in ("node", "mate")]:
        raise InputError(f"{keys.pairs}: column {more[0]!r}: a tie has node and mate only")
    own, mate = keys.between
    return Tie(name, own, mate, mine, theirs)


def _load(i: int, load: LoadKeys) -> Load:
    assert load.amplitude is not None
    where = f"loads[{i}]"
    direction = unit_vectors(np.array(load.direction, float), f"{where}.direction")
    vector = np.asarray(load.amplitude * _phase(where, load) * direction, complex)
    return Load(where, load.component, nodes(load.nodes, f"{where}.nodes"), vector, load.harmonic)


def _forces(i: int, load: LoadKeys) -> NodalForces:
    where, factor = f"loads[{i}]", load.scale * _phase(f"loads[{i}]", load)
    try:
        digest, listed, forces = read_forces(Path(str(load.file)))
    except InputError as error:
        raise InputError(f"{where}.file: {error}") from None
    return NodalForces(where, load.component, digest, listed, forces, factor, load.harmonic)


def _phase(where: str, load: LoadKeys) -> complex:
    if load.harmonic == 0 and load.phase:
        raise InputError(f"{where}.phase: a static load (harmonic = 0) has none")
    return complex(np.exp(1j * np.deg2rad(load.phase)))


def _pairs(value: Any, alone: bool, where: str) -> tuple[Integers, Integers, Mapping[str, Any]]:
    """Nodes, their mates, and the table's other columns."""
    if isinstance(value, str) and alone and value.lower().endswith(".txt"):
        value = load_nodes(Path(value)).tolist()
    if isinstance(value, str):
        wanted = ("node",) if alone else ("node", "mate")
        table = read_table(Path(value), COLUMNS, wanted)
        mine = np.asarray(table["node"])
        return mine, mine if alone else np.asarray(table["mate"]), table
    rows = np.array(value, np.int64)
    if alone != (rows.ndim == 1):
        needed = "node numbers, such as [17, 18]" if alone else "pairs, such as [[17, 4], [18, 5]]"
        raise InputError(f"{where}: expected {needed}")
    return (rows, rows, {}) if alone else (rows[:, 0], rows[:, 1], {})


def _each(table: Mapping[str, Any], keys: ContactKeys, key: str, count: int, where: str) -> Floats:
    """(c,) a property of each pair, from the table or the key; without either no interference."""
    if key in table:
        return np.asarray(table[key], float)
    value = getattr(keys, key)
    if value is None and key == "interference":
        value = 0.0
    if value is None:
        raise InputError(f"{where}.{key}: must be given, here or as a column of its pairs")
    return np.full(count, float(value))


def _frames(table: Mapping[str, Any], keys: ContactKeys, count: int, where: str) -> Floats:
    """(c, 3, 3) unit normal and tangents of each pair; without a tangent, across the normal."""
    normal = _vectors(table, keys.normal, "n", count)
    if normal is None:
        raise InputError(f"{where}.normal: must be given, here or as columns nx, ny, nz")
    normal = unit_vectors(normal, f"{where}.normal")
    tangent = _vectors(table, keys.tangent, "t", count)
    if tangent is None:  # the axis furthest from the normal
        tangent = np.eye(3)[np.abs(normal).argmin(axis=1)]
    tangent = unit_vectors(tangent, f"{where}.tangent")
    across = tangent - np.sum(tangent * normal, axis=1)[:, None] * normal
    left = np.linalg.norm(across, axis=1)
    if np.any(left <= PARALLEL):
        raise InputError(f"{where}.tangent: must not be along the normal")
    t1 = across / left[:, None]
    return np.stack([normal, t1, np.cross(normal, t1)], axis=1)


def _vectors(table: Mapping[str, Any], key: Any, letter: str, count: int) -> Floats | None:
    columns = [f"{letter}{axis}" for axis in "xyz"]
    if any(column in table for column in columns):
        none = np.zeros(count)
        return np.column_stack([np.asarray(table.get(c, none), float) for c in columns])
    return None if key is None else np.tile(np.array(key, float), (count, 1))
