"""Campbell diagram of a case: natural frequencies, engine orders, crossings and how it responds.

Circles on the lines of the engine orders show how it responds, as measured diagrams do: the
largest amplitude in each of many narrow ranges of speed. Those of the study's own engine order come
from its nonlinear response as far as that reaches. All others are of the linear response to the
same load at each force node, with the interlock free or stuck, whichever frequency of the mode of
interest the nonlinear peak is nearer to; friction would lower them.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from vanelock import render, report
from vanelock.analyses.analysis import Analysis, AnalysisPart
from vanelock.common.arrays import Floats, Integers
from vanelock.common.tables import Column, Table, heads
from vanelock.input.cases.names import of_case, slug, words
from vanelock.input.schema.comparison import CampbellKeys
from vanelock.input.schema.structure.temperature import PARTS

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, Planned, RunResult, SolvedCase, Step
    from vanelock.input.measured.curve import Measured
    from vanelock.nonlinear import Response
    from vanelock.stages.campbell.speed_lines import Along, Campbell, Lines
    from vanelock.stages.response.limits import Limit, Limits
    from vanelock.stages.response.responses import Monitor


RANGES = 100
"""Ranges of speed of which a circle shows the largest amplitude."""
LEAST = 0.002
"""Of the largest amplitude, below which no circle is kept."""
TEXT = (
    "Natural frequencies against rotor speed, and where engine orders meet them: a resonance of "
    "each nodal diameter that an engine order excites."
)


def _product() -> "type[Campbell]":
    from vanelock.stages.campbell.speed_lines import Campbell

    return Campbell


def _needs(planned: "Planned", keys: CampbellKeys) -> "Sequence[Step[Lines]]":
    """Lines and crossings, which cases may share."""
    from vanelock.stages.campbell.speed_lines import lines_step

    return [lines_step(planned)]


def _compute(case: "SolvedCase", keys: CampbellKeys, part: AnalysisPart) -> "Campbell":
    """The diagram of a case."""
    from vanelock.stages.campbell.speed_lines import Campbell, along_step, lines_step

    planned, study, watched = case.planned, case.planned.case.study, case.monitored
    lines: Lines = case.get(lines_step(planned))
    limits: Limits = case.get(planned.linear.limits)
    at_free = case.peak is None or not limits.opens or limits.position(case.peak.frequency) < 0.5
    linear: Limit = "free" if at_free else "stuck"
    excitation = study.excitation
    own = abs(excitation.engine_order)
    circles = []
    for order in lines.engine_orders.tolist():
        along = case.get(along_step(planned, order, linear, watched))
        curve = (case.response, watched) if order == own else None
        circles.append(_circles(lines, order, along, curve))
    orders, speed, frequency, amplitude, by_friction = np.concatenate(circles).T
    shown = amplitude > LEAST * amplitude.max(initial=0.0)
    return Campbell(
        lines=lines,
        order=orders[shown].astype(np.int64),
        speed=speed[shown],
        frequency=frequency[shown],
        amplitude=amplitude[shown],
        nonlinear=by_friction[shown].astype(bool),
        own_order=own,
        monitor=watched.name,
        linear=linear,
        loading=f"{excitation.force_per_node:.4g} N at each force node"
        if excitation.unbalance is None
        else f"unbalance of {1e6 * excitation.unbalance:.4g} g mm",
    )


def _circles(
    lines: "Lines", order: int, along: "Along", curve: "tuple[Response, Monitor] | None"
) -> Floats:
    """(b, 5) order, speed, frequency, amplitude and origin of the circles on a line."""
    speed, amplitude = along.speed, along.amplitude
    nonlinear = np.zeros(len(speed))
    if curve is not None:
        response, monitor = curve
        own = 60 * response.frequency / order
        outside = (speed < own.min()) | (speed > own.max())
        speed = np.concatenate([speed[outside], own])
        amplitude = np.concatenate([amplitude[outside], monitor.amplitude(response)])
        nonlinear = np.concatenate([nonlinear[outside], np.ones(len(own))])
    inside = (speed >= lines.speeds[0]) & (speed <= lines.speeds[-1]) & ~np.isnan(amplitude)
    orders = np.full(len(speed), float(order))
    rows = np.column_stack((orders, speed, speed * order / 60, amplitude, nonlinear))[inside]
    return np.asarray(rows[_largest(lines, speed[inside], amplitude[inside])])


def _largest(lines: "Lines", speed: Floats, amplitude: Floats) -> Integers:
    """Places of the largest amplitude in each of many narrow ranges of speed, rpm."""
    edges = np.linspace(lines.speeds[0], lines.speeds[-1], RANGES + 1)
    place = np.digitize(speed, edges[1:-1])
    each = (np.flatnonzero(place == i) for i in range(RANGES))
    return np.array([own[amplitude[own].argmax()] for own in each if len(own)], np.int64)


def _warnings(case: "CaseResult", products: "Sequence[Campbell]") -> Iterator[str]:
    """Whether the diagram shows what the reduced models do not answer."""
    (diagram,), band = products, case.limits.band
    lines = diagram.lines
    highest = max(float(lines.free.max()), float(lines.stuck.max()))
    driven = float(lines.speeds.max() * np.abs(lines.engine_orders).max() / 60)
    beyond = []
    if band is not None and driven > band:
        beyond.append(f"circles end at {band:.6g} Hz, and engine orders go on to {driven:.6g} Hz")
    if band is not None and highest > band:
        beyond.append(f"lines above {band:.6g} Hz, here up to {highest:.6g} Hz, are too high")
    if beyond:
        end = "the band of the reduced models, which campbell.speeds widens"
        yield f"Campbell diagram: {' and '.join(beyond)}: {end}"


def _distinct(cases: "Mapping[str, CaseResult]") -> "dict[str, CaseResult]":
    """The first of the cases that share lines and crossings, whatever their responses, by case."""
    first: dict[bytes, CaseResult] = {}
    for case in cases.values():
        for diagram in case.found("campbell"):
            shown = (each.tobytes() for each in vars(diagram.lines).values())
            first.setdefault(b"".join(shown), case)
    return {case.name: case for case in first.values()}


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """Where engine orders meet modes."""
    for name, case in _distinct(cases).items():
        yield _crossings("" if len(cases) == 1 else name, case.found("campbell")[0])


def _run_pictures(run: "RunResult") -> "Iterator[report.Picture]":
    """One for each distinct set of lines, of many the first and the last."""
    from vanelock.quantities.run_result import DETAILED

    found = list(_distinct(run.cases).values())
    for case in found if len(found) <= DETAILED else (found[0], found[-1]):
        yield _picture(run, case)


def _picture(run: "RunResult", case: "CaseResult") -> "report.Picture":
    """The diagram of a case and its numbers."""
    (diagram,), name = case.found("campbell"), "" if len(run.cases) == 1 else case.name
    stem = f"figures/campbell_{slug(name)}" if name else "figures/campbell"
    title = f"{run.problem.name}: Campbell diagram"
    shows = [*case.key_of("campbell"), [each.shown for each in run.measured], title, name]
    path = run.output_files.draw(
        f"{stem}.png",
        shows,
        lambda path: _draw(path, diagram, title, words(name), run.measured),
    )
    circles = {
        "engine order": diagram.order,
        "rotor speed (rpm)": diagram.speed,
        "frequency (Hz)": diagram.frequency,
        "amplitude (µm)": 1e6 * diagram.amplitude,
        "nonlinear": diagram.nonlinear,
    }
    numbers = {
        "lines": (_line_columns(diagram.lines), "natural frequencies against rotor speed"),
        "crossings": (_crossings(name, diagram).by_head(), "where engine orders meet modes"),
        "circles": (circles, f"amplitude of {diagram.monitor} along them"),
    }
    data = [
        run.table(f"{stem}_{kind}.csv", shows, partial(dict, columns), [f"{title}: {note}"])
        for kind, (columns, note) in numbers.items()
    ]
    return report.Picture(
        path, "Campbell diagram", _caption(diagram, name), tuple(data), case=case.name
    )


def _draw(
    path: Path, diagram: "Campbell", title: str, subtitle: str, measured: "Sequence[Measured]"
) -> None:
    """Draw a Campbell diagram."""
    from vanelock.input.measured.units import DISPLACEMENT

    lines = diagram.lines
    families = [
        render.LineFamily(int(k), lines.free[i], lines.stuck[i] if lines.interlock else None)
        for i, k in enumerate(lines.diameters)
    ]
    dots = []
    for each in measured:
        held = _largest(lines, each.speed, each.amplitude)
        own_scale = each.quantity != DISPLACEMENT
        shown = each.speed[held], each.frequency[held], each.amplitude[held], own_scale
        dots.append(render.Dots(f"measured: {each.label}", *shown))
    circles = f"Areas of circles: amplitude of {diagram.monitor}, under {diagram.loading}"
    render.campbell_picture(
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
        "; ".join(filter(None, (subtitle, circles))),
        _notes(diagram),
    )


def _notes(diagram: "Campbell") -> list[str]:
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
        for i, part in enumerate(PARTS)
        if not np.isnan(heat[0, i])
    ]
    return notes


def _caption(diagram: "Campbell", name: str) -> str:
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


def _line_columns(lines: "Lines") -> Mapping[str, ArrayLike]:
    """Speed, temperatures, and each natural frequency."""
    found: dict[str, ArrayLike] = {"rotor speed (rpm)": lines.speeds}
    for i, part in enumerate(PARTS):
        if not np.isnan(lines.temperatures[:, i]).all():
            found[f"{part} temperature (degC)"] = lines.temperatures[:, i]
    conditions = {"free": lines.free, "stuck": lines.stuck} if lines.interlock else {"": lines.free}
    for i, k in enumerate(lines.diameters):
        for held, values in conditions.items():
            for j in range(values.shape[2]):
                words = " ".join(filter(None, (f"ND {k} mode {j + 1}", held)))
                found[f"{words} (Hz)"] = values[i, :, j]
    return found


def _crossings(name: str, diagram: "Campbell") -> Table:
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
    states = np.where(lines.is_stuck, "stuck", "free") if lines.interlock else ["none"]
    held = np.broadcast_to(states, len(lines.speed)).tolist()
    modes, places = (lines.order, lines.diameter, lines.mode), (lines.frequency, lines.speed)
    rows = list(zip(*modes, held, *places, lines.interest, strict=True))
    low, high = float(lines.speeds[0]), float(lines.speeds[-1])
    title = f"Crossings of engine orders and modes, {low:,.0f} to {high:,.0f} rpm"
    note = "the mode of interest is not met in this range of speeds"
    notes = () if lines.interest.any() else (note,)
    return Table(f"{title}{name and f', {name}'}", columns, rows, notes, "crossings")


CAMPBELL = Analysis(
    key="campbell",
    title="Campbell diagram",
    keys=CampbellKeys,
    product=_product,
    needs=_needs,
    compute=_compute,
    any_law=True,
    warnings=_warnings,
    tables=_tables,
    run_pictures=_run_pictures,
    text=TEXT,
)
