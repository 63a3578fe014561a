"""High-cycle fatigue on a run's page: margins by place, by feature and at the gauges."""

from collections.abc import Sequence

from vanelock.common.tables import Column, Flag, Table
from vanelock.input.cases.names import of_case, words
from vanelock.input.schema.study import Study
from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry.root_fillet import filleted
from vanelock.quantities.answers import CaseAnswers
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.stress.margins import Margin
from vanelock.report import Section, Text
from vanelock.report.blocks import Block, Single

WITHOUT = (
    "A component of matrices has no field of stress: margins need the mesh and the shape functions "
    "behind it. Displacements of its nodes, forces and wear of its contacts are available."
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
PARTS = ("vane", "casing")


def fatigue(run: RunResult) -> Section:
    """Margins of the cases that are looked into."""
    if not run.planned[0].meshes:
        return Section("Fatigue", [Text(WITHOUT)], id="fatigue")
    blocks: list[Block] = [Text(_method(run))]
    cases = run.answers.values()
    own = {each.name: [*_case(run, each), *_haigh(run, each)] for each in cases}
    blocks += run.of_cases(own)
    if len(run.answers) > 1:
        blocks.append(_others(run))
    blocks.append(Text(_limits(run)))
    return Section("Fatigue", blocks, id="fatigue")


def flag(reserve: float) -> Flag:
    """Colour of a safety factor."""
    if reserve < SAFE:
        return "bad"
    return "warn" if reserve < ENOUGH else "good"


def case_flag(found: CaseAnswers, reserve: float, part: str) -> Flag:
    """Colour of a safety factor: good only of given strengths and a wave known to be stable."""
    verdict = flag(reserve)
    stable = found.wave is not None and found.wave.verdict == "stable"
    return "" if verdict == "good" and (assumed(found, part) or not stable) else verdict


def assumed(found: CaseAnswers, part: str) -> bool:
    """Whether the study leaves the strength of a part to the defaults."""
    given = getattr(found.planned.case.study.material, part).model_fields_set
    return not {"fatigue_limit", "tensile_strength"} <= given


def _haigh(run: RunResult, found: CaseAnswers) -> list[Single]:
    """The diagram of a case."""
    return [e for e in run.pictures if e.section == "fatigue" and e.case == found.name]


def _method(run: RunResult) -> str:
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


def _limits(run: RunResult) -> str:
    return (
        f"{_corners(run)}\n\n**Not in the strengths**: surface, size, scatter, corrosion, "
        "casting defects. The mean stress is of what presses the joints at rest, gas loads and "
        "heat among it where the study gives them, and what vibration does to it. Stresses of the "
        "casing are those of rest and first harmonic."
    )


def _corners(run: RunResult) -> str:
    main = run.main
    if main is None:
        return ""
    locations, study = main.stress.locations["vane"], run.study
    sharp, count = int(locations.corner.sum()), int((~locations.clear).sum())
    places, advice = "", "Real parts have fillets"
    if isinstance(study.vane, VaneDimensions):
        found = []
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
        f"{where}Nodes within {1e3 * locations.distance:.2g} mm (0.4 of {_wall(study)}) of such a "
        f"corner or of a node that carries a point force, {count} of {len(locations.clear)}, are "
        f"excluded from the critical location. {advice}."
    )


def _wall(study: Study) -> str:
    return "the thinnest wall" if isinstance(study.vane, VaneDimensions) else "an element's edge"


def _case(run: RunResult, found: CaseAnswers) -> list[Single]:
    case = of_case(found.name)
    blocks: list[Single] = [_worst(found, "peak")]
    for analysis in run.analyses:
        if states := found.states.get(analysis.key):
            blocks.append(_worst(states[-1], f"peak: {analysis.state}"))
    every = [(part, m) for part in PARTS for m in found.stress.features[part]]
    rows = [_row(found, m, part, m.where) for part, m in every]
    flags = [case_flag(found, m.reserve, part) for part, m in every]
    title = f"Worst location of each feature{case}, clear of sharp corners and point forces"
    blocks.append(Table(title, COLUMNS, rows, flags=flags))
    return blocks


def _worst(found: CaseAnswers, peak: str) -> Table:
    """The worst places at a peak of a case."""
    rows: list[tuple[str | float | None, ...]] = []
    flags: list[Flag] = []
    for part in PARTS:
        for what, m in _merged(found.stress.worst[part]):
            prefix = "" if m.node is None else f"{part}, "
            rows.append(_row(found, m, part, f"{prefix}{what}: {m.where}"))
            flags.append("" if m.doubt else case_flag(found, m.reserve, part))
    title = f"Worst locations at the {peak}, {found.peak.frequency:.2f} Hz{of_case(found.name)}"
    return Table(title, COLUMNS, rows, flags=flags)


def _merged(margins: Sequence[Margin]) -> list[tuple[str, Margin]]:
    """Margins at the same node once, under all their names."""
    found: dict[object, tuple[str, Margin]] = {}
    for i, m in enumerate(margins):
        key = ("gauge", i) if m.node is None else m.node
        found[key] = (f"{found[key][0]}; {m.what}", m) if key in found else (m.what, m)
    return list(found.values())


def _others(run: RunResult) -> Table:
    """The critical location of every case, in vane or casing."""
    rows, flags = [], []
    for found in run.answers.values():
        m = found.stress.governing
        rows.append(_row(found, m, m.part, f"{words(found.name)}: {m.part}, {m.where}"))
        flags.append(case_flag(found, m.reserve, m.part))
    return Table("The critical location of each case", COLUMNS, rows, flags=flags)


def _row(found: CaseAnswers, m: Margin, part: str, place: str) -> tuple[str | float | None, ...]:
    at = ""
    if m.node is not None:
        r, angle, z = found.stress.locations[part].coordinates(m.node)
        at = f"{1e3 * r:.1f}, {angle:.2f}, {1e3 * z:.1f}"
    return (
        f"{place} ({m.doubt})" if m.doubt else place,
        at,
        m.amplitude,
        m.mean,
        m.reserve,
        m.reserve_mises,
        m.growth,
    )
