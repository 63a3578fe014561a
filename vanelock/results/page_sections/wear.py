"""Energy, damping and wear on a run's page: by joint and by contact."""

from dataclasses import replace

import numpy as np

from vanelock.common.tables import Cell, Column, Table
from vanelock.input.cases.names import fixed, of_case, words
from vanelock.input.cases.values import ring_of
from vanelock.quantities.answers import CaseAnswers
from vanelock.quantities.contacts.wear_tables import contact_table, joint_table
from vanelock.quantities.run_result import RunResult
from vanelock.report import Section, Text
from vanelock.report.blocks import Block

SHOWN = 16
"""Contacts in the page's table; the others stand in the CSV file."""
NOT_SHOWN = ("power", "mean pressure")


def damping(run: RunResult) -> Section:
    """Where the energy goes, and the damping ratio it amounts to."""
    rows: list[tuple[Cell, ...]] = []
    names = list(dict.fromkeys(j for found in run.answers.values() for j in found.places.joint))
    for found in run.answers.values():
        b, joints = found.balance, shares(found)
        rows.append(
            (
                fixed(words(found.name)),
                b.input * found.peak.frequency,
                *(joints.get(name, 0.0) for name in names),
                b.viscous / b.input if b.input > 0 else None,
                b.damping_ratio,
                found.bandwidth,
                _opinion(found),
            )
        )
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
    title = f"Power{of_sector(run)} at the peak of each case, where it goes, and damping ratios"
    return Section("Energy and damping", [Text(text), Table(title, columns, rows)])


def shares(found: CaseAnswers) -> dict[str, float]:
    """Share of each joint's friction in the excitation's work; empty where no work is done."""
    if found.balance.input <= 0:
        return {}
    joint = np.array(found.places.joint)
    return {
        name: float(found.wear.energy[joint == name].sum()) / found.balance.input
        for name in dict.fromkeys(found.places.joint)
    }


def _opinion(found: CaseAnswers) -> str:
    if not np.isfinite(found.bandwidth):
        return "half-power points are outside the range"
    ratio = found.bandwidth / found.balance.damping_ratio
    if abs(ratio - 1) < 0.1:
        return "agree within 10 %"
    return f"by bandwidth {ratio:.2f} times that by energy"


def wear(run: RunResult) -> Section:
    """Wear indicators by joint, and the contacts with the most friction work."""
    title = f"Joints{of_sector(run)} at the peak: total energy and worn volume, else the maximum"
    by_case = {}
    for found in run.answers.values():
        name = fixed(words(found.name))
        by_case[name] = found.places, found.wear
        for analysis in run.analyses:
            if states := found.states.get(analysis.key):
                by_case[f"{name}, {analysis.state}"] = found.places, states[-1].wear
    blocks: list[Block] = [Text(_method()), joint_table(title, by_case).without(*NOT_SHOWN)]
    cases = (each for each in run.answers.values() if each.wear.energy.any())
    blocks += run.of_cases({each.name: [_contacts(each, run)] for each in cases})
    return Section("Wear of the joints", blocks, id="joints")


def _method() -> str:
    return (
        "Indicators at the largest response, as if the engine dwelt there: **energy** that "
        "friction takes in a cycle, alone and over the area that belongs to a contact; **slip**, "
        "the distance that the two surfaces slide over each other under load, both ways; **load "
        "and pressure**, the latter a contact's force over its area, not a local one. They compare "
        "designs and places. A worn depth needs a wear coefficient, measured for the pairing and "
        "temperature (`joints.*.wear_coefficient`); `[wear]` follows how the joints change with it."
    )


def of_sector(run: RunResult) -> str:
    """Of what numbers are, where there are several sectors."""
    return " of one sector" if ring_of(run.given)[0] > 1 else ""


def _contacts(found: CaseAnswers, run: RunResult) -> Table:
    table = contact_table(found.places, found.wear).without("x", "y", "z", *NOT_SHOWN)
    order = np.argsort(-found.wear.energy, kind="stable")
    chosen = [table.rows[i] for i in order if found.wear.energy[i] > 0][:SHOWN]
    file = run.wear.get(found.name)
    title = f"Contacts with the most friction work{of_case(found.name)}" + (
        f"; all of them in {file.parent.name}/{file.name}" if file else ""
    )
    return replace(table, title=title, rows=chosen)
