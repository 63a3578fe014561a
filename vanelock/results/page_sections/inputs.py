"""The inputs of a run on its page: what differs from the defaults first, then everything.

What a run's page says of models and provenance: sizes, times, versions, hashes.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime

import numpy as np

from vanelock.common.tables import Cell, Column, Table, counted, heads
from vanelock.input.cases.names import words
from vanelock.input.cases.values import Problem
from vanelock.input.schema.distributions import Distribution
from vanelock.input.schema.structure.loads import grows
from vanelock.input.schema.study import Study
from vanelock.input.settings import SCATTERING, Setting, as_text, meaning_and_unit, settings
from vanelock.quantities.meshes import figures, quality_table
from vanelock.quantities.run_result import RunResult
from vanelock.report import Section, Text
from vanelock.report.blocks import Block
from vanelock.results.listing import components_table, limits_table, stage_times
from vanelock.results.record import LIBRARIES
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.loads import described

MAIN = (
    "ring.sectors",
    "vane.aerofoils",
    "vane.mesh",
    "casing.mesh",
    "material.vane.E",
    "material.casing.E",
    "mesh.size",
    "response.friction",
    "joints.hook.kn",
    "joints.hook.kt",
    "joints.hook.mu",
    "joints.hook.interference",
    "joints.interlock",
    "joints.interlock.kn",
    "joints.interlock.kt",
    "joints.interlock.mu",
    "joints.interlock.interference",
    "excitation.engine_order",
    "excitation.force",
    "excitation.unbalance",
    "damping.ratio",
    "response.mode",
    "response.harmonics",
    "response.coupling",
)
"""Keys that a reader wants to know whether or not they are the defaults."""
APART = ("name", "outputs.")
"""Keys that change nothing that is computed."""
VARIED = ("sweep.", "rows.", SCATTERING)
"""What cases differ in, which has tables of its own."""
VALUE = heads("key", "what it is", "value")


def inputs(problem: Problem, cases: Sequence[Problem] = ()) -> Section:
    """What a study or scene sets; the `cases` know the temperatures of their responses."""
    if not isinstance(problem, Study):
        found = [each for each in settings(problem) if not each.key.startswith(VARIED)]
        varied = (*problem.sweep, *problem.rows, *(problem.scatter.keys if problem.scatter else ()))
        apart = (*APART, *varied)
        chosen = [each for each in found if each.changed and not each.key.startswith(apart)]
        set_so = Table("Set differently from defaults", VALUE, _rows(chosen))
        return Section("Inputs", [*_varied(problem), set_so])
    return _of_study(problem, [each for each in cases if isinstance(each, Study)])


def _of_study(study: Study, cases: Sequence[Study]) -> Section:
    found = [each for each in settings(study) if not each.key.startswith(VARIED)]
    changed = [each for each in found if each.changed and not each.key.startswith(APART)]
    blocks: list[Text | Table] = list(_varied(study))
    varied = {*study.sweep, *study.rows, *(study.scatter.keys if study.scatter else ())}
    if changed:
        blocks.append(
            Table(
                "Set differently from the defaults",
                heads("key", "what it is", "this study", "default"),
                _rows(changed, with_default=True),
            )
        )
    else:
        blocks.append(Text("Nothing else differs from the defaults."))
    plain = study.model_dump(mode="json")
    main = [e for e in found if e.key in MAIN and e.value is not None and e.key not in varied]
    if plain["excitation"]["unbalance"] is None:
        force = Setting("excitation.force", study.excitation.force_per_node, None)
        main = [force if e.key == force.key else e for e in main]
        if force.key not in (e.key for e in main) and force.key not in varied:
            main.append(force)
    note = (
        "Strengths at their defaults are assumptions, not data of a material. All settings stand "
        "at the end of the page."
    )
    blocks.append(Table("Main inputs", VALUE, _rows(main), (note,)))
    heated = [text for text in dict.fromkeys(described(case) for case in cases) if text]
    if heated:
        acts = (
            "Temperature acts through Young's modulus and as the growth of the vane against the "
            "casing, a load at rest; softer contacts are left out."
            if any(map(grows, cases))
            else "Temperature acts through Young's modulus alone: thermal expansion, the stresses "
            "that it causes and softer contacts are left out."
        )
        blocks.append(Text(f"{_sentence('; '.join(heated))}. {acts}"))
    return Section("Inputs", blocks)


def _varied(problem: Problem) -> Iterator[Table]:
    """What cases differ in."""
    kinds = (
        ("sweep", problem.sweep, "Swept: each case has one of the values"),
        ("rows", problem.rows, "Varied together: a case has the values of one place in all lists"),
    )
    schema = type(problem)
    for name, lists, caption in kinds:
        rows = [
            (key, meaning_and_unit(key, schema)[0], as_text(f"{name}.{key}", [*values], schema))
            for key, values in lists.items()
        ]
        if rows:
            yield Table(caption, heads("key", "what it is", "values"), rows)
    if problem.scatter is not None:
        caption = f"Scattering: {problem.scatter.samples:,} samples of a Latin hypercube"
        rows = [
            (key, meaning_and_unit(key, schema)[0], _distribution(key, each, schema))
            for key, each in problem.scatter.keys.items()
        ]
        yield Table(caption, heads("key", "what it is", "distribution"), rows)


def _distribution(key: str, distribution: Distribution, schema: type[Problem]) -> str:
    """How a key scatters, in words."""
    law, pair = distribution.law
    names = ("low", "high") if law == "uniform" else ("mean", "deviation")
    numbers = [*zip(names, pair, strict=True)]
    if distribution.within is not None:
        numbers += zip(("cut below", "cut above"), distribution.within, strict=True)
    words = (
        f"{name} {value if isinstance(value, str) else as_text(key, value, schema)}"
        for name, value in numbers
    )
    return ", ".join([law, *words])


def all_inputs(problem: Problem) -> Section:
    """Every key, defaults included."""
    found = [each for each in settings(problem) if not each.key.startswith("sweep.")]
    return Section("All settings", [Table("Every key", VALUE, _rows(found), folded=True)])


def _rows(settings: Sequence[Setting], with_default: bool = False) -> list[tuple[str, ...]]:
    rows = []
    for each in settings:
        meaning, _ = meaning_and_unit(each.key, each.schema)
        shown = [each.value, each.default] if with_default else [each.value]
        rows.append((each.key, meaning, *(as_text(each.key, v, each.schema) for v in shown)))
    return rows


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


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
