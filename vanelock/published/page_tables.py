"""Tables of a campaign: statements, what the study withholds, energy, nodal diameters, costs."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from vanelock.common.tables import Cell, Column, Flag, Table, heads
from vanelock.pipeline.progress import Done
from vanelock.published.evidence import Evidence
from vanelock.published.sheets import case_words, load_of
from vanelock.published.statements import Agrees, Statement
from vanelock.report import Section, Text


def statement_table(found: Sequence[Statement]) -> Table:
    """The table of agreement."""
    flags: dict[Agrees, Flag] = {"yes": "good", "partly": "warn", "no": "bad"}
    columns = (
        Column("figure"),
        Column("the published study states", key="says"),
        Column("this run finds", key="found"),
        Column("agrees"),
        Column("waves", note="waves: those of the coupled peaks that it is judged by"),
        Column("why not, or where", key="why"),
    )
    rows = [(s.figure, s.says, s.found, s.agrees, s.waves or None, s.why) for s in found]
    note = (
        "Figures are those of Lassalle and Firrone's study of a vane segment. Nothing was tuned "
        "but what it withholds, listed under its parameters."
    )
    marks = [flags[s.agrees] for s in found]
    made = Table("Statements and agreement", columns, rows, (note,), "agreement", marks)
    return made.without_empty("waves")


def short_table(found: Sequence[Statement]) -> Table:
    """The same for a terminal: its numbers in lines of their own, since they are long."""
    notes = [
        f"{s.figure}: {s.found}" + (f" ({s.why})" if s.why and s.agrees != "yes" else "")
        for s in found
    ]
    return replace(statement_table(found).without("found", "why"), notes=notes)


def parameters(e: Evidence) -> Section:
    """What the published study withholds, and what stands here in its place."""
    base = e.plan.base
    hook, lock, campaign = base.joints.hook, base.joints.interlock, base.campaign
    assert campaign is not None
    load = load_of(base)
    rows: list[tuple[Cell, ...]] = [
        ("friction coefficients, Figures 12 and 15", _list(campaign.mu), "-"),
        ("reference friction, Figure 13", f"{campaign.reference_mu:g}", "-"),
        ("interferences, Figures 14 and 16", _list(1e6 * x for x in campaign.interference), "µm"),
        ("hook interference, friction", f"{1e6 * hook.interference:g}, {hook.mu:g}", "µm, -"),
        ("hook stiffness, normal and tangential", f"{hook.kn:.4g}, {hook.kt:.4g}", "N/m a pair"),
        ("interlock stiffness", f"{lock.kn:.4g}, {lock.kt:.4g}", "N/m a pair"),
        (
            "load",
            f"{load:g}",
            "kg m of unbalance" if base.excitation.unbalance else "N radial a node",
        ),
        ("damping ratio of the structure", f"{100 * base.damping.ratio:g}", "%"),
        ("sectors", f"{base.ring.sectors}", "-"),
        ("slant of the interlock faces", f"{getattr(base.vane, 'interlock_slant', 0):g}", "deg"),
        ("dimensions and material", "see the inputs", ""),
    ]
    return Section(
        "Parameters that the study withholds",
        [Table("", heads("parameter", "value here", "unit"), rows)],
        id="withheld",
    )


def diameters(e: Evidence) -> Section:
    """Every harmonic at its own nodal diameter, or all at that of the load."""
    rows: list[tuple[Cell, ...]] = []
    by_order: dict[int, dict[str, str]] = {}
    for name in e.plan.sheets["harmonics"].cases:
        response = e.plan.study(name).response
        by_order.setdefault(response.harmonics, {})[response.harmonic_diameters] = name
    for order, names in by_order.items():
        if len(names) < 2:
            continue
        own, same = names["wave"], names["sector"]
        rows.append(
            (
                order,
                e.amplitude(own),
                e.amplitude(same),
                e.amplitude(same) / e.amplitude(own) - 1,
                e.frequency(same) - e.frequency(own),
            )
        )
    text = Text(
        "Harmonic h of a travelling wave of engine order EO has the nodal diameter h EO modulo the "
        "number of sectors. The published study does not say which its higher harmonics have; "
        "this is what it costs to give all of them that of the load."
    )
    columns = (
        Column("H"),
        Column("own diameters", "µm"),
        Column("one diameter", "µm"),
        Column("difference", "%"),
        Column("shift", "Hz"),
    )
    blocks = [text, Table("", columns, rows)]
    return Section("Nodal diameter of the harmonics", blocks, id="diameters")


def energy(e: Evidence) -> Section:
    """Friction work by joint at the peaks."""
    rows: list[tuple[Cell, ...]] = []
    for name, summary in e.summaries.items():
        top = e.tops.get(name)
        if top is None or summary.peak is None:
            continue
        work = top.dissipation[0]
        hook, lock = float(work[~e.interlock].sum()), float(work[e.interlock].sum())
        total = hook + lock
        rows.append(
            (
                case_words(name),
                summary.peak.frequency,
                lock,
                hook,
                hook / total if total > 0 else None,
                summary.slipping,
                summary.opening,
            )
        )
    columns = (
        Column("case"),
        Column("peak at", "Hz"),
        Column("interlock", "µJ/cycle"),
        Column("hooks", "µJ/cycle"),
        *(Column(name, "%") for name in ("hooks' share", "pairs slip", "lift off")),
    )
    table = Table("At the peak of each case.", columns, rows)
    return Section("Energy that friction takes, by joint", [table], id="energy-by-joint")


def costs(e: Evidence, done: Sequence[Done], total: float) -> Section:
    """Where the time went, and what methods cost."""
    plane = e.planes["interference"]
    seconds = np.median(plane.seconds, axis=(0, 1))
    rows = [
        (name, seconds[k], np.median(plane.points[..., k]), seconds[k] / seconds[0])
        for k, name in enumerate(plane.methods)
    ]
    methods = Table(
        "Processor time of a response, the median over the map; the modes with all contacts stuck "
        "are computed once for all.",
        (Column("method"), Column("a response", "ms"), *heads("frequencies", "relative")),
        rows,
    )
    kinds: dict[str, float] = {}
    for each in done:
        if not each.cached:
            word = each.stage.replace("/", " ").partition(" ")[0]
            kinds[word] = kinds.get(word, 0.0) + each.seconds
    spent = sorted(kinds.items(), key=lambda item: -item[1])
    rest = total - sum(kinds.values())
    stages = Table(
        "Wall time of this run by kind of stage; what earlier runs computed is not counted.",
        (Column("stage"), Column("time", "s")),
        [*spent, ("rest", max(rest, 0.0)), ("total", total)],
    )
    return Section("Calculation time", [methods, stages], id="costs")


def _list(values: Iterable[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
