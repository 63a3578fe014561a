"""Curves and loops on a run's page, to zoom into."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vanelock.input.cases.names import words
from vanelock.nonlinear import ELEMENT
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.contacts.wear import exact
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.selection import band
from vanelock.render.plots.curve import Curve, converged
from vanelock.report import Plot, Section, Trace, curve_plot
from vanelock.results.figures.contacts import Loop
from vanelock.results.figures.curves import all_curves, key_to_lines
from vanelock.stages.parts.places import tangents

HALF, WIDER, ROOM = 0.5, 0.5, 1.1
"""Shown around the peaks with friction: all above a half of each, half as much again on both sides,
and so many times the largest."""
STEP = 4
"""Of the samples of a loop, every so many are on the page."""


def loops(run: RunResult) -> Section:
    """The loops of the contacts that slide most."""
    made = {name: loop(each) for name, each in run.looked_into.items()}
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
        frequency, amplitude = np.asarray(curve.frequency), 1e6 * np.asarray(curve.amplitude)
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


def loop(found: CaseResult) -> list[Plot]:
    """The loop of the contact with the most friction work."""
    energy = np.where(found.top.state[0] == ELEMENT, 0.0, found.wear.energy)
    if not energy.any() or not exact(found.top):
        return []
    contact = int(energy.argmax())
    names = tangents(found.given, found.places.joint[contact])
    turned = Loop(found.top, contact, names)
    displacement, force = turned.history
    closed = np.append(np.arange(0, len(force), STEP), 0)
    u, t, bound = 1e6 * displacement[closed], force[closed], turned.bound[closed]
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
    case = "" if found.name == "nominal" else f", {words(found.name)}"
    return [
        Plot(
            traces,
            "relative displacement (µm)",
            "friction force (N)",
            f"Hysteresis of {found.places.names[contact]}{case}",
            f"The contact that dissipates most, {1e6 * energy[contact]:.3g} µJ per cycle at "
            f"{found.at_peak.frequency:.2f} Hz, in both friction directions. The area of a loop is "
            "the energy dissipated in that direction.",
            y_from_zero=False,
        )
    ]
