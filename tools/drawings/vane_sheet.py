"""Drawing of a vane segment with the name and value of each of its dimensions."""

from typing import Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from drawings import drafting
from drawings.aerofoil_view import profile_view
from drawings.captions import caption
from drawings.drafting import DrawingView, Label, Panel
from drawings.sections import flat, revolved, section
from drawings.segment_views import front_view, inner_view, outer_view
from vanelock.mesh import CasingDimensions, VaneDimensions
from vanelock.mesh.geometry.revolved import casing_outline, hooks_outline, inner_shroud_outline
from vanelock.mesh.geometry.root_fillet import filleted
from vanelock.render import style

Real = NDArray[np.float64]

WIDTH: Final = 18.0  # inches
HEIGHT: Final = 11.7


def vane_sheet(vane: VaneDimensions, casing: CasingDimensions, sectors: int, name: str) -> Figure:
    """The sheet; the casing is drawn pale."""
    vane = filleted(vane, sectors)
    subtitle = (
        f"{name}: one of {sectors} segments. Lengths in mm; z counts from the casing's front face; "
        "the rear hook mirrors the front one about hook.mid_plane."
    )
    with style.applied():
        figure = style.figure(HEIGHT, "Vane segment", subtitle, WIDTH)
        _meridional(figure, (0.35, 0.3, 5.3, 10.4), vane, casing)
        front_view(figure, (5.8, 5.4, 5.95, 5.3), vane, sectors)
        _hook(figure, (5.8, 0.3, 5.95, 4.9), vane, casing)
        outer_view(figure, (11.85, 8.1, 5.85, 2.6), vane, sectors)
        inner_view(figure, (11.85, 5.1, 5.85, 2.8), vane, sectors)
        profile_view(figure, (11.85, 0.3, 5.85, 4.6), vane)
    return figure


def _meridional(
    figure: Figure, panel: Panel, vane: VaneDimensions, casing: CasingDimensions
) -> None:
    front = min(vane.outer_shroud_front, vane.inner_shroud_front, vane.foot_front)
    rear = 2 * vane.hook.mid_plane - front
    inner, roof = vane.inner_shroud_inner_radius, vane.hook.roof_radius
    low, high = (1e3 * front - 4, 1e3 * inner - 4), (1e3 * rear + 4, 1e3 * roof + 16)
    view = drafting.view(figure, panel, (2.7, 0.1, 2.0, 2.3), low, high, "Meridional section")
    drafting.area(view, revolved(casing_outline(casing, vane.hook)), "casing", pale=True)
    _blade_sideways(view, vane)
    drafting.area(view, revolved(hooks_outline(vane)), "vane")
    drafting.area(view, revolved(inner_shroud_outline(vane)), "vane")
    middle = 1e3 * vane.hook.mid_plane
    drafting.stroke(view, [(middle, low[1]), (middle, high[1])], "centre")
    drafting.margin(
        view,
        "left",
        [
            Label(caption(vane, name), (1e3 * vane_z, 1e3 * getattr(vane, name)), True)
            for name, vane_z in (
                ("inner_shroud_inner_radius", vane.inner_shroud_front),
                ("inner_shroud_outer_radius", vane.inner_shroud_front),
                ("outer_shroud_inner_radius", vane.outer_shroud_front),
                ("outer_shroud_outer_radius", vane.outer_shroud_front),
            )
        ]
        + [
            Label(
                caption(vane, "hook.lip_radius"),
                (1e3 * vane.foot_front, 1e3 * vane.hook.lip_radius),
                True,
            ),
            Label(caption(vane, "hook.roof_radius"), (1e3 * vane.foot_front, 1e3 * roof), True),
        ],
    )
    drafting.margin(
        view,
        "top",
        [
            Label(caption(vane, name), (1e3 * z, 1e3 * radius), True)
            for name, z, radius in (
                ("outer_shroud_front", vane.outer_shroud_front, vane.outer_shroud_outer_radius),
                ("foot_front", vane.foot_front, roof),
                ("hook.band_position", vane.hook.band_position, roof),
                ("leg_front", vane.leg_front, vane.hook.lip_radius),
                ("leg_rear", vane.leg_rear, roof),
                ("hook.mid_plane", vane.hook.mid_plane, roof),
            )
        ],
    )
    at = (1e3 * vane.inner_shroud_front, 1e3 * inner)
    drafting.margin(view, "bottom", [Label(caption(vane, "inner_shroud_front"), at, True)])


def _blade_sideways(view: DrawingView, vane: VaneDimensions) -> None:
    """What an aerofoil covers, seen along the circumference."""
    alongs = np.linspace(vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius, 21)
    axial = [section(vane, along)[:, 1] + vane.hook.mid_plane for along in alongs]
    front = [(along, z.min()) for along, z in zip(alongs, axial, strict=True)]
    rear = [(along, z.max()) for along, z in zip(alongs, axial, strict=True)]
    drafting.area(view, flat([*front, *reversed(rear)]), "vane")


def _hook(figure: Figure, panel: Panel, vane: VaneDimensions, casing: CasingDimensions) -> None:
    """The front hook in its groove."""
    hook = vane.hook
    front = min(vane.foot_front, vane.outer_shroud_front, casing.groove_bottom)
    low = (1e3 * front - 3, 1e3 * vane.outer_shroud_inner_radius - 2)
    high = (1e3 * vane.leg_rear + 6, 1e3 * casing.inner_radius + 2)
    view = drafting.view(
        figure, panel, (2.7, 0.95, 0.15, 2.2), low, high, "Front hook in its groove"
    )
    drafting.area(view, revolved(casing_outline(casing, hook)), "casing", pale=True)
    drafting.area(view, revolved(hooks_outline(vane)), "vane")
    band = 1e3 * hook.band_position
    drafting.dots(
        view, [(band, 1e3 * hook.roof_radius), (band, 1e3 * hook.lip_radius)], style.VERMILION, 6
    )
    drafting.margin(
        view,
        "top",
        [
            Label(caption(vane, name), (1e3 * z, 1e3 * radius), True)
            for name, z, radius in (
                ("foot_front", vane.foot_front, hook.lip_radius),
                ("hook.band_position", hook.band_position, hook.lip_radius),
                ("leg_front", vane.leg_front, hook.lip_radius),
                ("leg_rear", vane.leg_rear, hook.roof_radius),
            )
        ],
    )
    drafting.margin(
        view,
        "left",
        [
            Label(caption(vane, name), (1e3 * vane.foot_front, 1e3 * radius), True)
            for name, radius in (
                ("hook.roof_radius", hook.roof_radius),
                ("hook.lip_radius", hook.lip_radius),
            )
        ]
        + [
            Label(caption(vane, name), (1e3 * vane.leg_front, 1e3 * getattr(vane, name)), True)
            for name in ("outer_shroud_outer_radius", "outer_shroud_inner_radius")
        ],
    )
    corner = (1e3 * vane.leg_rear, 1e3 * vane.outer_shroud_outer_radius)
    drafting.margin(view, "right", [Label(caption(vane, "fillet"), corner)])
