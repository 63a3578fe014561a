"""Frequency and damping ratio of a case's damped modes against amplitude, and what the air adds."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock import render
from vanelock.input.cases.names import of_case, slug
from vanelock.nonlinear import DampedMode, aerodynamic_damping
from vanelock.quantities.curves_and_fields import RunData
from vanelock.report import Picture
from vanelock.stages.assessment.damped_modes import FollowedMode
from vanelock.stages.plan import Planned

DAMPED = "Damped modes"
"""Title of these pictures."""
BEGIN = 1e-3
"""Least amplitude shown, of the largest: below it nothing changes."""


def damped_modes(run_data: RunData, each: Planned) -> list[Picture]:
    """The modes of a case that were followed."""
    steps, name = each.damped_modes, each.case.name
    found = [mode for step in steps if (mode := run_data.stages.get(step)).mode is not None]
    if not found:
        return []
    title = f"Damped modes{of_case(name)}"
    subtitle = f"over half the peak-to-peak of {run_data.shown.monitor.name}"
    shows = [*(step.key for step in steps), title, subtitle]
    frequency, damping, total = (list[render.PanelCurve]() for _ in range(3))
    for mode in found:
        called, curve = called_of(mode), mode.mode
        assert curve is not None
        size = amplitude(mode, curve)
        seen = size > BEGIN * size.max()
        ratio = curve.frequency[seen] / curve.linear[0]
        frequency.append(render.PanelCurve(called, size[seen], ratio))
        percent = 100 * curve.damping_ratio[seen]
        damping.append(render.PanelCurve(called, size[seen], percent))
        if mode.driven is not None:
            sizes = 1e6 * mode.driven.output[:, mode.node, mode.component]
            cycles = [
                (float(x), 0.0, bool(s))
                for x, s in zip(sizes, mode.driven.amplitude_stable, strict=True)
            ]
            with_air = percent + 100 * _air(each, mode, curve)[seen]
            total.append(render.PanelCurve(called, size[seen], with_air, cycles))
    panels = [
        render.CurvePanel("frequency ratio", frequency),
        render.CurvePanel("damping ratio (%)", damping, from_zero=True),
    ]
    if total:
        panels.append(render.CurvePanel("with the air (%)", total, from_zero=True))
    path = run_data.output_files.draw(
        f"figures/damped_modes_{slug(name)}.png",
        shows,
        lambda path: render.panels_picture(
            path, panels, "amplitude (µm)", title, subtitle, logarithmic=True
        ),
    )
    notes = [f"{title}; {subtitle}"]
    data = run_data.table(
        f"figures/damped_modes_{slug(name)}.csv", shows, lambda: _columns(each, found), notes
    )
    caption = (
        f"Natural frequency and damping ratio{of_case(name)}, of structure and friction together, "
        "from small vibration with the contacts stuck to gross slip, as far as each was followed "
        "(dot); frequencies over those at rest. The table has them in Hz."
    ) + (
        " Below, the damping of the air is in it: where it is negative vibration grows. Its "
        "amplitude settles at full circles; beyond open ones it grows without end."
        if total
        else ""
    )
    return [Picture(path, DAMPED, caption, (data,))]


def called_of(mode: FollowedMode) -> str:
    """What a legend calls a mode."""
    return f"mode {mode.number}, ND {mode.nodal_diameter}"


def amplitude(mode: FollowedMode, curve: DampedMode) -> NDArray[np.float64]:
    """(p,) the monitored displacement, µm."""
    return np.asarray(1e6 * curve.response.amplitude[:, mode.node, mode.component])


def _air(each: Planned, mode: FollowedMode, curve: DampedMode) -> NDArray[np.float64]:
    """(p,) damping ratio of the air, negative where it drives; zero where none is given."""
    keys, N = each.case.study.damped_modes, each.case.study.ring.sectors
    if keys is None or (air := keys.air) is None:
        return np.zeros(len(curve.frequency))
    at = mode.nodal_diameter % N
    by = [aerodynamic_damping(air, N, float(hertz))[at] for hertz in curve.frequency]
    return np.array(by)


def _columns(each: Planned, found: list[FollowedMode]) -> dict[str, ArrayLike]:
    known = [(mode, curve) for mode in found if (curve := mode.mode) is not None]
    counts = [len(curve.frequency) for _, curve in known]
    numbers = [[mode.nodal_diameter, mode.number] for mode, _ in known]
    diameter, number = np.repeat(np.array(numbers), counts, axis=0).T
    columns: dict[str, ArrayLike] = {
        "nodal diameter": diameter,
        "mode": number,
        "modal amplitude (kg^0.5 m)": np.concatenate([curve.amplitude for _, curve in known]),
        "amplitude (µm)": np.concatenate([amplitude(*one) for one in known]),
        "frequency (Hz)": np.concatenate([curve.frequency for _, curve in known]),
        "damping ratio (%)": np.concatenate([100 * curve.damping_ratio for _, curve in known]),
    }
    if any(mode.driven is not None for mode in found):
        air = [100 * _air(each, mode, curve) for mode, curve in known]
        columns["damping ratio of the air (%)"] = np.concatenate(air)
    return columns
