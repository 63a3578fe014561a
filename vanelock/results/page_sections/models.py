"""What a run's page says of models and provenance: sizes, times, versions, hashes."""

from dataclasses import replace
from datetime import datetime

import numpy as np

from vanelock.common.tables import Cell, Column, Table, counted, heads
from vanelock.input.cases.names import words
from vanelock.quantities.meshes.mesh_tables import quality_table
from vanelock.quantities.meshes.quality import figures
from vanelock.quantities.run_result import RunResult
from vanelock.report import Section, Text
from vanelock.report.blocks import Block
from vanelock.results.listing import components_table, limits_table, stage_times
from vanelock.results.record import LIBRARIES
from vanelock.stages.parts.components import PARTS

OF_PARTS = (
    "Masters: coordinates of the nodes that joints, loads and outputs use; modes: vibration with "
    "these held. Reduction error: the largest relative one of the frequencies shown, estimated; "
    "that of the mesh comes on top."
)
NOT_SHOWN = ("volume_cm3", "against_cad", "smallest_jacobian", "sicn_1_percent")


def models(run: RunResult) -> Section:
    """Meshes, reduced parts, system, contacts and linear limits."""
    first = run.first
    if first.has_meshes:
        tables = [_meshes(run), _reduced(run)]
    else:
        pieces = [first.component(name) for name in first.components]
        tables = [components_table(pieces, first.system)]
    sets = {each.linear_key: each for each in reversed(run.cases.values())}
    limits = limits_table({words(e.linear_name): e.limits for e in reversed(sets.values())})
    times = stage_times(run.times.values()).without("computed", "seconds_now")
    note = "Times are those of when a stage was computed; later runs find it in the cache."
    tables += [_contacts(run), limits, replace(times, title="Computing time", notes=(note,))]
    return Section("Model", tables, id="model")


def _contacts(run: RunResult) -> Table:
    """Properties of the first case's contacts by joint."""
    contacts = run.first.system.contacts
    rows: list[tuple[Cell, ...]] = []
    for name in dict.fromkeys(contacts.joints):
        own = np.array([joint == name for joint in contacts.joints])
        ranges = [
            _range(values[own])
            for values in (contacts.kn, contacts.kt[:, 0], contacts.mu, 1e6 * contacts.v0)
        ]
        rows.append((name, np.sum(own), *ranges))
    columns = (
        *heads("joint", "contacts"),
        Column("kn", "N/m"),
        Column("kt", "N/m"),
        Column("μ"),
        Column("interference", "µm"),
    )
    return Table("Contacts of one sector in the first case", columns, rows)


def _range(values: np.ndarray) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _meshes(run: RunResult) -> Table:
    first = run.first
    parts, material = {part.name: part for part in first.parts}, run.study.material
    seconds = (run.times[key].seconds for key in first.mesh_keys)
    table = quality_table(
        parts,
        {name: figures(part) for name, part in parts.items()},
        {name: getattr(material, name).rho for name in parts},
        dict(zip(parts, seconds, strict=True)),
    ).without(*NOT_SHOWN)
    several = len({tuple(each.mesh_keys) for each in run.cases.values()}) > 1
    title = f"Finite-element meshes of one sector{' of the first case' if several else ''}"
    return replace(table, title=title)


def _reduced(run: RunResult) -> Table:
    first = run.first
    rows: list[tuple[Cell, ...]] = []
    for part in PARTS:
        component = first.component(part)
        masters = 3 * len(component.masters.nodes)
        rows.append((part, masters, component.fixed_modes, component.size, component.route))
    system = first.system
    size = len(system.at(system.nodal_diameter(1)).K)
    joints = system.contacts.joint
    counts = ", ".join(f"{joints.count(j)} {j}" for j in dict.fromkeys(joints))
    rows.append(("joined", None, None, size, f"{counted(len(joints), 'contact')}: {counts}"))
    columns = heads("part", "masters", "modes", "coordinates", "route or contacts")
    title = f"Reduced models of one of {first.study.ring.sectors} sectors"
    return Table(title, columns, rows, (OF_PARTS,))


def provenance(run: RunResult) -> Section:
    """Versions, date, command, study file, and the hash of every response."""
    hashes: list[tuple[Cell, ...]] = [
        (words(name), each.key_at("response"), each.key_at("system"))
        for name, each in run.cases.items()
    ]
    blocks: list[Block] = [
        Text(
            f"Of a run begun {begun(run)}, made from `results.h5` beside this page, which "
            "holds every mesh, reduced model and response with their units. The page shows the "
            "results of the file below and nothing else; it is written again when any of them "
            "changes. Terms are explained by `vanelock manual glossary`."
        ),
        Table("Versions", heads("program", "version"), _versions(run)),
        Table(
            "Hashes of all inputs and code behind each response and system",
            heads("case", "response", "system"),
            hashes,
        ),
    ]
    if run.text.strip():
        lines = [(line,) for line in run.text.rstrip().splitlines()]
        blocks.append(Table("As it was given", heads("the file"), lines))
    return Section("Provenance", blocks, id="provenance")


def _versions(run: RunResult) -> list[tuple[Cell, ...]]:
    """Rows of what computed the run; what draws the page again may be another."""
    known = run.versions
    names = ("vanelock", "python", "platform", *LIBRARIES)
    return [(name, known[name]) for name in names if name in known]


def begun(run: RunResult) -> str:
    """When the results of a run were begun."""
    return datetime.fromisoformat(run.date).strftime("%Y-%m-%d %H:%M UTC")
