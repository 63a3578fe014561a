"""Tables of a study's meshes: their figures, the counts of their sets, how well the parts match."""

import csv
from collections.abc import Mapping
from io import StringIO

import numpy as np

from vanelock.common.cyclic import turn
from vanelock.mesh import Part
from vanelock.pipeline.tables import Cell, Column, Table
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
    "accessory",
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
        Column("part", "part"),
        Column("nodes", "nodes", ",d"),
        Column("dofs", "dofs", ",d"),
        Column("elements", "elements", ",d"),
        Column("cell_type", "type"),
        Column("volume_cm3", "volume [cm^3]", ".2f"),
        Column("against_cad", "/ CAD - 1", "+.0e"),
        Column("mass_kg", "mass [kg]", ".4g"),
        Column("smallest_jacobian", "smallest Jacobian", ".3g"),
        Column("sicn_min", "SICN min", ".3f"),
        Column("sicn_1_percent", "1 %", ".3f"),
        Column("sicn_median", "median", ".3f"),
        Column("largest_edge_mm", "largest edge [mm]", ".1f"),
        Column("seconds", "meshed in [s]", ".1f"),
    )
    rows: list[tuple[Cell, ...]] = [
        (
            name,
            f.nodes,
            f.dofs,
            f.elements,
            f.cell_type,
            1e6 * f.volume,
            None if (cad := parts[name].cad_volume) is None else f.volume / cad - 1,
            densities[name] * f.volume,
            f.smallest_jacobian,
            *f.sicn,
            1e3 * f.largest_edge,
            seconds[name],
        )
        for name, f in found.items()
    ]
    dofs = sum(f.dofs for f in found.values())
    notes = (
        f"Degrees of freedom of both parts: {dofs:,}.",
        "/ CAD: over the volume of the geometry that was meshed.",
        "Jacobian: smallest over that of an element with straight sides. SICN: signed inverse "
        "condition number, 1 for a perfect element; min, 1 % and median over all elements.",
    )
    return Table("quality", "Meshes", columns, tuple(rows), notes)


def sets_table(parts: Mapping[str, Part], face_nodes: int | None) -> Table:
    """Number of nodes in every set of every part, and how well they match."""
    names = [name for name in SETS if any(name in part.node_sets for part in parts.values())]
    every = {name for part in parts.values() for name in part.node_sets}
    names += sorted(every.difference(names))
    rows = []
    for name in names:
        held = (part.node_sets.get(name) for part in parts.values())
        rows.append((name, *(None if nodes is None else len(nodes) for nodes in held)))
    columns = (Column("set", "set"), *(Column(name, name, "d") for name in parts))
    return Table("sets", "Node sets", columns, tuple(rows), tuple(_notes(parts, face_nodes)))


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
    writer.writerow(column.key for column in table.columns)
    writer.writerows(["" if cell is None else cell for cell in row] for row in table.rows)
    return written.getvalue()
