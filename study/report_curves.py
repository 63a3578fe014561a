"""Curves and loops on a run's page, to zoom into."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vanelock import nonlinear, render
from vanelock.report import Plot, Section, Trace
from vanelock.report.blocks import Block
from vanelock.study.answers import CaseAnswers
from vanelock.study.curve_exhibits import linear
from vanelock.study.many import PERCENT, band, drawn_alone
from vanelock.study.measured import DISPLACEMENT
from vanelock.study.naming import words
from vanelock.study.report_told import Told
from vanelock.study.wear import exact

MOST_GAUGES = 6
"""Gauges whose curves are on the page."""
STEP = 4
"""Of the samples of a loop, every so many are on the page."""


def curves(told: Told, further: Sequence[Trace] = ()) -> Section:
    """Response curves of all cases with their linear limits, and loops.

    Parameters
    ----------
    told : Told
        The run.
    further : sequence of Trace
        What else is laid over the curves, besides measured ones.
    """
    blocks: list[Block] = [response_plot(told, further)]
    blocks += gauges(told)
    blocks += [loop for each in told.answers.values() for loop in loops(each)]
    return Section("Curves", blocks, id="curves")


def response_plot(told: Told, further: Sequence[Trace] = ()) -> Plot:
    """Amplitude over frequency of every case."""
    board = told.board
    traces = [
        Trace(
            np.asarray(each.frequency, float),
            1e6 * np.asarray(each.amplitude, float),
            each.label,
            dash="dot" if each.kind == "free" else "dash",
            width=1.5,
            colour=render_grey() if not each.group else "",
        )
        for each in linear(board)
    ]
    shade = band(board)
    for percent, level in zip(PERCENT, () if shade is None else shade.levels, strict=False):
        assert shade is not None
        which = f"{percent} %" if percent != 50 else "median"
        look: dict[str, Any] = {"width": 3.0} if percent == 50 else {"dash": "dash", "width": 1.5}
        height = 1e6 * level
        name = f"{which} of {shade.label}"
        traces.append(Trace(shade.frequency, height, name, colour="#1a1a1a", **look))
    for each in drawn_alone(board):
        name = each.case.name
        frequency, amplitude, converged = board.shown.curve[name]
        order = np.argsort(frequency, kind="stable")
        height = np.where(converged, 1e6 * amplitude, np.nan)[order]
        listed = each.case.study.response.frequencies is not None
        told_of = words(name) if name != "nominal" else "with friction"
        mode = "lines+markers" if listed else "lines"
        traces.append(Trace(frequency[order], height, told_of, mode=mode))
        lost = ~converged
        if lost.any():
            traces.append(
                Trace(
                    frequency[lost],
                    1e6 * amplitude[lost],
                    f"{told_of}: did not converge",
                    mode="markers",
                    colour="#d55e00",
                )
            )
    traces += [
        Trace(each.frequency, 1e6 * each.amplitude, each.label, mode="markers", colour="#1a1a1a")
        for each in board.shown.measured
        if each.quantity == DISPLACEMENT
    ]
    data = (board.easel.folder / "figures" / "response.csv",)
    return Plot(
        [*traces, *further],
        "frequency (Hz)",
        "amplitude (µm)",
        "Forced response",
        f"Half the peak-to-peak of {told.monitor}. Dotted and dashed: linear, interlock free and "
        "stuck. Click a name in the legend to hide its curve, twice to see it alone.",
        data=[path for path in data if path.exists()],
    )


def gauges(told: Told) -> list[Plot]:
    """Strain over frequency of every gauge in the cases that are looked into."""
    stages, traces = told.board.stages, []
    many = len(told.answers) > 1
    for name, found in told.answers.items():
        if name not in told.strains:
            continue
        strain = told.strains[name][0]
        response = stages.get(found.planned.response)
        order = np.argsort(response.frequency, kind="stable")
        amplitude = np.where(response.converged[:, None], 1e6 * strain.amplitude, np.nan)
        for g in range(min(len(strain.gauges.names), MOST_GAUGES)):
            label = f"gauge {g + 1}" + (f", {words(name)}" if many else "")
            told_of = strain.gauges.names[g]
            traces.append(
                Trace(response.frequency[order], amplitude[order, g], label, hover=told_of)
            )
    if not traces:
        return []
    names = next(iter(told.strains.values()))[0].gauges.names[:MOST_GAUGES]
    where = "; ".join(f"gauge {g + 1}: {text}" for g, text in enumerate(names))
    caption = f"Half the peak-to-peak of the strain that the gauges read. {where}."
    return [Plot(traces, "frequency (Hz)", "strain (µm/m)", "Strain gauges", caption)]


def render_grey() -> str:
    """The house's grey for linear limits."""
    return str(render.style.GREY)


def loops(found: CaseAnswers) -> list[Plot]:
    """The loop of the contact that rubs most."""
    energy = found.wear.energy
    if not energy.any() or not exact(found.top):
        return []
    contact = int(energy.argmax())
    displacement, force = nonlinear.contact_loop(found.top, 0, contact)
    closed = np.append(np.arange(0, len(force), STEP), 0)
    u, t = 1e6 * displacement[closed], force[closed]
    bound = found.top.mu[contact] * t[:, 0]
    traces = []
    for d, colour in ((1, "#0072b2"), (2, "#d55e00")):
        traces.append(Trace(u[:, d], t[:, d], f"direction {d}", colour=colour))
        for sign in (1, -1):
            traces.append(
                Trace(
                    u[:, d],
                    sign * bound,
                    f"bound ±μn, direction {d}",
                    group=f"bound {d}",
                    dash="dash",
                    width=1.0,
                    colour=colour,
                )
            )
    case = "" if found.name == "nominal" else f", {words(found.name)}"
    return [
        Plot(
            traces,
            "sliding (µm)",
            "friction force (N)",
            f"Hysteresis of {found.places.names[contact]}{case}",
            f"The contact that takes most energy in a period, {1e6 * energy[contact]:.3g} µJ at "
            f"{found.peak.frequency:.2f} Hz, in both tangential directions. The area of a loop is "
            "the energy lost in that direction.",
            y_from_zero=False,
        )
    ]
