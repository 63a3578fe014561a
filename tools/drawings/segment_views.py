"""A vane segment from the front, and its shrouds from outside."""

import numpy as np
from matplotlib.figure import Figure

from drawings import drafting
from drawings.captions import caption
from drawings.drafting import DrawingView, Label, Panel, Stroke
from drawings.sections import Real, box, polar, ring_piece, root_fillets, section
from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry import aerofoil, contact_places
from vanelock.render import style

SHOWN = 12.0
"""Degrees by which an angle that is zero is drawn, so that its sign can be seen."""


def front_view(figure: Figure, panel: Panel, vane: VaneDimensions, sectors: int) -> None:
    """Seen from the front; the blades are cut at mid-chord."""
    pitch = 2 * np.pi / sectors
    top, inner = vane.hook.roof_radius, vane.inner_shroud_inner_radius
    half = pitch / 2
    wide = 1e3 * (top + 0.018) * np.sin(half)
    low = (-wide, 1e3 * inner * np.cos(half) - 2)
    high = (wide, 1e3 * top + 22)
    view = drafting.view(figure, panel, (0.1, 2.75, 0.1, 0.4), low, high, "From the front")
    extent = vane.outer_shroud_extent * half
    for r0, r1, angle in (
        (vane.outer_shroud_outer_radius, top, extent),
        (vane.outer_shroud_inner_radius, vane.outer_shroud_outer_radius, extent),
        (inner, vane.inner_shroud_outer_radius, half),
    ):
        drafting.area(view, ring_piece(r0, r1, angle), "vane")
    axes = aerofoil.angles(vane, sectors)
    for axis in axes:
        drafting.area(view, _strip(vane, axis), "vane")
        for corner in _root_fillets(vane, axis):
            drafting.area(view, corner, "vane")
    band = vane.hook.band_extent * half
    labels = []
    for level, (angle, text) in enumerate(
        (
            (band, caption(vane, "hook.band_extent")),
            (extent, caption(vane, "outer_shroud_extent")),
            (half, f"pitch {np.degrees(pitch):.6g}° = 360°/{sectors}"),
        )
    ):
        radius = top + 4e-3 + 7e-3 * level
        for side in (-1, 1):
            foot = inner if level == 2 else top
            drafting.stroke(
                view, [polar(foot, side * angle), polar(radius + 1e-3, side * angle)], "thin"
            )
        degrees = np.degrees(angle)
        at = drafting.sweep(view, (0, 0), 1e3 * radius, 90 + degrees, 90 - degrees, 0.93)
        labels.append(Label(text, at))
    mid = (vane.inner_shroud_outer_radius + vane.outer_shroud_inner_radius) / 2
    labels.append(Label(caption(vane, "aerofoils"), polar(mid + 0.1 * (top - inner), axes[-1])))
    labels.append(_lean(view, vane, axes[-1]))
    root = polar(vane.inner_shroud_outer_radius, axes[-1])
    labels.append(Label(caption(vane, "root_fillet"), root))
    drafting.margin(view, "right", labels)


def _root_fillets(vane: VaneDimensions, axis: float) -> list[Real]:
    """The aerofoil's fillets at mid-chord."""
    found = []
    for side in (0, 2):
        for x, y, _ in (corner.T for corner in root_fillets(vane, side, 6)):
            places = [
                polar(np.hypot(a, b), axis + np.arctan2(b, a)) for a, b in zip(x, y, strict=True)
            ]
            found.append(np.array(places))
    return found


def _lean(view: DrawingView, vane: VaneDimensions, axis: float) -> Label:
    """The angle between the stacking line and the radial direction at mid-span."""
    root, tip = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    middle, length = (root + tip) / 2, 0.5 * (tip - root)
    shown = vane.lean or SHOWN
    turned = np.radians(90 - np.degrees(axis))
    centre = np.array(polar(middle, axis))
    lines: tuple[tuple[float, Stroke], ...] = (
        (0.0, "centre"),
        (shown, "centre" if vane.lean else "hidden"),
    )
    for degrees, kind in lines:
        angle = turned - np.radians(degrees)
        end = centre + 1e3 * length * np.array([np.cos(angle), np.sin(angle)])
        drafting.stroke(view, [centre, end], kind)
    base = np.degrees(turned)
    at = drafting.sweep(view, centre, 1e3 * 0.92 * length, base, base - shown)
    return Label(caption(vane, "lean") + ("" if vane.lean else ", positive this way"), at)


def outer_view(figure: Figure, panel: Panel, vane: VaneDimensions, sectors: int) -> None:
    """The outer shroud from outside, developed at the roof's radius."""
    radius, half = vane.hook.roof_radius, np.pi / sectors
    front = min(vane.outer_shroud_front, vane.foot_front)
    mirror = 2 * vane.hook.mid_plane
    wide = 1e3 * radius * half
    low, high = (-wide, 1e3 * front), (wide, 1e3 * (mirror - front))
    title = "Hooks from outside, developed"
    view = drafting.view(figure, panel, (0.1, 2.4, 0.1, 0.45), low, high, title)
    extent = vane.outer_shroud_extent * half * radius
    for z0, z1 in (
        (vane.outer_shroud_front, mirror - vane.outer_shroud_front),
        (vane.foot_front, vane.leg_rear),
        (mirror - vane.leg_rear, mirror - vane.foot_front),
    ):
        drafting.area(view, 1e3 * np.array(box(-extent, extent, z0, z1)), "vane")
    bands = contact_places.hook_bands(vane.hook, sectors)[[0, 2]]
    angle = np.arctan2(bands[..., 1], bands[..., 0])
    drafting.dots(
        view, 1e3 * np.stack([radius * angle, bands[..., 2]], -1).reshape(-1, 2), style.VERMILION
    )
    middle = 1e3 * vane.hook.mid_plane
    drafting.stroke(view, [(-wide, middle), (wide, middle)], "centre")
    for side in (-1, 1):
        drafting.stroke(view, [(side * wide, low[1]), (side * wide, high[1])], "centre")
    end = 1e3 * extent
    drafting.margin(
        view,
        "right",
        [
            Label(caption(vane, "outer_shroud_front"), (end, 1e3 * vane.outer_shroud_front), True),
            Label(caption(vane, "foot_front"), (end, 1e3 * vane.foot_front), True),
            Label(caption(vane, "leg_rear"), (end, 1e3 * vane.leg_rear), True),
            Label(caption(vane, "hook.mid_plane"), (wide, middle), True),
            Label(
                caption(vane, "hook.band_nodes"),
                (1e3 * radius * angle[1, -2], 1e3 * bands[1, -2, 2]),
            ),
        ],
    )


def inner_view(figure: Figure, panel: Panel, vane: VaneDimensions, sectors: int) -> None:
    """The inner shroud from outside, developed at its outer radius, the blades cut at the root."""
    radius, half = vane.inner_shroud_outer_radius, np.pi / sectors
    left = contact_places.interlock_rows(vane, sectors)[1]
    angle, z = np.arctan2(left[:, 1], left[:, 0]), left[:, 2]
    lines = [np.stack([radius * (angle + shift), z], -1) for shift in (0.0, 2 * half)]
    wide = 1e3 * max(radius * half, np.abs(np.concatenate(lines)[:, 0]).max())
    low, high = (-wide, 1e3 * z.min()), (wide, 1e3 * z.max())
    title = "Inner shroud from outside, developed"
    view = drafting.view(figure, panel, (0.1, 2.4, 0.1, 0.45), low, high, title)
    drafting.area(view, 1e3 * np.concatenate([lines[0], lines[1][::-1]]), "vane")
    for axis in aerofoil.angles(vane, sectors):
        across, axial = section(vane, radius).T
        around = radius * (axis + np.arcsin(across / radius))
        drafting.area(view, 1e3 * np.stack([around, axial + vane.hook.mid_plane], -1), "vane")
    for line in lines:
        drafting.dots(view, 1e3 * line, style.GREEN)
    corner, degrees = 1e3 * lines[1][0], vane.interlock_slant
    reach = 0.75 * (high[1] - low[1])
    drafting.stroke(view, [corner, (corner[0], corner[1] + 1.15 * reach)], "centre", clipped=False)
    at = drafting.sweep(view, corner, reach, 90, 90 - degrees)
    drafting.margin(
        view,
        "right",
        [
            Label(caption(vane, "interlock_slant"), at),
            Label(caption(vane, "interlock_nodes"), tuple(1e3 * lines[1][-2])),
            Label(caption(vane, "inner_shroud_front"), (corner[0], corner[1]), True),
        ],
    )


def _strip(vane: VaneDimensions, axis: float) -> Real:
    """An aerofoil at mid-chord, between the shrouds."""
    alongs = np.linspace(vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius, 21)
    across = np.array([aerofoil.outline(vane, np.zeros(1), along)[:, 0, 0] for along in alongs])
    c, s = np.cos(axis), np.sin(axis)
    sides = [np.stack([alongs * s + y * c, alongs * c - y * s], -1) for y in across.T]
    return 1e3 * np.concatenate([sides[0], sides[1][::-1]])
