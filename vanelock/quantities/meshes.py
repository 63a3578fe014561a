"""Tables of a study's meshes, and figures that show whether these can be trusted."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from vanelock import mesh
from vanelock.common.arrays import Floats
from vanelock.common.cyclic import turn
from vanelock.common.tables import Cell, Column, Table, heads
from vanelock.fem.elements import reference_element
from vanelock.mesh import Part
from vanelock.mesh.cells import REGULAR, inverse_condition, linear_type, solid

_PAIRS: Final = {  # corners at the ends of each edge
    "tetra": [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [(i, (i + 1) % 4) for i in range(4)]
    + [(4 + i, 4 + (i + 1) % 4) for i in range(4)]
    + [(i, i + 4) for i in range(4)],
}


@dataclass(frozen=True)
class Figures:
    """Figures of a mesh.

    Attributes
    ----------
    nodes, elements : int
        Counts.
    cell_type : str
        meshio's name of the element type.
    volume : float
        Sum over the elements, m³.
    smallest_jacobian : float
        Smallest determinant of the map from the reference element, over that of a straight-sided
        tetrahedron (`mesh.quality`'s bound), or at a hexahedron's nodes over its mean. Positive in
        a valid mesh.
    sicn : (3,) float
        Signed inverse condition number of the element that the corners span, at the worst corner:
        the smallest of all elements, the one that 1 % of them stay below, and their median. 1 is
        perfect.
    largest_edge : float
        Longest distance between the ends of an element's edge, m.
    """

    nodes: int
    elements: int
    cell_type: str
    volume: float
    smallest_jacobian: float
    sicn: tuple[float, float, float]
    largest_edge: float

    @property
    def dofs(self) -> int:
        """Degrees of freedom."""
        return 3 * self.nodes


def figures(part: Part) -> Figures:
    """Figures of a part of tetrahedra or hexahedra, linear or quadratic."""
    kind, reference = linear_type(part.cell_type), reference_element(part.cell_type)
    weighed = np.linalg.det(_jacobians(part, reference.gradients)) * reference.weights
    corners = solid(kind).functions(solid(kind).nodes)[1]
    perfect = REGULAR if kind == "tetra" else np.eye(3)
    worst = inverse_condition(_jacobians(part, corners), perfect).min(axis=1)
    if kind == "tetra":
        smallest = mesh.quality(part).smallest_jacobian
    else:
        cell = solid(part.cell_type)
        at_nodes = _jacobians(part, cell.functions(cell.nodes)[1])
        mean = weighed.sum(axis=1) / reference.weights.sum()
        smallest = float((np.linalg.det(at_nodes) / mean[:, None]).min())
    first, second = part.cells[:, np.array(_PAIRS[kind])].transpose(2, 0, 1)
    edges = np.linalg.norm(part.points[first] - part.points[second], axis=-1)
    return Figures(
        nodes=len(part.points),
        elements=len(part.cells),
        cell_type=part.cell_type,
        volume=float(weighed.sum()),
        smallest_jacobian=smallest,
        sicn=(float(worst.min()), float(np.quantile(worst, 0.01)), float(np.median(worst))),
        largest_edge=float(edges.max()),
    )


def _jacobians(part: Part, gradients: Floats) -> Floats:
    """Derivative of place by reference coordinates, (e, q, 3, 3) m, from gradients (q, k, 3).

    Of the elements, or with the gradients of fewer nodes of those that the first k nodes span.
    """
    points = part.points[part.cells[:, : gradients.shape[1]]]
    return np.asarray(np.einsum("eia,qib->eqab", points, gradients, optimize=True))


_SETS = (
    "left",
    "right",
    "fixed",
    "hook_front",
    "hook_rear",
    "key",
    "interlock_left",
    "interlock_right",
    "force",
    "output",
)
"""Order of the sets in tables; others follow."""


def quality_table(
    parts: Mapping[str, Part],
    figures: Mapping[str, Figures],
    densities: Mapping[str, float],
    seconds: Mapping[str, float],
) -> Table:
    """A line for each part; mass from its density, kg/m³, and what meshing took, s."""
    columns = (
        *heads("part", "nodes", "dofs", "elements"),
        Column("type", key="cell_type"),
        Column("volume", "cm³", ".2f", "volume_cm3"),
        Column(
            "volume error",
            form="+.0e",
            key="against_cad",
            note="volume error: relative to the geometry that was meshed",
        ),
        Column("mass", "kg", key="mass_kg"),
        Column(
            "smallest Jacobian",
            form=".3g",
            key="smallest_jacobian",
            note="Jacobian: smallest over that of an element with straight sides",
        ),
        Column(
            "SICN min",
            form=".3f",
            key="sicn_min",
            note="SICN: signed inverse condition number, 1 for a perfect element; of all elements",
        ),
        Column("1 %", form=".3f", key="sicn_1_percent"),
        Column("median", form=".3f", key="sicn_median"),
        Column("largest edge", "mm", ".1f", "largest_edge_mm"),
        Column("meshed in", "s", ".1f", "seconds"),
    )
    rows: list[tuple[Cell, ...]] = [
        (
            name,
            f.nodes,
            f.dofs,
            f.elements,
            f.cell_type,
            f.volume,
            None if (cad := parts[name].cad_volume) is None else f.volume / cad - 1,
            densities[name] * f.volume,
            f.smallest_jacobian,
            *f.sicn,
            f.largest_edge,
            seconds[name],
        )
        for name, f in figures.items()
    ]
    dofs = sum(f.dofs for f in figures.values())
    notes = (f"Degrees of freedom of both parts: {dofs:,}.",)
    return Table("Meshes", columns, rows, notes, "quality")


def sets_table(parts: Mapping[str, Part], face_nodes: int | None) -> Table:
    """Number of nodes in every set of every part, and how well they match."""
    names = [name for name in _SETS if any(name in part.node_sets for part in parts.values())]
    every = {name for part in parts.values() for name in part.node_sets}
    names += sorted(every.difference(names))
    rows = []
    for name in names:
        held = (part.node_sets.get(name) for part in parts.values())
        rows.append((name, *(None if nodes is None else len(nodes) for nodes in held)))
    return Table("Node sets", heads("set", *parts), rows, _notes(parts, face_nodes), "sets")


def _notes(parts: Mapping[str, Part], face_nodes: int | None) -> list[str]:
    vane, casing = parts["vane"], parts["casing"]
    hooks = sum(
        len(np.setdiff1d(vane.node_sets[name], vane.node_sets.get("key", [])))
        for name in ("hook_front", "hook_rear")
        if name in vane.node_sets
    )
    interlock = len(vane.node_sets.get("interlock_left", ()))
    notes = [f"Contact pairs: {hooks} hook + {interlock} interlock = {hooks + interlock}."]
    if face_nodes is not None:
        count = len(casing.node_sets["left"])
        met = "as asked for" if count == face_nodes else f"mesh.face_nodes asked for {face_nodes}"
        notes.append(f"Nodes on each cyclic face of the casing: {count}, {met}.")
    matches = [
        _match("cyclic faces of the casing", casing, "left", casing, "right", turned=True),
        _match("interlock faces", vane, "interlock_left", vane, "interlock_right", turned=True),
        _match("front hook, vane on casing", vane, "hook_front", casing, "hook_front"),
        _match("rear hook, vane on casing", vane, "hook_rear", casing, "hook_rear"),
    ]
    found = "; ".join(match for match in matches if match)
    return [*notes, f"Largest distance of nodes that meet: {found}."] if found else notes


def _match(
    what: str, one: Part, node_set: str, other: Part, mate: str, turned: bool = False
) -> str:
    """Largest distance between the nodes of two sets, the first turned by a sector if asked."""
    if node_set not in one.node_sets or mate not in other.node_sets:
        return ""
    here, there = one.points[one.node_sets[node_set]], other.points[other.node_sets[mate]]
    if here.shape != there.shape:
        return f"{what} {len(here)} against {len(there)} NODES"
    if turned:
        here = here @ turn(one.sectors).T
    return f"{what} {np.linalg.norm(here - there, axis=1).max(initial=0):.1e} m"
