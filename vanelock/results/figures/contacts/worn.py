"""Amplitude, preload and worn depth of a case over the cycles of its dwells."""

import numpy as np
from numpy.typing import ArrayLike

from vanelock import render
from vanelock.input.cases.names import of_case, slug
from vanelock.nonlinear import WearHistory
from vanelock.nonlinear.following.wear.wear_history import DONE
from vanelock.quantities.contacts.wear import HOUR
from vanelock.quantities.curves_and_fields import RunData
from vanelock.report import Picture
from vanelock.stages.plan import Planned

WORN = "Wear over cycles"
"""Title of these pictures."""


def worn(run_data: RunData, each: Planned) -> list[Picture]:
    """The wear of a case that was followed."""
    if each.wear is None or (found := run_data.stages.get(each.wear).history) is None:
        return []
    name = each.case.name
    title = f"Wear over cycles{of_case(name)}"
    ended = "" if found.status == DONE else f"; {found.status} at the end"
    subtitle = f"{run_data.shown.monitor.name}{ended}"
    shows = [each.wear.key, title, subtitle]
    depth = 1e6 * found.worn

    def curve(name: str, y: ArrayLike) -> render.PanelCurve:
        return render.PanelCurve(name, found.cycles, y)

    loads = zip(found.joints, found.rest_load.T, strict=True)
    panels = (
        render.CurvePanel("amplitude (µm)", [curve("all", 1e6 * found.amplitude)]),
        render.CurvePanel("load at rest, relative", [curve(j, n / n[0]) for j, n in loads if n[0]]),
        render.CurvePanel(
            "worn depth (µm)",
            [curve("deepest", depth.max(axis=1)), curve("mean", _worn_mean(depth))],
            from_zero=True,
        ),
    )
    changes = found.cycles[1:][np.diff(found.dwell) > 0]
    path = run_data.output_files.draw(
        f"figures/wear_over_cycles_{slug(name)}.png",
        shows,
        lambda path: render.panels_picture(path, panels, "cycles", title, subtitle, marks=changes),
    )
    data = run_data.table(
        f"figures/wear_over_cycles_{slug(name)}.csv", shows, lambda: _columns(found), [title]
    )
    caption = (
        f"Wear{of_case(name)}: the amplitude of the dwell, each joint's load at rest over that "
        "when new, and the depth that both surfaces have lost, of the contact that loses most and "
        "on average over those that wear."
    ) + (" Dotted: where the next dwell begins." if len(changes) else "")
    return [Picture(path, WORN, caption, (data,))]


def _worn_mean(depth: np.ndarray) -> np.ndarray:
    """(s,) mean depth of the contacts that wear."""
    wears = depth[-1] > 0
    return np.asarray(depth[:, wears].mean(axis=1) if wears.any() else depth[:, 0])


def _columns(found: WearHistory) -> dict[str, ArrayLike]:
    depth = 1e6 * found.worn
    return {
        "cycles": found.cycles,
        "time (h)": found.seconds / HOUR,
        "dwell": found.dwell + 1,
        "frequency (Hz)": found.frequency,
        "amplitude (µm)": 1e6 * found.amplitude,
        "jump": found.jump,
        **{f"{j} at rest (N)": n for j, n in zip(found.joints, found.rest_load.T, strict=True)},
        "deepest wear (µm)": depth.max(axis=1),
    }
