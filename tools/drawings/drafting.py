"""Technical drawing: views to scale whose labels stand in the margins, where none can overlap.

A view shows a rectangle in mm at the centre of its panel. Arrows and marks lie in the drawing;
their texts are moved apart in the margins around it and joined to them by thin lines.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import ArrayLike, NDArray

from vanelock.render import style

Real = NDArray[np.float64]
Panel = tuple[float, float, float, float]
"""Left, bottom, width and height in inches."""
Side = Literal["left", "right", "bottom", "top"]
Stroke = Literal["edge", "thin", "centre", "hidden"]

SIZE: Final = 9.0
"""Letters of labels, points."""
GAP: Final = 0.175
"""From one label to the next, inches."""
STANDOFF: Final = 0.32
"""From what is drawn to the labels, inches."""

_STROKES: Final[dict[str, dict[str, Any]]] = {
    "edge": {"color": style.BLACK, "lw": 1.1},
    "thin": {"color": style.GREY, "lw": 0.6},
    "centre": {"color": style.GREY, "lw": 0.8, "ls": (0, (9, 2, 2, 2))},
    "hidden": {"color": style.GREY, "lw": 0.8, "ls": (0, (4, 2.5))},
}
_ALIGNMENT: Final[dict[Side, dict[str, Any]]] = {
    "left": {"ha": "right", "va": "center"},
    "right": {"ha": "left", "va": "center"},
    "bottom": {"ha": "center", "va": "top", "rotation": 90},
    "top": {"ha": "center", "va": "bottom", "rotation": 90},
}


@dataclass(frozen=True)
class DrawingView:
    """A panel of a sheet.

    Attributes
    ----------
    axes : Axes
        In mm, the same in both directions.
    scale : float
        mm of the part on an inch of paper.
    low, high : (2,) float
        The rectangle for what is drawn, mm.
    """

    axes: Axes
    scale: float
    low: Real
    high: Real


@dataclass(frozen=True)
class Label:
    """A text and what it belongs to.

    Attributes
    ----------
    text : str
        The text.
    at : (x, y)
        The feature, mm.
    ordinate : bool
        Whether a straight extension line leads from the feature to the margin, as for a position
        along it; else the leader runs aslant.
    """

    text: str
    at: tuple[float, float]
    ordinate: bool = False


def view(
    figure: Figure,
    panel: Panel,
    margins: tuple[float, float, float, float],
    low: ArrayLike,
    high: ArrayLike,
    title: str,
) -> DrawingView:
    """A view of the rectangle from `low` to `high`, mm, as large as its panel allows.

    Parameters
    ----------
    figure : Figure
        The sheet.
    panel : (left, bottom, width, height)
        Of the panel, inches.
    margins : (left, right, bottom, top)
        Inches kept free for labels, within the panel.
    low, high : (x, y)
        Corners, mm.
    title : str
        Heading, at the panel's top.
    """
    left, bottom, width, height = panel
    axes = style.axes(figure, left, bottom, width, height)
    axes.set_axis_off()
    room = np.array([width - margins[0] - margins[1], height - margins[2] - margins[3]])
    first, last = np.asarray(low, float), np.asarray(high, float)
    scale = float(((last - first) / room).max())
    # What one direction leaves over is shared out on both sides.
    corner = (first + last) / 2 - scale * (room / 2 + [margins[0], margins[2]])
    axes.set_xlim(corner[0], corner[0] + scale * width)
    axes.set_ylim(corner[1], corner[1] + scale * height)
    axes.text(0, 1, title, transform=axes.transAxes, fontsize=12.5, va="top", fontweight="bold")
    return DrawingView(axes, scale, first, last)


def area(view: DrawingView, corners: ArrayLike, part: str, pale: bool = False) -> None:
    """A filled outline in the colour of a part, cut where the view ends."""
    x, y = np.asarray(corners, float).T
    colour = style.part_colour(part)
    (inside,) = view.axes.fill(x, y, facecolor=colour, alpha=0.4 if pale else 1, lw=0)
    (around,) = view.axes.fill(x, y, facecolor="none", joinstyle="miter")
    around.set(edgecolor=style.GREY if pale else style.BLACK, lw=0.7 if pale else 1.1)
    for drawn in (inside, around):
        drawn.set_clip_path(_window(view))


def stroke(
    view: DrawingView,
    points: ArrayLike,
    kind: Stroke = "edge",
    clipped: bool = True,
) -> None:
    """A line through points (k, 2), mm, cut where the view ends unless it is a mere mark."""
    (line,) = view.axes.plot(*np.asarray(points, float).T, solid_capstyle="butt", **_STROKES[kind])
    if clipped:
        line.set_clip_path(_window(view))


def _window(view: DrawingView) -> Rectangle:
    pad = 0.02 * view.scale  # half a line's width
    width, height = view.high - view.low + 2 * pad
    return Rectangle(tuple(view.low - pad), width, height, transform=view.axes.transData)


def dots(view: DrawingView, points: ArrayLike, colour: str, size: float = 4.0) -> None:
    """Nodes (k, 2), mm."""
    view.axes.plot(*np.asarray(points, float).T, "o", color=colour, ms=size, mew=0, zorder=4)


def distance(
    view: DrawingView, start: ArrayLike, end: ArrayLike, offset: float = 0.0
) -> tuple[float, float]:
    """A double arrow between two points, moved to its left by `offset` inches.

    Returns
    -------
    (x, y)
        Its middle, mm.
    """
    p, q = np.asarray(start, float), np.asarray(end, float)
    along = (q - p) / max(float(np.linalg.norm(q - p)), 1e-12)
    across = np.array([-along[1], along[0]])
    moved = offset * view.scale * across
    if offset:
        beyond = np.sign(offset) * 0.06 * view.scale * across
        for point in (p, q):
            stroke(view, [point, point + moved + beyond], "thin", clipped=False)
    if np.linalg.norm(q - p) > 0.22 * view.scale:
        _point(view, (p + q) / 2 + moved, p + moved)
        _point(view, (p + q) / 2 + moved, q + moved)
    else:  # too short for two heads inside: they point at it from outside
        tail = 0.22 * view.scale * along
        _point(view, p + moved - tail, p + moved)
        _point(view, q + moved + tail, q + moved)
    x, y = (p + q) / 2 + moved
    return float(x), float(y)


def _point(view: DrawingView, tail: Real, tip: Real) -> None:
    """An arrow."""
    shape = {"arrowstyle": "-|>,head_length=0.42,head_width=0.14", "shrinkA": 0, "shrinkB": 0}
    view.axes.annotate(
        "", tuple(tip), tuple(tail), arrowprops={**shape, "color": style.BLUE, "lw": 0.9}
    )


def sweep(
    view: DrawingView,
    centre: ArrayLike,
    radius: float,
    start: float,
    end: float,
    share: float = 0.5,
) -> tuple[float, float]:
    """An arc with arrow heads from one direction to another, degrees.

    Returns
    -------
    (x, y)
        The point a share of the way along it, mm.
    """
    angle = np.radians(np.linspace(start, end, 101))
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    arc = np.asarray(centre, float) + radius * unit
    view.axes.plot(*arc.T, color=style.BLUE, lw=0.9, solid_capstyle="butt")
    long = abs(np.radians(end - start)) * radius > 0.22 * view.scale
    if long:
        _point(view, arc[3], arc[0])
        _point(view, arc[-4], arc[-1])
    x, y = arc[round(share * (len(arc) - 1))]
    return float(x), float(y)


def margin(view: DrawingView, side: Side, labels: Sequence[Label]) -> None:
    """Labels along one side of what is drawn, in the order of their features."""
    vertical = side in ("bottom", "top")
    axis = 0 if vertical else 1
    sign = 1 if side in ("right", "top") else -1
    border = (view.high if sign > 0 else view.low)[1 - axis]
    edge = border + sign * STANDOFF * view.scale
    limits = view.axes.get_xlim() if vertical else view.axes.get_ylim()
    half = 0.5 * GAP * view.scale
    ordered = sorted(labels, key=lambda label: label.at[axis])
    wanted = [label.at[axis] for label in ordered]
    found = spread(wanted, 2 * half, limits[0] + half, limits[1] - half)
    alignment = _ALIGNMENT[side]
    turned = slice(None, None, -1 if vertical else 1)  # from (across, along) the side to (x, y)
    for label, position in zip(ordered, found, strict=True):
        across, along = label.at[1 - axis], label.at[axis]
        path = [(across, along), (edge, position)]
        if label.ordinate:
            path.insert(1, (border + sign * 0.08 * view.scale, along))
        else:
            dots(view, [label.at], style.BLUE, 2.6)
        stroke(view, np.array(path)[:, turned], "thin", clipped=False)
        x, y = (edge + sign * 0.05 * view.scale, position)[turned]
        view.axes.text(x, y, label.text, fontsize=SIZE, **alignment)


def spread(wanted: Sequence[float], gap: float, low: float, high: float) -> Real:
    """Positions nearest to ascending wanted ones, at least a gap apart, between two limits.

    Least squares: neighbours that are too close join a group, which stays about its mean.
    """
    steps = gap * np.arange(len(wanted))
    groups: list[tuple[float, int]] = []  # mean and size, of positions less their steps
    for value in np.asarray(wanted, float) - steps:
        mean, count = float(value), 1
        while groups and groups[-1][0] > mean:
            other, size = groups.pop()
            mean, count = (mean * count + other * size) / (count + size), count + size
        groups.append((mean, count))
    found = np.concatenate([np.full(count, mean) for mean, count in groups] or [np.empty(0)])
    last = steps[-1] if len(steps) else 0.0
    return np.asarray(np.clip(found, low, max(low, high - last)) + steps)
