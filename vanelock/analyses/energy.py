"""Where the energy of a vibration goes, the damping it amounts to, and how joints wear by it.

Of the peaks of the cases that are looked into; what is computed: `vanelock.quantities.contacts`.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vanelock import report
from vanelock.analyses.analysis import Analysis
from vanelock.common.arrays import Floats
from vanelock.common.files.csv_table import short
from vanelock.common.tables import Cell, Column, Table, heads
from vanelock.input.cases.names import fixed, of_case, slug, words

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, RunResult
    from vanelock.quantities.contacts import Wear
    from vanelock.stages.parts.outputs import Places

SHOWN = 16
"""Contacts in the page's table; the others stand in the CSV file."""
NOT_SHOWN = ("power", "mean pressure")


INDICATORS: dict[str, tuple[Column, Callable[[Floats], np.float64]]] = {
    "energy": (Column("energy", "µJ/cycle"), np.sum),
    "energy_per_area": (Column("energy per area", "J/m²/cycle"), np.max),
    "power": (Column("power", "mW"), np.sum),
    "slip": (Column("slip", "µm/cycle"), np.max),
    "slip_per_hour": (Column("slip", "m/h", key="slip_per_hour"), np.max),
    "mean_load": (Column("mean load", "N"), np.mean),
    "largest_load": (Column("largest load", "N"), np.max),
    "mean_pressure": (Column("mean pressure", "MPa"), np.max),
    "largest_pressure": (Column("largest pressure", "MPa"), np.max),
    "volume_per_hour": (Column("worn volume", "mm³/h"), np.sum),
    "depth_per_hour": (Column("worn depth", "µm/h"), np.max),
}
"""Of a contact, by their names in `Wear`, and what a joint has of its contacts'."""
COLUMNS = tuple(column for column, _ in INDICATORS.values())
WORN = ("worn volume", "worn depth")
METHOD = (
    "Indicators at the largest response, as if the engine dwelt there: **energy** that friction "
    "takes in a cycle, alone and over the area that belongs to a contact; **slip**, the distance "
    "that the two surfaces slide over each other under load, both ways; **load and pressure**, the "
    "latter a contact's force over its area, not a local one. They compare designs and places. A "
    "worn depth needs a wear coefficient, measured for the pairing and temperature "
    "(`joints.*.wear_coefficient`); `[wear]` follows how the joints change with it."
)
PLACE = (Column("x", "mm"), Column("y", "mm"), Column("z", "mm"))


def _contact_table(places: "Places", wear: "Wear") -> Table:
    """A line for each contact: its place, its area and its indicators."""
    columns = (Column("contact"), *PLACE, Column("area", "mm²"), *COLUMNS)
    values = (*places.points.T, wear.area, *(getattr(wear, key) for key in INDICATORS))
    rows = list(zip(places.names, *values, strict=True))
    return Table("Contacts", columns, rows).without_empty(*WORN)


def _joint_table(title: str, cases: "Mapping[str, tuple[Places, Wear]]") -> Table:
    """A line for each joint of each case, by its name."""
    rows: list[tuple[Cell, ...]] = []
    for name, (places, wear) in cases.items():
        joints = np.array(places.joint)
        for joint in dict.fromkeys(places.joint):
            own = joints == joint
            values: list[Cell] = []
            for key, (_, of_joint) in INDICATORS.items():
                each = getattr(wear, key)[own]
                finite = each[np.isfinite(each)]
                values.append(of_joint(finite) if len(finite) else None)
            rows.append((name, joint, f"{np.sum(wear.energy[own] > 0)} of {own.sum()}", *values))
    columns = (*heads("case", "joint", "slipping"), *COLUMNS)
    return Table(title, columns, rows).without_empty(*WORN)


def _page(run: "RunResult") -> "list[report.Block]":
    """Where the energy goes, the damping ratio it amounts to, and wear indicators."""
    return [*_damping(run), *_wear(run)]


def _damping(run: "RunResult") -> "list[report.Block]":
    rows: list[tuple[Cell, ...]] = []
    names = list(dict.fromkeys(j for found in run.looked_into.values() for j in found.places.joint))
    for found in run.looked_into.values():
        b, joints = found.balance, _shares(found)
        power, shares = b.input * found.at_peak.frequency, (joints.get(each, 0.0) for each in names)
        structure = b.viscous / b.input if b.input > 0 else None
        ratios = structure, b.damping_ratio, found.bandwidth
        rows.append((fixed(words(found.name)), power, *shares, *ratios, _opinion(found)))
    columns = (
        Column("case"),
        Column("power", "mW"),
        *(Column(name, "%") for name in (*names, "structure", "ζ by energy", "ζ by bandwidth")),
        Column("agreement"),
    )
    text = (
        "At the peak the excitation's work in a period goes into friction at the joints and into "
        "the structure's own damping. The **equivalent damping ratio by energy** is that work over "
        "4π times the energy of the vibration, which is exact for a linear mode at resonance; **by "
        "bandwidth** it is the width of the peak at 1/√2 of its height over twice its frequency. "
        "The two agree for a linear mode. Where contacts slip, damping changes along the curve and "
        "the two differ: that by energy gives the height of the peak, that by bandwidth its width."
    )
    title = f"Power{_of_sector(run)} at the peak of each case, where it goes, and damping ratios"
    return [report.Text(text), Table(title, columns, rows)]


def _shares(case: "CaseResult") -> dict[str, float]:
    """Share of each joint's friction in the excitation's work; empty where no work is done."""
    if case.balance.input <= 0:
        return {}
    joint = np.array(case.places.joint)
    return {
        name: float(case.wear.energy[joint == name].sum()) / case.balance.input
        for name in dict.fromkeys(case.places.joint)
    }


def _opinion(case: "CaseResult") -> str:
    if not np.isfinite(case.bandwidth):
        return "half-power points are outside the range"
    ratio = case.bandwidth / case.balance.damping_ratio
    if abs(ratio - 1) < 0.1:
        return "agree within 10 %"
    return f"by bandwidth {ratio:.2f} times that by energy"


def _wear(run: "RunResult") -> "list[report.Block]":
    """Wear indicators by joint, and the contacts with the most friction work."""
    title = f"Joints{_of_sector(run)} at the peak: total energy and worn volume, else the maximum"
    by_case = {}
    for found in run.looked_into.values():
        name = fixed(words(found.name))
        by_case[name] = found.places, found.wear
        for analysis in run.analyses:
            if states := found.states(analysis):
                by_case[f"{name}, {analysis.state}"] = found.places, states[-1].wear
    blocks: list[report.Block] = [
        report.Text(METHOD),
        _joint_table(title, by_case).without(*NOT_SHOWN),
    ]
    cases = (each for each in run.looked_into.values() if each.wear.energy.any())
    blocks += run.of_cases({each.name: [_contacts(each)] for each in cases})
    return blocks


def _of_sector(run: "RunResult") -> str:
    """Of what numbers are, where there are several sectors."""
    return " of one sector" if run.first.ring[0] > 1 else ""


def _contacts(case: "CaseResult") -> Table:
    table = _contact_table(case.places, case.wear).without("x", "y", "z", *NOT_SHOWN)
    order = np.argsort(-case.wear.energy, kind="stable")
    chosen = [table.rows[i] for i in order if case.wear.energy[i] > 0][:SHOWN]
    work = f"Contacts with the most friction work{of_case(case.name)}"
    title = f"{work}; all of them in {_file(case)}"
    return replace(table, title=title, rows=chosen)


def _pictures(run: "RunResult", case: "CaseResult") -> tuple[()]:
    """None, but a CSV file of every contact's wear indicators, of which the page shows some."""
    names, *numbers = _contact_table(case.places, case.wear).by_head().items()
    columns = dict([names, *((head, short(values)) for head, values in numbers)])
    notes = [
        f"Contacts at the peak, {case.at_peak.frequency:.4g} Hz{of_case(case.name)}",
        "slip: distance under load in a cycle, both ways; pressure: force over the contact's area",
    ]
    shows = [case.key, [str(k) for k in case.places.coefficient]]
    run.table(_file(case), shows, lambda: columns, notes)
    return ()


def _file(case: "CaseResult") -> str:
    """Where all contacts of a case are listed."""
    return f"figures/wear_{slug(case.name)}.csv"


def _answers(main: "CaseResult") -> "Iterator[report.Answer]":
    """The damping ratio, and friction's share in it."""
    if not main.detailed:
        return
    ratio, note = main.problem.damping.ratio, "structure by its matrix, or 0.3 %"
    if ratio is not None:
        note = f"structure alone {100 * ratio:.2g} %"
    edge = main.at_peak.at_edge
    if edge:
        note += "; the largest point is no resonance, so this is no more than its order"
    elif np.isfinite(main.bandwidth):
        note += f"; by the half-power bandwidth {100 * main.bandwidth:.2g} %"
    value = f"{100 * main.balance.damping_ratio:.2g} %"
    yield report.Answer("Equivalent damping", value, note, "warn" if edge else "")
    joints = ", ".join(f"{name} {100 * s:.0f} %" for name, s in _shares(main).items() if s > 0)
    yield report.Answer(
        "Share of friction",
        f"{100 * main.balance.friction_share:.0f} %",
        f"of the energy dissipated in a cycle: {joints}" if joints else "no contact slips",
    )


ENERGY: Analysis[Any, Any] = Analysis(
    key="energy",
    title="energy, damping and wear indicators",
    looked_into=True,
    open=False,
    page=_page,
    pictures=_pictures,
    answers=_answers,
)
