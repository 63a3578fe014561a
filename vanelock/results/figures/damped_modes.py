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
    frequency, damping = list[render.PanelCurve](), list[render.PanelCurve]()
    for mode in found:
        called, curve = called_of(mode), mode.mode
        assert curve is not None
        size = amplitude(mode, curve)
        seen = size > BEGIN * size.max()
        ratio = curve.frequency[seen] / curve.linear[0]
        frequency.append(render.PanelCurve(called, size[seen], ratio))
        percent = 100 * curve.damping_ratio[seen]
        damping.append(render.PanelCurve(called, size[seen], percent))
        if (air := _air(each, mode, curve)) is not None:
            damping.append(render.PanelCurve(called, size[seen], 100 * air[seen], dashed=True))
    panels = (
        render.CurvePanel("frequency, of that at rest", frequency),
        render.CurvePanel("damping ratio (%)", damping, from_zero=True),
    )
    path = run_data.output_files.draw(
        f"figures/damped_modes_{slug(name)}.png",
        shows,
        lambda path: render.panels_picture(
            path, panels, "amplitude (µm)", title, subtitle, logarithmic=True
        ),
    )
    notes = [f"{title}; {subtitle}"]
    data = run_data.table(
        f"figures/damped_modes_{slug(name)}.csv", shows, lambda: _columns(found), notes
    )
    driven = any(mode.driven is not None for mode in found)
    caption = (
        f"Natural frequency and damping ratio{of_case(name)}, of structure and friction together, "
        "from small vibration with the contacts stuck to gross slip."
        " The table has frequencies in Hz."
    ) + (
        " Dashed: what the air takes away. Where a full line crosses its dashed one upwards the "
        "vibration settles, where downwards a larger one grows without end."
        if driven
        else ""
    )
    return [Picture(path, DAMPED, caption, (data,))]


def called_of(mode: FollowedMode) -> str:
    """What a legend calls a mode."""
    return f"mode {mode.number}, ND {mode.nodal_diameter}"


def amplitude(mode: FollowedMode, curve: DampedMode) -> NDArray[np.float64]:
    """(p,) the monitored displacement, µm."""
    return np.asarray(1e6 * curve.response.amplitude[:, mode.node, mode.component])


def _air(each: Planned, mode: FollowedMode, curve: DampedMode) -> NDArray[np.float64] | None:
    """(p,) damping ratio that the air takes away; None where none is given."""
    keys, N = each.case.study.damped_modes, each.case.study.ring.sectors
    if keys is None or (air := keys.air) is None:
        return None
    at = mode.nodal_diameter % N
    by = [-aerodynamic_damping(air, N, float(hertz))[at] for hertz in curve.frequency]
    return np.array(by)


def _columns(found: list[FollowedMode]) -> dict[str, ArrayLike]:
    known = [(mode, curve) for mode in found if (curve := mode.mode) is not None]
    counts = [len(curve.frequency) for _, curve in known]
    numbers = [[mode.nodal_diameter, mode.number] for mode, _ in known]
    diameter, number = np.repeat(np.array(numbers), counts, axis=0).T
    return {
        "nodal diameter": diameter,
        "mode": number,
        "modal amplitude (kg^0.5 m)": np.concatenate([curve.amplitude for _, curve in known]),
        "amplitude (µm)": np.concatenate([amplitude(*each) for each in known]),
        "frequency (Hz)": np.concatenate([curve.frequency for _, curve in known]),
        "damping ratio (%)": np.concatenate([100 * curve.damping_ratio for _, curve in known]),
    }
