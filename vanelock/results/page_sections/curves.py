"""Curves and loops on a run's page, to zoom into."""

from collections.abc import Sequence

import numpy as np

from vanelock import nonlinear, render
from vanelock.input.cases.names import words
from vanelock.input.measured import DISPLACEMENT
from vanelock.quantities.answers import CaseAnswers
from vanelock.quantities.contacts.wear import exact
from vanelock.quantities.curves_and_fields import Drawn
from vanelock.quantities.selection import PERCENT, band, drawn_alone
from vanelock.report import Plot, Section, Trace
from vanelock.report.blocks import Block
from vanelock.results.figures.curves import linear
from vanelock.results.page_sections.content import PageContent
from vanelock.stages.plan import Planned

MOST_GAUGES = 6
"""Gauges whose curves are on the page."""
STEP = 4
"""Of the samples of a loop, every so many are on the page."""


def curves(told: PageContent, further: Sequence[Trace] = ()) -> Section:
    """Response curves of all cases with their linear limits, and loops.

    Parameters
    ----------
    told : PageContent
        The run.
    further : sequence of Trace
        What else is laid over the curves, besides measured ones.
    """
    blocks: list[Block] = [response_plot(told, further)]
    blocks += gauges(told)
    blocks += [loop for each in told.answers.values() for loop in loops(each)]
    return Section("Curves", blocks, id="curves")


def response_plot(told: PageContent, further: Sequence[Trace] = ()) -> Plot:
    """Amplitude over frequency of every case."""
    run_data = told.run_data
    shade, alone = band(run_data), drawn_alone(run_data)
    colours = _colours(alone)
    limits = linear(run_data)
    greys = render.style.greys(each.group for each in limits)
    traces = [] if shade is None else _shaded(shade)
    traces += [
        Trace(
            np.asarray(each.frequency, float),
            1e6 * np.asarray(each.amplitude, float),
            each.label,
            dash="dash" if each.kind == "free" else "dot",
            width=1.5,
            colour=colours.get(each.group, greys[each.group]),
        )
        for each in limits
    ]
    for each in alone:
        name = each.case.name
        listed = each.case.given.response.frequencies is not None
        own = words(name) if name != "nominal" else "with friction"
        for i, (direction, curve) in enumerate(run_data.shown.curves(name).items()):
            label = f"{own}, {direction}" if direction else own
            traces += _drawn(curve, label, colours[words(name)], listed, i > 0)
    traces += [
        Trace(each.frequency, 1e6 * each.amplitude, each.label, mode="markers", colour="#1a1a1a")
        for each in run_data.shown.measured
        if each.quantity == DISPLACEMENT
    ]
    data = (run_data.output_files.folder / "figures" / "response.csv",)
    lines = (
        f"Dashed and dotted: linear, {run_data.shown.opens} free and stuck."
        if run_data.shown.opens
        else "Dashed: linear."
    )
    return Plot(
        [*traces, *further],
        "frequency (Hz)",
        "amplitude (µm)",
        "Forced response",
        f"Half the peak-to-peak of {told.monitor}. {lines} Click a name in the legend to hide its "
        "curve, twice to see it alone.",
        data=[path for path in data if path.exists()],
    )


def _drawn(curve: Drawn, label: str, colour: str, listed: bool, second: bool) -> list[Trace]:
    """A response, and its points that did not converge; the second of a case in dashes."""
    frequency, amplitude, converged = curve
    order = np.argsort(frequency, kind="stable")
    height = np.where(converged, 1e6 * amplitude, np.nan)[order]
    made = [
        Trace(
            frequency[order],
            height,
            label,
            mode="lines+markers" if listed else "lines",
            dash="dashdot" if second else "solid",
            colour=colour,
        )
    ]
    lost = ~converged
    if lost.any():
        label = f"{label}: did not converge"
        heights = 1e6 * amplitude[lost]
        made.append(Trace(frequency[lost], heights, label, mode="markers", colour="#d55e00"))
    return made


def _colours(alone: Sequence[Planned]) -> dict[str, str]:
    """Colours of the responses by case, in words; linear curves of one case share its colour."""
    series = render.style.series(len(alone))
    return {words(each.case.name): str(colour) for each, colour in zip(alone, series, strict=True)}


def _shaded(shade: render.Band) -> list[Trace]:
    """Percentiles of many curves: two bands, the wider one below, and the median."""
    levels = dict(zip(PERCENT, 1e6 * shade.levels, strict=True))
    around = np.concatenate([shade.frequency, shade.frequency[::-1]])
    made = [
        Trace(
            around,
            np.concatenate([levels[low], levels[high][::-1]]),
            f"{low} to {high} % of {shade.label}",
            colour=str(render.style.BLUE),
            fill=opacity,
        )
        for low, high, opacity in ((5, 95, 0.15), (25, 75, 0.3))
    ]
    middle = Trace(
        shade.frequency, levels[50], f"median of {shade.label}", width=3.0, colour="#1a1a1a"
    )
    return [*made, middle]


def gauges(told: PageContent) -> list[Plot]:
    """Strain over frequency of every gauge in the cases that are looked into."""
    stages, traces = told.run_data.stages, []
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
