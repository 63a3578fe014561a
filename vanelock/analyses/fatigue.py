"""High-cycle fatigue of the cases that are looked into: margins by place, feature and gauge.

Stress cycles and criterion: `vanelock.quantities.stress`.
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock import render, report
from vanelock.analyses.analysis import Analysis
from vanelock.common.files.csv_table import short
from vanelock.common.tables import Column, Flag, Table
from vanelock.input.cases.names import of_case, slug, words
from vanelock.input.schema.structure.temperature import PARTS

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, RunResult
    from vanelock.quantities.stress.margins import Margin
    from vanelock.report.blocks import Single

HCF = "HCF safety factor"
HAIGH = "Haigh diagram"
"""Title of these pictures."""
MARKED = 5
"""Features marked in a Haigh diagram, gauges aside."""


WITHOUT = (
    "A component of matrices has no field of stress: margins need the mesh and the shape functions "
    "behind it. Displacements of its nodes, forces and wear of its contacts are available."
)
LIMITS = (
    "**Not in the strengths**: surface, size, scatter, corrosion, casting defects. The mean stress "
    "is of what presses the joints at rest, gas loads and heat among it where the study gives "
    "them, and what vibration does to it. Stresses of the casing are those of rest and first "
    "harmonic."
)
SAFE, ENOUGH = 1.0, 1.5
"""Reserves below which a margin is not met, and below which it is tight."""

COLUMNS = (
    Column("location"),
    Column("r, angle, z", "mm, °, mm"),
    Column("alternating", "MPa"),
    Column("mean", "MPa", ".2f"),
    Column("n, hydrostatic mean"),
    Column("n, von Mises mean"),
    Column("vibratory stress margin"),
)


def _page(run: "RunResult") -> "list[report.Block]":
    """Margins of the cases that are looked into."""
    if not run.first.has_meshes:
        return [report.Text(WITHOUT)]
    cases = run.looked_into.values()
    by_case = {each.name: _case(run, each) for each in cases}
    blocks: list[report.Block] = [report.Text(_method(run)), *run.of_cases(by_case)]
    if len(run.looked_into) > 1:
        blocks.append(_others(run))
    return [*blocks, report.Text(f"{_corners(run)}\n\n{LIMITS}")]


def _flag(case: "CaseResult", reserve: float, part: str) -> Flag:
    """Colour of a safety factor: good only of given strengths and a wave known to be stable."""
    if reserve < ENOUGH:
        return "bad" if reserve < SAFE else "warn"
    stable = (wave := case.summary.wave) is not None and wave.verdict == "stable"
    return "good" if stable and not _assumed(case, part) else ""


def _assumed(case: "CaseResult", part: str) -> bool:
    """Whether the study leaves the strength of a part to the defaults."""
    given = getattr(case.study.material, part).model_fields_set
    return not {"fatigue_limit", "tensile_strength"} <= given


def _method(run: "RunResult") -> str:
    own = run.study.material
    bears = "; ".join(
        f"{part}: fatigue limit {1e-6 * m.fatigue_limit:g} MPa, "
        f"tensile strength {1e-6 * m.tensile_strength:g} MPa"
        for part, m in (("vane", own.vane), ("casing", own.casing))
    )
    return (
        "The **safety factor n** is the factor on both stresses at which the Goodman line is "
        "reached: alternating / fatigue limit + mean / tensile strength = 1/n. Alternating is the "
        "largest von Mises stress of the vibration in a cycle, mean three times the hydrostatic "
        "stress at rest (Sines); compression earns no credit. The second n takes the signed von "
        "Mises stress as the mean. The **vibratory stress margin** is the allowable alternating "
        "stress at the given mean, relative to the computed one.\n\n"
        f"**Strengths.** {bears}. They are those of the study; the defaults are assumed for a cast "
        "nickel alloy at temperature and are **not material data**."
    )


def _corners(run: "RunResult") -> str:
    from vanelock.mesh import VaneDimensions
    from vanelock.mesh.geometry.root_fillet import filleted

    main = run.main
    if main is None:
        return ""
    locations, study = main.stress.locations["vane"], run.study
    sharp, count = int(locations.corner.sum()), int((~locations.clear).sum())
    places, advice, wall = "", "Real parts have fillets", "an element's edge"
    if isinstance(study.vane, VaneDimensions):
        found, wall = [], "the thinnest wall"
        if not filleted(study.vane, study.ring.sectors).root_fillet:
            found.append("roots of the aerofoils")
            advice += ": give the roots theirs by `vane.root_fillet`"
        if study.vane.fillet == 0:
            found.append("legs and feet of the hooks")
            advice += f"{',' if found[1:] else ':'} give the hooks theirs by `vane.fillet`"
        places = f": {', '.join(found)}" if found else ""
    where = (
        f"**Sharp corners.** The vane has re-entrant corners without a fillet ({sharp} nodes on or "
        f"beside them{places}). There the linear elastic stress is singular: the value only "
        "reflects the element size. "
        if sharp
        else ""
    )
    return (
        f"{where}Nodes within {1e3 * locations.distance:.2g} mm (0.4 of {wall}) of such a "
        f"corner or of a node that carries a point force, {count} of {len(locations.clear)}, are "
        f"excluded from the critical location. {advice}."
    )


def _case(run: "RunResult", case: "CaseResult") -> "list[Single]":
    blocks: list[Single] = [_worst(case, "peak")]
    for analysis in run.analyses:
        if states := case.states(analysis):
            blocks.append(_worst(states[-1], f"peak: {analysis.state}"))
    every = [(part, m) for part in PARTS for m in case.stress.features[part]]
    rows = [_row(case, m, part, m.where) for part, m in every]
    flags = [_flag(case, m.reserve, part) for part, m in every]
    clear = "clear of sharp corners and point forces"
    title = f"Worst location of each feature{of_case(case.name)}, {clear}"
    diagram = [e for e in run.pictures if e.section == "fatigue" and e.case == case.name]
    return [*blocks, Table(title, COLUMNS, rows, flags=flags), *diagram]


def _worst(case: "CaseResult", peak: str) -> Table:
    """The worst places at a peak of a case."""
    rows: list[tuple[str | float | None, ...]] = []
    flags: list[Flag] = []
    for part in PARTS:
        for what, m in _merged(case.stress.worst[part]):
            prefix = "" if m.node is None else f"{part}, "
            rows.append(_row(case, m, part, f"{prefix}{what}: {m.where}"))
            flags.append("" if m.doubt else _flag(case, m.reserve, part))
    title = f"Worst locations at the {peak}, {case.at_peak.frequency:.2f} Hz{of_case(case.name)}"
    return Table(title, COLUMNS, rows, flags=flags)


def _merged(margins: "Sequence[Margin]") -> "list[tuple[str, Margin]]":
    """Margins at the same node once, under all their names."""
    found: dict[object, tuple[str, Margin]] = {}
    for i, m in enumerate(margins):
        key = ("gauge", i) if m.node is None else m.node
        found[key] = (f"{found[key][0]}; {m.what}", m) if key in found else (m.what, m)
    return list(found.values())


def _others(run: "RunResult") -> Table:
    """The critical location of every case, in vane or casing."""
    rows, flags = [], []
    for found in run.looked_into.values():
        m = found.stress.governing
        rows.append(_row(found, m, m.part, f"{words(found.name)}: {m.part}, {m.where}"))
        flags.append(_flag(found, m.reserve, m.part))
    return Table("The critical location of each case", COLUMNS, rows, flags=flags)


def _row(case: "CaseResult", m: "Margin", part: str, path: str) -> tuple[str | float | None, ...]:
    at = ""
    if m.node is not None:
        r, angle, z = case.stress.locations[part].coordinates(m.node)
        at = f"{1e3 * r:.1f}, {angle:.2f}, {1e3 * z:.1f}"
    return (
        f"{path} ({m.doubt})" if m.doubt else path,
        at,
        m.amplitude,
        m.mean,
        m.reserve,
        m.reserve_mises,
        m.growth,
    )


def _pictures(run: "RunResult", case: "CaseResult") -> "Iterator[report.Picture]":
    """Haigh diagram of the vane at a case's peak, and its numbers at every node."""
    if not case.has_meshes:
        return
    cycle, locations = case.stress.cycles.vane, case.stress.locations["vane"]
    bears = case.stress.worst["vane"][0].strength
    marked = [*case.stress.features["vane"][:MARKED], *case.stress.gauges[:3]]
    named = [render.Named(m.what, m.mean, m.amplitude, m.node is None) for m in marked]
    title = f"Fatigue of the vane at the peak, {case.at_peak.frequency:.2f} Hz"
    text = (
        f"fatigue limit {1e-6 * bears.limit:g} MPa, tensile strength {1e-6 * bears.tensile:g} MPa"
    )
    subtitle = "; ".join([*([] if case.name == "nominal" else [words(case.name)]), text])
    shows = [case.key, title, subtitle, [bears.limit, bears.tensile]]
    nodes = cycle.mean, cycle.amplitude, ~locations.clear, bears.limit, bears.tensile
    path = run.output_files.draw(
        f"figures/haigh_{slug(case.name)}.png",
        shows,
        lambda path: render.haigh_picture(path, *nodes, named, title, subtitle),
    )
    notes = [
        f"{title}{of_case(case.name)}; {text}",
        "amplitude: largest alternating von Mises stress; mean: trace of the mean stress;",
        "signed: its von Mises stress with the sign of the trace; n: Goodman safety factor",
        "clear: 0 at sharp re-entrant corners and beside point forces, where stress has no limit",
    ]
    data = run.table(f"figures/fatigue_{slug(case.name)}.csv", shows, lambda: _nodes(case), notes)
    caption = (
        f"Every node of the vane{of_case(case.name)}: what alternates at the peak over what acts "
        "at rest, as equivalent stresses (von Mises amplitude and hydrostatic mean, by Sines). "
        "Below the black Goodman line life is infinite; the safety factor n is the factor on both "
        "stresses at which they reach it. Marked: the worst locations of some features, away "
        "from sharp corners and point forces, and the gauges."
    )
    yield report.Picture(path, HAIGH, caption, (data,))


def _nodes(case: "CaseResult") -> dict[str, ArrayLike]:
    cycle, locations = case.stress.cycles.vane, case.stress.locations["vane"]
    bears = case.stress.worst["vane"][0].strength
    x, y, z = 1e3 * locations.part.points.T
    return {
        "node": np.arange(len(x)),
        "x (mm)": short(x),
        "y (mm)": short(y),
        "z (mm)": short(z),
        "feature": locations.feature.tolist(),
        "clear": locations.clear,
        "amplitude (MPa)": short(1e-6 * cycle.amplitude),
        "mean (MPa)": short(1e-6 * cycle.mean),
        "signed mean (MPa)": short(1e-6 * cycle.mean_mises),
        "half of the range (MPa)": short(1e-6 * cycle.chord),
        "n": short(bears.reserve(cycle.amplitude, cycle.mean)),
    }


def _answers(main: "CaseResult") -> "Iterator[report.Answer]":
    """The critical stress and its safety factor."""
    if not main.detailed or main.margins is None:
        return
    m = main.margins.governing
    locations = main.margins.locations[m.part]
    least = min(each.stress.governing.reserve for each in (main, *main.last_states))
    r, angle, z = locations.coordinates(m.node) if m.node is not None else (0, 0, 0)
    place = f"r {1e3 * r:.1f} mm, {angle:+.2f}°, z {1e3 * z:.1f} mm"
    yield report.Answer(
        "Critical stress",
        f"{1e-6 * m.amplitude:.3g} MPa",
        f"alternating, mean {1e-6 * m.mean:.2g} MPa: {m.part}, {m.where} ({place})",
    )
    if main.at_peak.at_edge:
        yield report.withheld(HCF)
    else:
        flag = _flag(main, least, m.part)
        yield report.Answer(HCF, f"n = {m.reserve:.3g}", _reserve(main), flag)


def _reserve(main: "CaseResult") -> str:
    m, least = main.stress.governing, main.stress.least_growth
    where = "" if least is m else f", least {least.growth:.3g} ({least.part}, {least.where})"
    wave = main.summary.wave
    stability = (
        "stability of the wave not checked" if wave is None else f"the wave is {wave.verdict}"
    )
    text = (
        f"{m.part}; Goodman, {'ASSUMED ' if _assumed(main, m.part) else ''}fatigue limit "
        f"{1e-6 * m.strength.limit:g} MPa; vibratory stress margin {m.growth:.3g}{where}; "
        f"{stability}. Clear of sharp corners and point forces"
    )
    worst = main.stress.worst[m.part][0]
    if worst.doubt:
        text += f", where the mesh has n = {worst.reserve:.3g}"
    for analysis in main.analyses:
        if states := main.states(analysis):
            reserve, peak = states[-1].stress.governing.reserve, 1e6 * states[-1].at_peak.amplitude
            text = f"**n = {reserve:.3g} at {peak:.3g} µm**, {analysis.state}. {text}"
    return text


FATIGUE: Analysis[Any, Any] = Analysis(
    key="fatigue",
    title="fatigue",
    looked_into=True,
    open=False,
    page=_page,
    pictures=_pictures,
    answers=_answers,
)
