"""Drawing of a casing sector with the name and value of each of its dimensions."""

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from drawings import drafting
from drawings.captions import caption, millimetres
from drawings.drafting import DrawingView, Label
from drawings.sections import box, polar, revolved, ring_piece
from vanelock.mesh import CasingDimensions, VaneDimensions
from vanelock.mesh.geometry import contact_places
from vanelock.mesh.geometry.revolved import casing_outline, hooks_outline
from vanelock.render import style

WIDTH: Final = 18.0  # inches
HEIGHT: Final = 11.7


def casing_sheet(vane: VaneDimensions, casing: CasingDimensions, sectors: int, name: str) -> Figure:
    """The sheet; the vane is drawn pale."""
    subtitle = (
        f"{name}: one of {sectors} sectors. Lengths in mm; z counts from the front face; the rear "
        "rail mirrors the front one about vane.hook.mid_plane."
    )
    with style.applied():
        figure = style.figure(HEIGHT, "Casing sector", subtitle, WIDTH)
        _meridional(figure, casing, vane)
        _outside(figure, casing, sectors)
        _groove(figure, casing, vane)
        _front(figure, casing, sectors)
    return figure


def _meridional(figure: Figure, casing: CasingDimensions, vane: VaneDimensions) -> None:
    hook = vane.hook
    low = (-2.0, 1e3 * min(casing.rail_inner_radius, vane.outer_shroud_inner_radius) - 10)
    top = max(casing.flange_radius, casing.outer_radius + casing.boss_height)
    high = (1e3 * casing.length + 2, 1e3 * top + 5)
    panel = (0.35, 5.4, 10.7, HEIGHT - 6.4)
    view = drafting.view(figure, panel, (2.3, 0.3, 0.2, 2.3), low, high, "Meridional section")
    drafting.area(view, revolved(hooks_outline(vane)), "vane", pale=True)
    drafting.area(view, revolved(casing_outline(casing, hook)), "casing")
    middle = 1e3 * hook.mid_plane
    drafting.stroke(view, [(middle, low[1]), (middle, high[1])], "centre")
    rim = casing.flange_radius
    thick = drafting.distance(
        view, (0, 1e3 * rim), (1e3 * casing.flange_thickness, 1e3 * rim), 0.12
    )
    rail = casing.rail_inner_radius
    drafting.margin(
        view,
        "top",
        [
            Label(caption(casing, "flange_thickness"), thick),
            *_boss_sideways(view, casing),
            *(
                Label(caption(casing, name), (1e3 * getattr(casing, name), 1e3 * r), True)
                for name, r in (
                    ("rail_front", rail),
                    ("groove_bottom", hook.roof_radius),
                    ("groove_mouth", rail),
                    ("length", rim),
                )
            ),
            Label(
                caption(vane, "hook.mid_plane", "vane."), (middle, 1e3 * casing.outer_radius), True
            ),
        ],
    )
    front = 1e3 * casing.rail_front
    drafting.margin(
        view,
        "left",
        [
            Label(caption(casing, name), (z, 1e3 * getattr(casing, name)), True)
            for name, z in (
                ("rail_inner_radius", front),
                ("inner_radius", 0.0),
                ("outer_radius", 1e3 * casing.flange_thickness),
                ("flange_radius", 0.0),
            )
        ],
    )


def _boss_sideways(view: DrawingView, casing: CasingDimensions) -> list[Label]:
    """A boss on the shell; dashed where the sector has none."""
    at, radius = 1e3 * casing.boss_position, 500 * casing.boss_diameter
    low, high = 1e3 * casing.outer_radius, 1e3 * (casing.outer_radius + casing.boss_height)
    corners = box(at - radius, at + radius, low, high)
    if casing.bosses:
        drafting.area(view, corners, "casing")
    else:
        drafting.stroke(view, [*corners, corners[0]], "hidden")
    side = at + 0.6 * radius
    arrow = drafting.distance(view, (side, low), (side, high))
    return [
        Label(caption(casing, "boss_position"), (at, high), True),
        Label(caption(casing, "boss_height"), arrow),
    ]


def _groove(figure: Figure, casing: CasingDimensions, vane: VaneDimensions) -> None:
    """The front groove with the foot in it."""
    hook = vane.hook
    low = (
        1e3 * casing.rail_front - 3,
        1e3 * min(casing.rail_inner_radius, vane.outer_shroud_outer_radius) - 3,
    )
    high = (1e3 * vane.leg_rear + 5, 1e3 * casing.outer_radius + 2)
    panel = (0.35, 0.3, 8.9, 5.0)
    view = drafting.view(figure, panel, (2.6, 2.4, 0.1, 2.3), low, high, "Front groove and foot")
    drafting.area(view, revolved(hooks_outline(vane)), "vane", pale=True)
    drafting.area(view, revolved(casing_outline(casing, hook)), "casing")
    band = 1e3 * hook.band_position
    lip, roof = 1e3 * hook.lip_radius, 1e3 * hook.roof_radius
    drafting.dots(view, [(band, roof), (band, lip)], style.VERMILION, 6)
    drafting.margin(
        view,
        "top",
        [
            Label(caption(casing, name), (1e3 * getattr(casing, name), r), True)
            for name, r in (
                ("rail_front", 1e3 * casing.inner_radius),
                ("groove_bottom", roof),
                ("groove_mouth", lip),
            )
        ]
        + [Label(caption(vane, "hook.band_position", "vane."), (band, lip), True)],
    )
    rail = 1e3 * casing.rail_inner_radius
    bottom = 1e3 * casing.groove_bottom
    drafting.margin(
        view,
        "left",
        [
            Label(caption(vane, "hook.roof_radius", "vane."), (bottom, roof), True),
            Label(caption(vane, "hook.lip_radius", "vane."), (bottom, lip), True),
            Label(
                caption(casing, "rail_inner_radius"),
                (1e3 * casing.rail_front, rail),
                True,
            ),
            Label(
                caption(casing, "inner_radius"),
                (1e3 * casing.rail_front, 1e3 * casing.inner_radius),
                True,
            ),
            Label(
                caption(casing, "outer_radius"),
                (low[0], 1e3 * casing.outer_radius),
                True,
            ),
        ],
    )
    corner = (1e3 * casing.groove_mouth, 1e3 * casing.inner_radius)
    fillet = Label(caption(casing, "fillet"), corner)
    drafting.margin(view, "right", [*_clearances(view, casing, vane), fillet])


def _clearances(view: DrawingView, casing: CasingDimensions, vane: VaneDimensions) -> list[Label]:
    """What stays free between the foot and its groove."""
    hook = vane.hook
    lip, roof = hook.lip_radius, hook.roof_radius
    shroud, rail = vane.outer_shroud_outer_radius, casing.rail_inner_radius
    inside = (casing.rail_front + casing.groove_mouth) / 2
    middle = (lip + roof) / 2
    gaps = (
        ("foot to bottom", (casing.groove_bottom, middle), (vane.foot_front, middle)),
        (
            "leg to mouth",
            (casing.groove_mouth, (lip + rail) / 2),
            (vane.leg_front, (lip + rail) / 2),
        ),
        ("shroud to rail", (inside, shroud), (inside, rail)),
        (
            "foot to shell",
            (vane.leg_rear - 1e-3, roof),
            (vane.leg_rear - 1e-3, casing.inner_radius),
        ),
    )
    labels = []
    for what, start, end in gaps:
        free = float(np.hypot(end[0] - start[0], end[1] - start[1]))
        at = drafting.distance(view, 1e3 * np.array(start), 1e3 * np.array(end))
        labels.append(Label(f"{what}: {millimetres(free)} clear", at))
    return labels


def _outside(figure: Figure, casing: CasingDimensions, sectors: int) -> None:
    """The shell from outside, developed at its outer radius."""
    radius, half = casing.outer_radius, np.pi / sectors
    wide, long = 1e3 * radius * half, 1e3 * casing.length
    panel = (11.15, 5.4, 6.5, HEIGHT - 6.4)
    title = "From outside, developed"
    view = drafting.view(figure, panel, (0.1, 2.5, 0.4, 0.45), (-wide, 0), (wide, long), title)
    drafting.area(view, box(-wide, wide, 0, long), "casing")
    thick = 1e3 * casing.flange_thickness
    for z in (thick, long - thick):
        drafting.stroke(view, [(-wide, z), (wide, z)])
    labels = []
    for points, colour, text in (
        (contact_places.force_points(casing, sectors), style.BLUE, caption(casing, "force_nodes")),
        (contact_places.casing_output_points(casing, sectors), style.PURPLE, "output nodes"),
    ):
        angle = np.arctan2(points[:, 1], points[:, 0])
        flat_ = 1e3 * np.stack([radius * angle, points[:, 2]], -1)
        drafting.dots(view, flat_, colour, 5)
        labels.append(Label(text, tuple(flat_[flat_[:, 0].argmax()])))
    labels += _bosses(view, casing, sectors)
    at = drafting.distance(view, (-wide, 0), (wide, 0), -0.25)
    labels.append(Label(f"pitch {2 * np.degrees(half):.6g}° = 360°/{sectors}", (wide, at[1])))
    drafting.margin(view, "right", labels)


def _bosses(view: DrawingView, casing: CasingDimensions, sectors: int) -> list[Label]:
    """The bosses from outside; one, dashed, where the sector has none."""
    angles = contact_places.boss_angles(casing, sectors) if casing.bosses else np.zeros(1)
    around = np.linspace(0, 2 * np.pi, 73)
    radius = 500 * casing.boss_diameter
    circle = radius * np.stack([np.cos(around), np.sin(around)], -1)
    for angle in angles:
        centre = np.array([1e3 * casing.outer_radius * angle, 1e3 * casing.boss_position])
        if casing.bosses:
            drafting.area(view, centre + circle, "casing")
        else:
            drafting.stroke(view, centre + circle, "hidden")
    across = np.array([radius, 0])
    none = "" if casing.bosses else ", shown dashed"
    arrow = drafting.distance(view, centre - across, centre + across)
    return [
        Label(caption(casing, "boss_diameter"), arrow),
        Label(caption(casing, "bosses") + none, tuple(centre + circle[6])),
    ]


def _front(figure: Figure, casing: CasingDimensions, sectors: int) -> None:
    """The sector from the front."""
    half = np.pi / sectors
    rim, rail = casing.flange_radius, casing.rail_inner_radius
    wide = 1e3 * rim * np.sin(half) + 2
    low, high = (-wide, 1e3 * rail * np.cos(half) - 2), (wide, 1e3 * rim + 12)
    panel = (9.35, 0.3, 8.3, 4.9)
    view = drafting.view(figure, panel, (0.1, 2.4, 0.1, 0.45), low, high, "From the front")
    drafting.area(view, ring_piece(rail, casing.inner_radius, half), "casing")
    drafting.area(view, ring_piece(casing.inner_radius, rim, half), "casing")
    labels = [
        Label(caption(casing, name), polar(getattr(casing, name), angle * half))
        for name, angle in (
            ("rail_inner_radius", 0.9),
            ("inner_radius", 0.9),
            ("flange_radius", 0.9),
        )
    ]
    degrees = np.degrees(half)
    at = drafting.sweep(view, (0, 0), 1e3 * rim + 7, 90 + degrees, 90 - degrees, 0.9)
    labels.append(Label(f"pitch {2 * degrees:.6g}°", at))
    drafting.margin(view, "right", labels)
