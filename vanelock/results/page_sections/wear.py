"""Energy, damping and wear on a run's page: by joint and by contact."""

from collections.abc import Sequence

import numpy as np

from vanelock.input.cases.names import fixed, of_case, words
from vanelock.quantities.answers import CaseAnswers
from vanelock.report import Section, Table, Text
from vanelock.report.blocks import Block, Cell
from vanelock.results.page_sections.content import PageContent

SHOWN = 16
"""Contacts in the page's table; the others stand in the CSV file."""


def damping(told: PageContent) -> Section:
    """Where the energy goes, and the damping ratio it amounts to."""
    rows: list[tuple[Cell, ...]] = []
    names = list(dict.fromkeys(j for found in told.answers.values() for j in found.places.joint))
    for found in told.answers.values():
        b, joints = found.balance, shares(found)
        rows.append(
            (
                fixed(words(found.name)),
                1e3 * b.input * found.peak.frequency,
                *(100 * joints.get(name, 0.0) for name in names),
                100 * b.viscous / b.input if b.input > 0 else None,
                100 * b.damping_ratio,
                100 * found.bandwidth if np.isfinite(found.bandwidth) else None,
                _opinion(found),
            )
        )
    header = ("case", "power", *names, "structure", "ζ, energy", "ζ, bandwidth", "")
    units = ("", "mW", *["%"] * len(names), "%", "%", "%", "")
    text = (
        "At the peak the excitation's work in a period goes into friction at the joints and into "
        "the structure's own damping. The **equivalent damping ratio by energy** is that work over "
        "4π times the energy of the vibration, which is exact for a linear mode at resonance; **by "
        "bandwidth** it is the width of the peak at 1/√2 of its height over twice its frequency. "
        "The two agree for a linear mode. Where contacts slip, damping changes along the curve and "
        "the two differ: the energy's tells the height of the peak, the bandwidth's its shape."
    )
    caption = f"Power{of_sector(told)} at the peak of each case, where it goes, and damping ratios"
    return Section("Energy and damping", [Text(text), Table(header, rows, caption, units)])


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
        return "the curve ends above 1/√2"
    ratio = found.bandwidth / found.balance.damping_ratio
    if abs(ratio - 1) < 0.1:
        return "agree within 10 %"
    return f"bandwidth tells {ratio:.2f} of it"


def wear(told: PageContent) -> Section:
    """Wear indicators by joint, and the contacts that rub most."""
    blocks: list[Block] = [Text(_method())]
    blocks.append(_joints(list(told.answers.values()), of_sector(told)))
    main = told.main
    if main is not None and main.wear.energy.any():
        blocks.append(_contacts(main, told))
    return Section("Wear of the joints", blocks, id="wear")


def _method() -> str:
    return (
        "Indicators at the largest response, as if the engine dwelt there: **energy** that "
        "friction takes in a cycle, alone and over the area that belongs to a contact; **slip**, "
        "the distance that the two surfaces slide over each other under load, both ways; **load "
        "and pressure**, the latter a contact's force over its area, not a local one. They compare "
        "designs and places. A worn depth needs a wear coefficient, measured for the pairing and "
        "temperature (`joints.*.wear_coefficient`); how wear changes the interference is not "
        "followed."
    )


def of_sector(told: PageContent) -> str:
    """Of what numbers are, where there are several sectors."""
    return " of one sector" if told.run_data.given.ring.sectors > 1 else ""


def _joints(cases: Sequence[CaseAnswers], of_what: str) -> Table:
    """A line for each joint of each case."""
    archard = any(np.isfinite(found.wear.coefficient).any() for found in cases)
    rows: list[tuple[Cell, ...]] = []
    for found in cases:
        joint, w = np.array(found.places.joint), found.wear
        for name in dict.fromkeys(found.places.joint):
            own = joint == name
            row: list[Cell] = [
                fixed(words(found.name)),
                name,
                f"{int((own & (w.energy > 0)).sum())} of {int(own.sum())}",
                1e6 * float(w.energy[own].sum()),
                _most(w.energy_per_area[own]),
                _scaled(_most(w.slip[own]), 1e6),
                _most(w.slip_per_hour[own]),
                float(w.mean_load[own].mean()),
                float(w.largest_load[own].max()),
                _scaled(_most(w.largest_pressure[own]), 1e-6),
            ]
            if archard:
                row += [_scaled(_total(w.volume_per_hour[own]), 1e9)]
                row += [_scaled(_most(w.depth_per_hour[own]), 1e6)]
            rows.append(tuple(row))
    header = ["case", "joint", "rub", "energy", "per area", "slip", "slip"]
    header += ["mean load", "load", "pressure"]
    units = ["", "", "", "µJ/cycle", "J/m²", "µm/cycle", "m/h", "N", "N", "MPa"]
    if archard:
        header += ["worn", "depth"]
        units += ["mm³/h", "µm/h"]
    title = f"Joints{of_what} at the peak: energy and worn volume in all, else the largest"
    return Table(header, rows, title, units)


def _contacts(found: CaseAnswers, told: PageContent) -> Table:
    w = found.wear
    order = np.argsort(-w.energy, kind="stable")
    chosen = [int(i) for i in order if w.energy[i] > 0][:SHOWN]
    rows: list[tuple[Cell, ...]] = [
        (
            fixed(found.places.names[i]),
            _scaled(_known(w.area[i]), 1e6),
            1e6 * float(w.energy[i]),
            _known(w.energy_per_area[i]),
            _scaled(_known(w.slip[i]), 1e6),
            _known(w.slip_per_hour[i]),
            float(w.mean_load[i]),
            float(w.largest_load[i]),
            _scaled(_known(w.largest_pressure[i]), 1e-6),
            _scaled(_known(w.depth_per_hour[i]), 1e6),
        )
        for i in chosen
    ]
    header: tuple[str, ...] = (
        "contact",
        "area",
        "energy",
        "per area",
        "slip",
        "slip",
        "mean load",
        "load",
        "pressure",
        "depth",
    )
    units: tuple[str, ...] = (
        "",
        "mm²",
        "µJ/cycle",
        "J/m²",
        "µm/cycle",
        "m/h",
        "N",
        "N",
        "MPa",
        "µm/h",
    )
    file = told.wear.get(found.name)
    caption = f"The {len(rows)} contacts that rub most{of_case(found.name)}" + (
        f"; all of them in {file.parent.name}/{file.name}" if file else ""
    )
    if not np.isfinite(w.coefficient).any():
        header, units = header[:-1], units[:-1]
        rows = [row[:-1] for row in rows]
    return Table(header, rows, caption, units)


def _most(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.max()) if len(known) else None


def _total(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.sum()) if len(known) else None


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value
