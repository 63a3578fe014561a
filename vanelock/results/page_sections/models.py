"""Sizes of meshes, reduced models and contacts on a run's page."""

import numpy as np

from vanelock.quantities.meshes.quality import figures
from vanelock.report import Section, Table, Text
from vanelock.report.blocks import Cell
from vanelock.results.listing import components_table
from vanelock.results.page_sections.content import PageContent
from vanelock.stages.parts.components import PARTS
from vanelock.stages.response.limits import SHOWN

OF_MESHES = (
    "Quality: signed inverse condition number, 1 for a perfect element. Masters: coordinates of "
    "the nodes that joints, loads and outputs use; modes: vibration with these held. Error of a "
    "natural frequency: the largest relative one by reducing the parts, estimated; that of the "
    "mesh comes on top. "
)
TIMES = "Times are those of when a stage was computed; later runs find it in the cache."


def models(told: PageContent) -> Section:
    """Meshes, reduced parts, system, contacts and linear limits."""
    planned = told.run_data.planned[0]
    tables = [_meshes(told), _reduced(told)] if planned.meshes else [_components(told)]
    tables += [_contacts(told), _limits(told), _times(told)]
    notes = OF_MESHES + TIMES if planned.meshes else TIMES
    return Section("Model", [*tables, Text(notes)], id="model")


def _components(told: PageContent) -> Table:
    """Components of a scene."""
    run_data = told.run_data
    first = run_data.planned[0]
    found = components_table(
        [run_data.stages.get(step) for step in first.rom.values()],
        run_data.stages.get(first.system),
    )
    header = tuple(column.head for column in found.columns)
    return Table(header, list(found.rows), f"Components: {found.notes[0]}")


def _contacts(told: PageContent) -> Table:
    """Properties of the first case's contacts by joint."""
    first = told.run_data.planned[0]
    contacts = told.run_data.stages.get(first.system).contacts
    rows: list[tuple[Cell, ...]] = []
    for name in dict.fromkeys(contacts.joints):
        own = np.array([joint == name for joint in contacts.joints])
        ranges = [
            _range(values[own])
            for values in (contacts.kn, contacts.kt[:, 0], contacts.mu, 1e6 * contacts.v0)
        ]
        rows.append((name, int(own.sum()), *ranges))
    header = ("joint", "contacts", "kn", "kt", "μ", "interference")
    units = ("", "", "N/m", "N/m", "", "µm")
    return Table(header, rows, "Contacts of one sector in the first case", units)


def _range(values: np.ndarray) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _meshes(told: PageContent) -> Table:
    run_data = told.run_data
    study = run_data.planned[0].case.study
    rows: list[tuple[Cell, ...]] = []
    for part in PARTS:
        found = figures(run_data.stages.get(run_data.planned[0].meshes[part]))
        density = getattr(study.material, part).rho
        rows.append(
            (
                part,
                found.nodes,
                found.dofs,
                found.elements,
                found.cell_type,
                density * found.volume,
                1e3 * found.largest_edge,
                found.sicn[0],
                found.sicn[2],
            )
        )
    header = ("part", "nodes", "dofs", "elements", "type", "mass", "edge", "worst", "median")
    units = ("", "", "", "", "", "kg", "≤ mm", "quality", "quality")
    several = len({_mesh_keys(told, i) for i in range(_count(told))}) > 1
    title = f"Finite-element meshes of one sector{' of the first case' if several else ''}"
    return Table(header, rows, title, units)


def _count(told: PageContent) -> int:
    return len(told.run_data.planned)


def _mesh_keys(told: PageContent, i: int) -> tuple[str, ...]:
    return tuple(step.key for step in told.run_data.planned[i].meshes.values())


def _reduced(told: PageContent) -> Table:
    run_data = told.run_data
    first = run_data.planned[0]
    rows: list[tuple[Cell, ...]] = []
    for part in PARTS:
        component = run_data.stages.get(first.rom[part])
        masters = 3 * len(component.masters.nodes)
        rows.append((part, masters, component.fixed_modes, component.size, component.route))
    system = run_data.stages.get(first.system)
    size = len(system.at(system.nodal_diameter(1)).K)
    joints = system.contacts.joint
    counts = ", ".join(f"{joints.count(j)} {j}" for j in dict.fromkeys(joints))
    rows.append(("joined", None, None, size, f"{len(joints)} contacts: {counts}"))
    N = first.case.study.ring.sectors
    caption = f"Reduced models of one of {N} sectors"
    return Table(("part", "masters", "modes", "coordinates", "route or contacts"), rows, caption)


def _limits(told: PageContent) -> Table:
    run_data = told.run_data
    rows: list[tuple[Cell, ...]] = []
    seen = set()
    shown = 0
    for each in run_data.planned:
        if each.linear.key in seen:
            continue
        seen.add(each.linear.key)
        found = run_data.stages.get(each.linear.limits)
        shown = min(SHOWN, len(found.free))
        name = each.linear.name or "all cases"
        for which, hertz, mode, error in (
            ("free", found.free, found.free_mode, found.free_error),
            ("stuck", found.stuck, found.stuck_mode, found.stuck_error),
        ):
            if which == "stuck" and not found.opens:
                continue
            worst = float(np.max(error[: max(shown, mode + 1)]))
            rows.append(
                (
                    name,
                    which,
                    *(float(f) for f in hertz[:shown]),
                    mode + 1,
                    worst if np.isfinite(worst) else None,
                )
            )
    header = ("cases", "contacts", *(f"f{i + 1}" for i in range(shown)), "mode", "error")
    units = ("", "", *["Hz"] * shown, "of interest", "~")
    caption = "Natural frequencies at the excited nodal diameter"
    return Table(header, rows, caption, units)


def _times(told: PageContent) -> Table:
    kinds: dict[str, list[float]] = {}
    for done in told.run_data.stages.done.values():
        word = done.stage.partition(",")[0].split(" ")
        kind = word[0] if word[0] in ("response", "preload", "stress", "check") else " ".join(word)
        kinds.setdefault(kind.split("/")[0], []).append(done.seconds)
    rows: list[tuple[Cell, ...]] = [(k, len(v), float(sum(v))) for k, v in kinds.items()]
    rows.append(("together", sum(len(v) for v in kinds.values()), sum(r[2] for r in rows)))  # type: ignore[misc]
    return Table(
        ("stage", "number", "time"),
        rows,
        "Computing time",
        ("", "", "s"),
    )
