"""What a campaign adds to the page of a run: statements, figures to zoom into, maps, costs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vanelock.common.tables import Cell, Column, Table, heads
from vanelock.input.schema.study import Study
from vanelock.published.evidence import Evidence, known, share
from vanelock.published.figures import REFERENCE, CurveSheet, reference
from vanelock.published.maps.map_figures import holds
from vanelock.published.maps.optimum import Ridge
from vanelock.published.maps.plane import Method
from vanelock.published.page_tables import costs, diameters, energy, parameters, statement_table
from vanelock.published.sheets import COUPLINGS
from vanelock.published.statements import Statement
from vanelock.quantities import warnings
from vanelock.quantities.curves_and_fields import RunData
from vanelock.report import Answer, Answers, Picture, Plot, Section, Text, curve_plot
from vanelock.report.blocks import Block


@dataclass(frozen=True)
class PublishedPictures:
    """What was drawn for the page.

    Attributes
    ----------
    sheets : sequence of CurveSheet
        Curves of the study's figures.
    loops, maps : sequence of Picture
    best : Picture
        The peak over decades.
    """

    sheets: Sequence[CurveSheet]
    loops: Sequence[Picture]
    maps: Sequence[Picture]
    best: Picture


def sections(
    run_data: RunData,
    e: Evidence,
    stated: Sequence[Statement],
    shown: PublishedPictures,
    spent: Callable[[], float],
) -> list[Section]:
    """All sections of a campaign, its answers first; `spent` gives the seconds since it began."""
    done = [*run_data.stages.done.values(), *run_data.output_files.done]
    return [
        answers(e, stated),
        agreement(stated),
        figures(run_data, e, shown.sheets, shown.loops),
        optimum(e, shown.best),
        maps(e, shown.maps),
        energy(e),
        diameters(e),
        costs(e, done, spent()),
        parameters(e),
    ]


def answers(e: Evidence, stated: Sequence[Statement]) -> Section:
    """The first things to know."""
    agreed = {word: sum(s.agrees == word for s in stated) for word in ("yes", "partly", "no")}
    items = [
        Answer(
            "Published statements",
            f"{agreed['yes']} of {len(stated)} agree",
            f"{agreed['partly']} partly, {agreed['no']} not; see the table below",
            "good" if not agreed["no"] else "warn",
        )
    ]
    items += [
        _best(ridge, e.plan.base) for ridge in e.ridges if ridge.harmonics == _highest(e.ridges)
    ]
    best = Method(max(e.plan.base.campaign.harmonics) if e.plan.base.campaign else 1)
    plane = e.planes["interference"]
    a, _ = plane.of(best)
    for coupling in COUPLINGS[:2]:
        off = np.abs(plane.of(Method(1, coupling))[0] / a - 1)
        words = "one harmonic" if coupling == "coupled" else "uncoupled, one harmonic"
        items.append(
            Answer(
                f"Error of {words}",
                f"{100 * np.nanmedian(off):.0f} %",
                f"median over friction and interference, of the peak against {best.name}; "
                f"{100 * np.nanmax(off):.0f} % at worst",
                "warn",
            )
        )
    blocks: list[Block] = [Answers(tuple(items))]
    blocks += [Text(f"**Be careful.** {line}") for line in doubts(e)]
    return Section("The published study on this scene", blocks, id="campaign")


def doubts(e: Evidence) -> list[str]:
    """Cases whose peak is not to be trusted, and the statements with it, a line each."""
    cases = e.summaries.items()
    return [f"{name}: {line}." for name, each in cases for line in warnings.doubts(each)]


def agreement(stated: Sequence[Statement]) -> Section:
    """The table of agreement."""
    return Section(
        "Statements and agreement", [replace(statement_table(stated), title="")], id="agreement"
    )


def figures(
    run_data: RunData, e: Evidence, sheets: Sequence[CurveSheet], loops: Sequence[Picture]
) -> Section:
    """The study's figures: loops as pictures, curves to zoom into."""
    plots = [_plot(run_data, e, sheet) for sheet in sheets]
    return Section("The study's figures", [*loops, *plots], id="published")


def maps(e: Evidence, pictures: Sequence[Picture]) -> Section:
    """Where statements hold: shares, then the maps."""
    planes = {"friction and interference": e.planes["interference"]}
    planes["friction and load"] = e.planes["load"]
    planes |= {f"slant {slant:g}°": plane for slant, plane in e.slants.items()}
    names = list(holds(e.planes["interference"]))
    rows = []
    for words, plane in planes.items():
        found = holds(plane)
        shares = [share(plane, found[name]) if name in found else None for name in names]
        rows.append((words, int((~known(plane)).sum()) or None, *shares))
    table = Table(
        "Share of each map's known cells in which a statement holds; a cell is unknown where a "
        "point at the peak did not converge. Other slants have meshes of their own, medium ones "
        "where the study's is finer or a length, and fewer cells.",
        (*heads("plane", "cells unknown"), *(Column(name, "%") for name in names)),
        rows,
    )
    return Section("Where each statement holds", [table, *pictures], id="maps")


def optimum(e: Evidence, picture: Picture) -> Section:
    """The friction and interference that damp best."""
    rows = []
    for ridge in e.ridges:
        best = ridge.best
        scale, unit = (1e6, "µm") if ridge.name == "interference" else (1.0, "-")
        best_row: tuple[Cell, ...] = (None, None, ridge.message or "not enough points")
        if best is not None:
            best_row = (scale * best[0], best[1], "at the end" if best[2] else "")
        rows.append((ridge.name, ridge.harmonics, unit, *best_row))
    columns = (
        *heads("parameter", "H", "unit", "best"),
        Column("peak there", "µm"),
        Column("note"),
    )
    return Section(
        "Friction and interference that damp best",
        [Table("", columns, rows), picture],
        id="optimum",
    )


def _plot(run_data: RunData, e: Evidence, sheet: CurveSheet) -> Plot:
    data = (run_data.output_files.folder / "figures" / f"{sheet.name}.csv",)
    text = REFERENCE + sheet.caption
    return curve_plot(sheet.curves, sheet.title, text, reference(e), data=data)


def _highest(ridges: Sequence[Ridge]) -> int:
    return max((ridge.harmonics for ridge in ridges), default=0)


def _best(ridge: Ridge, base: Study) -> Answer:
    words = {"mu": "Optimum friction", "interference": "Optimum interference"}
    best = ridge.best
    if best is None:
        return Answer(words[ridge.name], "unknown", ridge.message, "warn")
    value = f"μ = {best[0]:.2g}" if ridge.name == "mu" else f"{1e6 * best[0]:.2g} µm"
    lock = base.joints.interlock
    held = f"{1e6 * lock.interference:g} µm" if ridge.name == "mu" else f"μ = {lock.mu:g}"
    note = f"lowest peak {1e6 * best[1]:.3g} µm, H = {ridge.harmonics}, at {held}"
    if best[2]:
        return Answer(words[ridge.name], value, f"{note}; at the end of the range", "warn")
    return Answer(words[ridge.name], value, note)
