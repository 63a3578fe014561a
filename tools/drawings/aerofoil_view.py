"""The section of an aerofoil with its chord, camber, thickness and angles."""

import numpy as np
from matplotlib.figure import Figure

from drawings import drafting
from drawings.captions import caption
from drawings.drafting import DrawingView, Label, Panel
from drawings.sections import Real, section
from drawings.segment_views import SHOWN
from vanelock.mesh import VaneDimensions
from vanelock.mesh.geometry import aerofoil
from vanelock.render import style


def profile_view(figure: Figure, panel: Panel, vane: VaneDimensions) -> None:
    """An aerofoil's section at mid-span, seen from outside."""
    outline = 1e3 * section(vane, None)
    chord, camber = 1e3 * vane.chord, 1e3 * vane.camber * vane.chord
    frame = _chord_frame(vane.stagger)
    reach = 0.62 * chord
    low = np.minimum(outline.min(axis=0) - 6, -0.5 * reach)
    high = np.maximum(outline.max(axis=0) + 6, 0.5 * reach)
    view = drafting.view(
        figure, panel, (0.1, 2.6, 0.1, 0.45), low, high, "Aerofoil at mid-span, from outside"
    )
    drafting.area(view, outline, "vane")

    def at(along: float, above: float) -> Real:
        """A point by its place along the chord and off it, mm."""
        return np.array([along, above]) @ frame

    base = -0.5 * camber  # the camber line's ends
    s = np.linspace(-1, 1, 41)
    drafting.stroke(view, [at(0.5 * chord * t, camber * (0.5 - t**2)) for t in s], "hidden")
    drafting.stroke(view, [at(-0.5 * chord, base), at(0.5 * chord, base)], "centre")
    labels = []
    offset = 0.35
    arrow = drafting.distance(view, at(-0.5 * chord, base), at(0.5 * chord, base), offset)
    labels.append(Label(caption(vane, "chord"), arrow))
    side = 0.22 * chord
    drafting.stroke(view, [at(0, 0.5 * camber), at(1.15 * side, 0.5 * camber)], "thin")
    arrow = drafting.distance(view, at(side, base), at(side, 0.5 * camber))
    labels.append(Label(caption(vane, "camber"), arrow))
    half = 0.5e3 * vane.thickness
    arrow = drafting.distance(view, at(0, 0.5 * camber - half), at(0, 0.5 * camber + half))
    labels.append(Label(caption(vane, "thickness"), arrow))
    convex, concave = 1e3 * aerofoil.outline(vane, np.array([1.0]))[:, 0]
    arrow = drafting.distance(view, concave, convex)
    labels.append(Label(caption(vane, "edge_thickness"), arrow))
    start = at(-0.5 * chord, base)
    drafting.stroke(view, np.array([start, start + np.array([0, 0.75 * chord])]), "centre")
    arrow = drafting.sweep(view, start, 0.6 * chord, 90, 90 - vane.stagger)
    labels.append(Label(caption(vane, "stagger"), arrow))
    labels.append(_twist(view, vane))
    drafting.dots(view, [(0, 0)], style.BLACK)
    labels.append(Label("radial axis", (0, 0)))
    drafting.margin(view, "right", labels)


def _twist(view: DrawingView, vane: VaneDimensions) -> Label:
    """The chords' directions at root and tip, through the stacking axis."""
    shown = vane.twist or SHOWN
    reach = 0.6e3 * vane.chord
    for side in (-0.5, 0.5):
        direction = _chord_frame(vane.stagger + side * shown)[0]
        drafting.stroke(view, [-reach * direction, reach * direction], "hidden")
    middle = 90 - vane.stagger
    at = drafting.sweep(view, (0, 0), 0.97 * reach, middle + shown / 2, middle - shown / 2)
    return Label(caption(vane, "twist") + ("" if vane.twist else ", positive this way"), at)


def _chord_frame(stagger: float) -> Real:
    """Rows: directions of the chord and of its normal, circumferential and axial."""
    c, s = np.cos(np.radians(stagger)), np.sin(np.radians(stagger))
    return np.array([[s, c], [c, -s]])
