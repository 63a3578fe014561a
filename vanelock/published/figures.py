"""The figures of the published study: curves over the reference response, and loops.

Frequencies and amplitudes are over the resonance frequency and the peak of the reference, the
linear response with the hooks stuck and the interlock free at the same load.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vanelock import render
from vanelock.input.schema.study import Study
from vanelock.published.conditions import PrescribedLoop
from vanelock.published.evidence import Evidence
from vanelock.published.sheets import case_of
from vanelock.quantities.curves_and_fields import RunData
from vanelock.report import Picture
from vanelock.results.figures.curve_table import columns

REFERENCE = (
    "Frequency and amplitude are over those of the linear resonance with the hooks stuck and the "
    "interlock free at the same load. "
)


@dataclass(frozen=True)
class CurveSheet:
    """A figure to be drawn.

    Attributes
    ----------
    name : str
        Of its files.
    title, caption : str
    curves : sequence of Curve
        In Hz and m.
    """

    name: str
    title: str
    caption: str
    curves: Sequence[render.Curve]


def reference(e: Evidence) -> render.MarkedPeak:
    """What curves are shown over."""
    peak = e.linear["free"]
    return render.MarkedPeak(peak.frequency, peak.amplitude, False)


def curve_sheets(run_data: RunData, e: Evidence) -> list[CurveSheet]:
    """Figures 10 to 16 of the study."""
    friction, pressed = e.plan.sheets["friction"].cases, e.plan.sheets["interference"].cases
    only = [name for name in friction if _study(e, name).response.coupling == "coupled"]
    pressed_only = [name for name in pressed if _study(e, name).response.coupling == "coupled"]
    limits = [_limit(run_data, "free"), _limit(run_data, "stuck")]
    small = [
        replace(_curve(run_data, e, name, ""), amplitude=np.asarray(curve) / e.small)
        for name in e.plan.sheets["stuck"].cases
        for curve in [run_data.shown.curve[name][1]]
    ]
    hooks = _curve(
        run_data, e, e.plan.sheets["hooks"].cases[0], "hooks in friction, interlock apart"
    )
    largest = e.plan.base.campaign.mu[-1] if e.plan.base.campaign else 0.0
    return [
        CurveSheet(
            "fig10_hooks",
            "Figure 10: hook joints alone",
            "Hooks in friction and the interlock apart, against the linear response with the hooks "
            f"stuck. They differ by {e.hooks.vibration:.0e} of the peak: nothing slips.",
            [limits[0], hooks],
        ),
        CurveSheet(
            "fig11_stuck",
            "Figure 11: hooks and interlock stuck",
            f"At {e.small:g} of the load every contact sticks: static and dynamic balance do not "
            "touch, and the three methods coincide. Amplitudes are for the full load, in "
            "proportion. The resonance lies higher than with the interlock free.",
            [*limits, *small],
        ),
        CurveSheet(
            "fig12_friction",
            "Figure 12: friction coefficient",
            "Coupled responses with one harmonic. The peak falls as friction grows, as long as "
            "friction is below what damps best.",
            [*limits, *(_curve(run_data, e, name, _mu(e, name), "") for name in only)],
        ),
        CurveSheet(
            "fig13_harmonics",
            "Figure 13: number of harmonics",
            "Coupled responses at the reference friction. Dashed and dotted lines give every "
            "harmonic the nodal diameter of the load instead of its own.",
            [
                _curve(run_data, e, name, _order(e, name), _diameters(e, name))
                for name in e.plan.sheets["harmonics"].cases
            ],
        ),
        CurveSheet(
            "fig14_interference",
            "Figure 14: interlock interference",
            f"Coupled responses with one harmonic at μ = {largest:g}.",
            [*limits, *(_curve(run_data, e, name, _pressed(e, name), "") for name in pressed_only)],
        ),
        CurveSheet(
            "fig15_coupling_friction",
            "Figure 15: coupled and uncoupled, friction coefficient",
            "Full lines: static and dynamic balance together. Dashed: the static state held while "
            "normal forces vary about it (uncoupled). Dotted: friction bounded by the forces at "
            "rest (constant-load).",
            [_curve(run_data, e, name, _mu(e, name)) for name in friction],
        ),
        CurveSheet(
            "fig16_coupling_interference",
            "Figure 16: coupled and uncoupled, interlock interference",
            f"As Figure 15, at μ = {largest:g}.",
            [_curve(run_data, e, name, _pressed(e, name)) for name in pressed],
        ),
    ]


def draw_sheet(run_data: RunData, e: Evidence, sheet: CurveSheet) -> Picture:
    """A figure over the reference, and its data in Hz and µm."""
    base = reference(e)
    keys = {each.case.name: each.response.key for each in run_data.planned}
    shows = [sheet.title, keys, base.frequency, base.amplitude, e.monitor, e.small]
    path = run_data.output_files.draw(
        f"figures/{sheet.name}.png",
        shows,
        lambda path: render.response_curves(
            path, sheet.curves, sheet.title, e.monitor, reference=base
        ),
    )
    notes = [
        sheet.title,
        f"reference: {base.frequency:.9g} Hz, {1e6 * base.amplitude:.9g} um",
    ]
    data = run_data.table(
        f"figures/{sheet.name}.csv", shows, lambda: columns(list(sheet.curves)), notes
    )
    return Picture(path, sheet.title, REFERENCE + sheet.caption, (data,))


def loop_pictures(run_data: RunData, e: Evidence) -> list[Picture]:
    """Figure 8: the loops of the contact element in three conditions."""
    return [_loop(run_data, e, loop) for loop in e.conditions]


def _loop(run_data: RunData, e: Evidence, loop: PrescribedLoop) -> Picture:
    joint = e.plan.base.joints.interlock
    name = f"figures/fig08_loop_{loop.title.replace(' ', '_')}"
    title = f"Figure 8: loop {loop.title}"
    subtitle = f"μ = {loop.mu:g}, kn = {joint.kn:g} N/m, kt = {joint.kt:g} N/m, motion given"
    thin = slice(None, None, 4)
    displacement, force = loop.displacement[thin], loop.force[thin]
    shows = [title, subtitle, displacement.tolist(), force.tolist()]
    path = run_data.output_files.draw(
        f"{name}.png",
        shows,
        lambda path: render.loop_picture(path, displacement, force, loop.mu, title, subtitle, 1),
    )
    columns = {
        "time / period": np.arange(len(force)) / len(force),
        "normal displacement (µm)": 1e6 * displacement[:, 0],
        "sliding (µm)": 1e6 * displacement[:, 1],
        "normal force (N)": force[:, 0],
        "friction force (N)": force[:, 1],
    }
    data = run_data.table(f"{name}.csv", shows, lambda: columns, [title, subtitle])
    caption = (
        f"The contact element under given harmonic motion, {loop.title}. Friction takes "
        f"{1e6 * loop.energy:.3g} µJ a cycle."
    )
    return Picture(path, title, caption, (data,))


def _study(e: Evidence, name: str) -> Study:
    return e.plan.study(name)


def _mu(e: Evidence, name: str) -> str:
    return f"μ = {_study(e, name).joints.interlock.mu:g}"


def _order(e: Evidence, name: str) -> str:
    return f"H = {_study(e, name).response.harmonics}"


def _pressed(e: Evidence, name: str) -> str:
    return f"interference {1e6 * _study(e, name).joints.interlock.interference:g} µm"


def _diameters(e: Evidence, name: str) -> str:
    wave = _study(e, name).response.harmonic_diameters == "wave"
    return "own diameters" if wave else "one diameter"


def _curve(
    run_data: RunData, e: Evidence, name: str, group: str, variant: str | None = None
) -> render.Curve:
    """A case's curve; the line style shows the coupling unless one is given."""
    frequency, amplitude, converged = run_data.shown.curve[name]
    text = _study(e, name).response.coupling if variant is None else variant
    return render.Curve(frequency, amplitude, group, None, converged, variant=text, case=name)


def _limit(run_data: RunData, which: str) -> render.Curve:
    """A linear limit at the full load."""
    for (_, other), (frequency, amplitude) in run_data.shown.linear.items():
        if other == which:  # the first one: the reference case is planned first
            return render.Curve(frequency, amplitude, kind=other)
    raise KeyError(which)


def reference_case(e: Evidence) -> str:
    """Name of the case that everything is varied around."""
    return case_of(e.plan)
