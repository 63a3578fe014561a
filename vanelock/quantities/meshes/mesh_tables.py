"""Tables of a study's meshes: their figures, the counts of their sets, how well the parts match."""

import csv
from collections.abc import Mapping
from io import StringIO

import numpy as np

from vanelock.common.cyclic import turn
from vanelock.common.tables import Cell, Column, Table, heads
from vanelock.mesh import Part
from vanelock.quantities.meshes.quality import Figures

SETS = (
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
    found: Mapping[str, Figures],
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
        for name, f in found.items()
    ]
    dofs = sum(f.dofs for f in found.values())
    notes = (f"Degrees of freedom of both parts: {dofs:,}.",)
    return Table("Meshes", columns, rows, notes, "quality")


def sets_table(parts: Mapping[str, Part], face_nodes: int | None) -> Table:
    """Number of nodes in every set of every part, and how well they match."""
    names = [name for name in SETS if any(name in part.node_sets for part in parts.values())]
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


def _match(what: str, one: Part, own: str, other: Part, mate: str, turned: bool = False) -> str:
    """Largest distance between the nodes of two sets, the first turned by a sector if asked."""
    if own not in one.node_sets or mate not in other.node_sets:
        return ""
    here, there = one.points[one.node_sets[own]], other.points[other.node_sets[mate]]
    if here.shape != there.shape:
        return f"{what} {len(here)} against {len(there)} NODES"
    if turned:
        here = here @ turn(one.sectors).T
    return f"{what} {np.linalg.norm(here - there, axis=1).max(initial=0):.1e} m"


def csv_text(table: Table) -> str:
    """A table as comma-separated values: its columns' names for machines, then its rows."""
    written = StringIO()
    writer = csv.writer(written, lineterminator="\n")
    writer.writerow(column.name for column in table.columns)
    writer.writerows(["" if cell is None else cell for cell in row] for row in table.shown)
    return written.getvalue()
