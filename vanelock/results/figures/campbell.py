"""Campbell diagrams of a run: picture, numbers and table of crossings."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock import render
from vanelock.common.tables import Column, Table, heads
from vanelock.input.cases.names import of_case, slug, words
from vanelock.input.measured.curve import Measured
from vanelock.input.measured.units import DISPLACEMENT
from vanelock.quantities.run_result import RunResult
from vanelock.report import Picture
from vanelock.stages.campbell.campbell import Campbell, largest
from vanelock.stages.campbell.speed_lines import Lines

DETAILED = 8
"""Diagrams drawn; of more the first and the last."""


def campbells(run: RunResult) -> list[Picture]:
    """One for each distinct set of lines."""
    found = [(n, case.campbell) for n, case in run.cases.items() if case.campbell is not None]
    if len(found) > DETAILED:
        found = [found[0], found[-1]]
    alone = len(run.planned) == 1
    return [_picture(run, "" if alone else name, each) for name, each in found]


def _picture(run: RunResult, name: str, diagram: Campbell) -> Picture:
    stem = f"figures/campbell_{slug(name)}" if name else "figures/campbell"
    measured = run.measured
    title = f"{run.study.name}: Campbell diagram"
    shows = [_digest(diagram, measured), title, name]
    path = run.output_files.draw(
        f"{stem}.png",
        shows,
        lambda path: _draw_campbell(path, diagram, title, words(name), measured),
    )
    tables = {
        "lines": (_line_columns(diagram.lines), "natural frequencies against rotor speed"),
        "crossings": (crossings_table(name, diagram).by_head(), "where engine orders meet modes"),
        "circles": (_circle_columns(diagram), f"amplitude of {diagram.monitor} along them"),
    }
    data = [
        run.table(f"{stem}_{kind}.csv", shows, partial(dict, columns), [f"{title}: {note}"])
        for kind, (columns, note) in tables.items()
    ]
    return Picture(path, "Campbell diagram", caption(diagram, name), tuple(data))


def _draw_campbell(
    path: str | Path,
    diagram: Campbell,
    title: str,
    subtitle: str = "",
    measured: Sequence[Measured] = (),
) -> Path:
    """Draw a Campbell diagram, and return the path."""
    lines = diagram.lines
    families = [
        render.LineFamily(int(k), lines.free[i], lines.stuck[i] if lines.interlock else None)
        for i, k in enumerate(lines.diameters)
    ]
    dots = []
    for each in measured:
        held = largest(lines, each.speed, each.amplitude)
        own_scale = each.quantity != DISPLACEMENT
        shown = each.speed[held], each.frequency[held], each.amplitude[held], own_scale
        dots.append(render.Dots(f"measured: {each.label}", *shown))
    written: Path = render.campbell_picture(
        path,
        lines.speeds,
        families,
        lines.engine_orders.tolist(),
        render.Crossings(
            lines.diameter, lines.speed, lines.frequency, lines.is_stuck, lines.interest
        ),
        render.Circles(diagram.speed, diagram.frequency, diagram.amplitude, diagram.nonlinear),
        dots,
        title,
        "; ".join(filter(None, (subtitle, _circles_are(diagram)))),
        _notes(diagram),
    )
    return written


def _circles_are(diagram: Campbell) -> str:
    return f"Areas of circles: amplitude of {diagram.monitor}, under {diagram.loading}"


def _notes(diagram: Campbell) -> list[str]:
    held = f", interlock {diagram.linear}" if diagram.lines.interlock else ""
    notes = [
        "dots: an engine order meets a mode of the",
        "nodal diameter that it excites",
        f"nonlinear: the study's EO {diagram.own_order}",
        f"linear: no friction{held};",
        "the same load at each force node",
    ]
    heat = diagram.lines.temperatures
    notes += [
        f"{part}: {heat[0, i]:.0f} to {heat[-1, i]:.0f} °C"
        for i, part in enumerate(("vane", "casing"))
        if not np.isnan(heat[0, i])
    ]
    return notes


def caption(diagram: Campbell, name: str) -> str:
    """What the picture shows, for someone who did not make the run."""
    lines = diagram.lines
    full = "full with the interlock stuck, dashed with it free" if lines.interlock else "full"
    heated = not np.isnan(lines.temperatures).all()
    bent = (
        " They bend with rotor speed as Young's modulus falls with each part's temperature; "
        "stresses do not stiffen them."
        if heated
        else " They are level: no temperatures are given, and rotation does not stiffen a stator."
    )
    held = f" with the interlock {diagram.linear}" if lines.interlock else ""
    return (
        f"Natural frequencies of the nodal diameters that the engine orders excite, over rotor "
        f"speed{of_case(name)}: {full}.{bent} Where an engine order meets a line there is a "
        f"resonance; stars mark engine order {diagram.own_order} on the mode of interest. Circles "
        f"show the amplitude of {diagram.monitor} by their area: those of engine order "
        f"{diagram.own_order} around the mode of interest are the computed response with friction; "
        f"all others are the linear response{held} to the same load at each force node, which "
        "friction would lower and which need not act in the engine at that order."
    )


def _line_columns(lines: Lines) -> Mapping[str, ArrayLike]:
    """Speed, temperatures, and each natural frequency."""
    found: dict[str, ArrayLike] = {"rotor speed (rpm)": lines.speeds}
    for i, part in enumerate(("vane", "casing")):
        if not np.isnan(lines.temperatures[:, i]).all():
            found[f"{part} temperature (degC)"] = lines.temperatures[:, i]
    conditions = {"free": lines.free, "stuck": lines.stuck} if lines.interlock else {"": lines.free}
    for i, k in enumerate(lines.diameters):
        for held, values in conditions.items():
            for j in range(values.shape[2]):
                words = " ".join(filter(None, (f"ND {k} mode {j + 1}", held)))
                found[f"{words} (Hz)"] = values[i, :, j]
    return found


def _circle_columns(diagram: Campbell) -> Mapping[str, ArrayLike]:
    """One row for each circle."""
    return {
        "engine order": diagram.order,
        "rotor speed (rpm)": diagram.speed,
        "frequency (Hz)": diagram.frequency,
        "amplitude (µm)": 1e6 * diagram.amplitude,
        "nonlinear": diagram.nonlinear,
    }


def crossings_table(name: str, diagram: Campbell) -> Table:
    """Where engine orders meet modes."""
    lines = diagram.lines
    columns = (
        Column("engine order", key="engine_order"),
        Column("nodal diameter", key="nodal_diameter"),
        *heads("mode", "interlock"),
        Column("frequency", "Hz", ".6g", "frequency_hz"),
        Column("rotor speed", "rpm", ",.0f", "speed_rpm"),
        Column("of interest", key="interest"),
    )
    held = _held(lines)
    rows = list(
        zip(
            *(lines.order, lines.diameter, lines.mode, held, lines.frequency, lines.speed),
            lines.interest,
            strict=True,
        )
    )
    low, high = float(lines.speeds[0]), float(lines.speeds[-1])
    title = f"Crossings of engine orders and modes, {low:,.0f} to {high:,.0f} rpm"
    note = "the mode of interest is not met in this range of speeds"
    notes = () if lines.interest.any() else (note,)
    return Table(f"{title}{name and f', {name}'}", columns, rows, notes, "crossings")


def _held(lines: Lines) -> list[str]:
    if not lines.interlock:
        return ["none"] * len(lines.speed)
    return ["stuck" if each else "free" for each in lines.is_stuck]


def _digest(diagram: Campbell, measured: Sequence[Measured]) -> str:
    """Hash of all that is drawn."""
    digest = hashlib.sha256()
    shown: tuple[Any, ...] = (diagram.lines, diagram, *measured)
    for each in shown:
        for value in (getattr(each, field.name) for field in fields(each)):
            if not isinstance(value, Lines):
                array = isinstance(value, np.ndarray)
                digest.update(
                    np.ascontiguousarray(value).tobytes() if array else repr(value).encode()
                )
    return digest.hexdigest()[:20]
