"""Curves and loops on a run's page, to zoom into.

Convergence and errors on a run's page: what is estimated, what is checked, and what is not.

Modes and responses on a run's page, to turn and to play.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vanelock.common.arrays import Complex
from vanelock.common.tables import Cell, Flag, Table, heads
from vanelock.input.cases.names import fixed, words
from vanelock.input.schema.scene import Scene
from vanelock.nonlinear import ELEMENT
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.contacts import exact
from vanelock.quantities.run_result import RunResult, band
from vanelock.render.plots.curve import Curve, converged
from vanelock.report import Motion, Plot, Section, Text, Trace, View, body_of, curve_plot
from vanelock.report.blocks import Block
from vanelock.results.figures.contacts import Loop
from vanelock.results.figures.curves import all_curves, key_to_lines
from vanelock.stages.accuracy.errors import error_table, left_out_table
from vanelock.stages.parts.outputs import tangents

HALF, WIDER, ROOM = 0.5, 0.5, 1.1
"""Shown around the peaks with friction: all above a half of each, half as much again on both sides,
and so many times the largest."""
STEP = 4
"""Of the samples of a loop, every so many are on the page."""


def loops(run: RunResult) -> Section:
    """The loops of the contacts that slide most."""
    made = {name: _loop(each) for name, each in run.looked_into.items()}
    return Section("Hysteresis", run.of_cases(made), id="loops")


def response_plot(run: RunResult) -> Plot:
    """Amplitude over frequency of every case."""
    data = run.output_files.folder / "figures" / "response.csv"
    lines = (
        f"Dashed and dotted: linear, {run.opens} free and stuck."
        if run.opens
        else "Dashed: linear."
    )
    made = all_curves(run)
    plot = curve_plot(
        made,
        "Forced response",
        f"Half the peak-to-peak of {run.monitor.name}. {lines} Click a name in the legend to hide "
        f"its curve, twice to see it alone.{key_to_lines(made)}",
        band=band(run),
        data=[data] if data.exists() else [],
    )
    return replace(plot, log_y=True, zoom=_around_peaks(plot, made))


def _around_peaks(
    plot: Plot, curves: Sequence[Curve]
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Range of frequency [Hz] and of amplitude [µm] about the peaks with friction."""
    across, up = [], []
    for curve in curves:
        frequency, amplitude = curve.frequency, 1e6 * curve.amplitude
        solved = converged(curve)
        if curve.kind == "nonlinear" and solved.any():
            top = amplitude[solved].max()
            up.append(top)
            across.append(frequency[solved & (amplitude >= HALF * top)])
    if not up or not max(up) > 0:
        return None
    near = np.concatenate(across)
    wide = max(np.ptp(near), 1e-3 * near.max())
    ends = float(near.min() - WIDER * wide), float(near.max() + WIDER * wide)
    return ends, (0.05 * float(min(up)), ROOM * float(max(up)))


def _loop(result: CaseResult) -> list[Plot]:
    """The loop of the contact with the most friction work."""
    energy = np.where(result.top.state[0] == ELEMENT, 0.0, result.wear.energy)
    if not energy.any() or not exact(result.top):
        return []
    contact = int(energy.argmax())
    names = tangents(result.problem, result.places.joint[contact])
    turned = Loop(result.top, contact, names)
    displacement, force = turned.history
    closed = np.append(np.arange(0, len(force), STEP), 0)
    u, t, bound = 1e6 * displacement[closed], force[closed], (turned.mu * turned.load)[closed]
    traces = []
    for d, name, colour in ((1, names[0], "#0072b2"), (2, names[1], "#d55e00")):
        traces.append(Trace(u[:, d], t[:, d], name, colour=colour))
        for sign in (1, -1):
            traces.append(
                Trace(
                    u[:, d],
                    sign * bound,
                    f"limit ±μn, {name}",
                    group=f"bound {d}",
                    dash="dash",
                    width=1.0,
                    colour=colour,
                )
            )
    case = "" if result.name == "nominal" else f", {words(result.name)}"
    return [
        Plot(
            traces,
            "relative displacement (µm)",
            "friction force (N)",
            f"Hysteresis of {result.places.names[contact]}{case}",
            f"The contact that dissipates most, {1e6 * energy[contact]:.3g} µJ per cycle at "
            f"{result.at_peak.frequency:.2f} Hz, in both friction directions. The area of a loop "
            "is the energy dissipated in that direction.",
            y_from_zero=False,
        )
    ]


CHECKED = (
    "Checked: at the peak every contact is marched in time by independent code and its forces are "
    "put into the equations of motion of the reduced model; the residual of forces, and of power, "
    "is given relative to the largest terms."
)


def convergence(run: RunResult) -> Section:
    """How sure the numbers are."""
    blocks: list[Block] = [_points(run), Text(CHECKED)]
    for name, (errors, without) in run.errors.items():
        case = words(name)
        blocks += [error_table(case, errors, run.monitor.name), left_out_table(case, without)]
    blocks.append(Text(_not_estimated(run)))
    return Section("Convergence and errors", blocks, id="errors")


def _points(run: RunResult) -> Table:
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for each in run.summaries:
        found = run.looked_into.get(each.case)
        audit = found.audit if found else None
        rows.append(
            (
                fixed(words(each.case)),
                each.harmonics,
                each.points,
                each.points - each.converged,
                each.worst or None,
                None if audit is None else audit.residual[0],
                None if audit is None else audit.imbalance[0],
            )
        )
        flags.append("good" if each.converged == each.points else "bad")
    columns = ("case", "H", "points", "lost", "max residual", "force residual", "power residual")
    title = "Points of each curve, and the peak checked by other code"
    return Table(title, heads(*columns), rows, flags=flags)


def _not_estimated(run: RunResult) -> str:
    given = run.problem
    missing = []
    if isinstance(given, Scene):
        missing.append(
            "**Matrices and frequency points**: chosen by the scene, their errors not estimated; "
            "that of the harmonics to first order alone."
        )
    elif not run.errors:
        missing.append(
            "**Modes and frequency points**: chosen by the study, their errors not estimated; "
            "those of mesh and harmonics to first order alone, for the largest peak. "
            "`accuracy = 0.01` asks for estimates of all, `vanelock converge` measures them."
        )
        if given.mesh.correction != "none":
            missing.append(
                "**Mesh stiffening** is corrected, by the amount given with the linear limits. A "
                "quarter of it is uncertain, and amplitudes change with it."
            )
    if not isinstance(given, Scene):
        missing.append(
            "**Stresses**: no error is estimated; they converge more slowly than frequencies, and "
            "not at all at sharp corners and point forces."
        )
    missing += [
        "**Contact**: stiffnesses, friction and interference are inputs; their scatter between "
        "builds is usually larger than every number in this section.",
    ]
    missing += [
        text
        for analysis in run.analyses
        if analysis.keys_of(given) is None and (text := analysis.absent(run.first))
    ]
    if given.response.samples is not None:
        missing.append("**Samples**: contact forces are sampled, their error is not estimated.")
    return "Not estimated:\n\n" + "\n\n".join(missing)


MOST = 4
"""Responses shown besides the modes."""


def shapes(run: RunResult) -> Section:
    """The 3-D view of the case with the largest peak, and of others on the same meshes.

    None where the study wants no shapes.
    """
    main = run.main
    wanted = main is not None and main.margins and run.shapes
    blocks: list[Block] = [_view(run, _same_mesh(run))] if wanted else []
    return Section("Shapes in three dimensions", blocks, id="shapes")


def _same_mesh(run: RunResult) -> list[CaseResult]:
    """Cases with answers on the meshes of the main one, that first."""
    main = run.main
    assert main is not None
    cases = [main, *(each for each in run.looked_into.values() if each is not main)]
    return [each for each in cases if each.mesh_keys == main.mesh_keys][:MOST]


def _view(run: RunResult, cases: list[CaseResult]) -> View:
    """Modes of the first of some cases on one mesh, and the response of each at its peak."""
    found = [body_of(part) for part in cases[0].parts]
    taken = [nodes for _, nodes in found]

    def cut(fields: list[Complex]) -> tuple[Complex, ...]:
        return tuple(field[nodes] for field, nodes in zip(fields, taken, strict=True))

    motions = []
    for each in cases:
        name = "" if each.name == "nominal" else f", {words(each.name)}"
        motions.append(
            Motion(
                f"Response at the peak{name}",
                int(each.top.harmonic_diameters[1]),
                cut(each.fields.shape(1)),
                each.at_peak.frequency,
                note="First harmonic alone.",
            )
        )
    limits = cases[0].limits
    for which in limits.conditions:
        place, frequency = limits.of_interest(which)
        motions.append(
            Motion(
                f"Mode {place + 1}{f', interlock {which}' if limits.opens else ''}",
                limits.nodal_diameter,
                cut(cases[0].mode_shapes.shape(which)),
                frequency,
                note="A linear mode: its height means nothing.",
                relative=True,
            )
        )
    return View(
        [body for body, _ in found],
        motions,
        "Response and modes on the full ring",
        "Drag to turn, scroll to zoom. Colours show the amplitude; the motion is exaggerated.",
    )
