"""Which contacts stick, slip or open, and what each dissipates, where they lie on the vane.

The interlock's contacts are drawn on the face that they belong to, seen along its normal; those of
the hooks on their bands, unrolled about the engine axis.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from vanelock.common.arrays import Floats, Integers
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import scene
from vanelock.render.scenes.window import aimed, snapshot

States = Integers

LOOKS: Final = (
    ("sticks", style.BLUE, "o"),
    ("slips", style.VERMILION, "s"),
    ("open all the time", style.GREY, "X"),
    ("slips and opens", style.PURPLE, "^"),
)
"""Words, colour and marker of the states 0 to 3 of a `Response`."""
_SMALL, _LARGE = 18.0, 330.0  # areas of the markers, square points
_BANDS: Final = ("front, outer side", "front, inner side", "rear, outer side", "rear, inner side")


def contact_map_picture(
    path: style.PathLike,
    part: Part,
    positions: ArrayLike,
    frames: ArrayLike,
    joints: Sequence[str],
    frequencies: ArrayLike,
    states: ArrayLike,
    dissipation: ArrayLike,
    title: str,
    subtitle: str,
    headings: Sequence[str],
) -> Path:
    """Draw the state and the friction work of every contact at some frequencies; return the path.

    Colour and shape of a marker show the state, its area the energy that friction takes in a
    cycle; the number is the contact's in its joint.

    Parameters
    ----------
    path : path
        PNG file to write.
    part : Part
        The vane, whose interlock face is drawn.
    positions : (c, 3) float
        Of the contacts on it, m.
    frames : (c, 3, 3) float
        Contact frames: rows are the outward normal and two tangents.
    joints : sequence of c str
        The joint of each contact; "interlock" is drawn on its face, others on their bands.
    frequencies : (k,) float
        Hz, a column of the figure each.
    states : (k, c) int
        0 sticks, 1 slips, 2 open, 3 slips and opens.
    dissipation : (k, c) float
        J in a cycle.
    title, subtitle : str
        Heading and the line under it.
    headings : sequence of k str
        What stands above each frequency, such as "at the peak".

    Raises
    ------
    InputError
        If this machine cannot draw or the file cannot be written.
    """
    x, axes_of, hertz = (np.asarray(a, float) for a in (positions, frames, frequencies))
    state, energy = np.asarray(states, np.int64), np.asarray(dissipation, float)
    face = np.array([joint == "interlock" for joint in joints], bool)
    largest = float(energy.max())
    area = _SMALL + (_LARGE - _SMALL) * np.maximum(energy, 0) / (largest or 1.0)
    number = np.array([list(joints[: i + 1]).count(joint) for i, joint in enumerate(joints)])
    upper = 2.35 if face.any() else 0.0
    lower = 2.3 if not face.all() else 0.0
    height = 1.5 + upper + lower + (0.55 if lower else 0.0) + 0.55
    width = 10.4 / len(hertz)
    text = f"Largest marker: {1e6 * largest:.4g} µJ a cycle" if largest else "No contact slips"
    with style.applied():
        figure = style.figure(height, title, f"{subtitle}. {text}" if subtitle else text)
        background = _face(part, x[face], axes_of[face], width - 0.2, upper) if upper else None
        for column in range(len(hertz)):
            left = 1.45 + column * width
            heading = f"{headings[column]}, {hertz[column]:.2f} Hz"
            style.heading(figure, left, height - 1.2, heading)
            if background is not None:
                picture, places = background
                shown = style.image_axes(figure, left, height - 1.3 - upper, width - 0.2, upper)[0]
                style.show(shown, picture)
                chosen = area[column, face]
                _marks(shown, places, state[column, face], chosen, number[face], 9.0)
            if lower:
                bands = style.axes(figure, left, 1.1, width - 0.2, lower)
                places, chosen = _band_places(x[~face], axes_of[~face]), area[column, ~face]
                reach = 1.08 * float(np.abs(places[:, 0]).max()) or 1.0
                bands.set(xlim=(-reach, reach), ylim=(3.6, -0.6), yticks=range(4))
                bands.set_xlabel("hooks: arc from the middle (mm)")
                bands.grid(False, axis="x")
                _marks(bands, places, state[column, ~face], chosen, number[~face], 6.0)
                bands.set_yticklabels(_BANDS if column == 0 else [], fontsize=10.5)
        if upper:
            _aside(figure, height - 1.3 - upper / 2, "interlock, along\nthe face's normal")
        _legend(figure, state)
        return style.write(figure, path)


def _face(
    part: Part, x: Floats, frames: Floats, width: float, height: float
) -> tuple[NDArray[np.uint8], Floats]:
    """Picture of the face that some contacts lie on, and the contacts' places in it, pixels."""
    size = round(width * style.DPI), round(height * style.DPI)
    skin, split, triangles = scene.smooth_skin(part, corners_only=True)
    points = part.points[skin.nodes]
    camera = scene.Camera(-frames[:, 0].mean(axis=0), frames[:, 1].mean(axis=0), x, margin=1.3)
    body = scene.SceneBody(points[split], triangles, style.part_colour(part.name))
    lines = [
        scene.SceneLines(points, skin.mesh_edges, width=0.8, opacity=0.25),
        scene.SceneLines(points, skin.outline, width=1.4, opacity=0.8),
    ]
    picture = snapshot(scene.DrawnScene(camera, [body], lines), size)
    return picture, aimed(camera, x, size).pixels(x, size)


def _band_places(x: Floats, frames: Floats) -> Floats:
    """(c, 2) unrolled places: arc from the middle, mm, and the band, slightly apart by z."""
    angle = np.arctan2(x[:, 1], x[:, 0])
    middle = np.arctan2(np.sin(angle).mean(), np.cos(angle).mean())
    turned = (angle - middle + np.pi) % (2 * np.pi) - np.pi
    radius = np.hypot(x[:, 0], x[:, 1])
    radial = x[:, :2] / radius[:, None]
    inner = np.sum(frames[:, 0, :2] * radial, axis=1) < 0
    rear = x[:, 2] > (x[:, 2].min() + x[:, 2].max()) / 2
    band = 2 * rear + inner
    apart = np.zeros(len(x))
    for one in np.unique(band):
        z = x[band == one, 2]
        if np.ptp(z) > 1e-6:
            apart[band == one] = 0.6 * ((z - z.min()) / np.ptp(z) - 0.5)
    return np.column_stack([1e3 * radius * turned, band + apart])


def _marks(
    axes: Axes, places: Floats, state: States, area: Floats, number: States, font: float
) -> None:
    for kind in np.unique(state):
        _, colour, marker = LOOKS[kind]
        chosen = state == kind
        axes.scatter(
            places[chosen, 0],
            places[chosen, 1],
            s=area[chosen],
            c=colour,
            marker=marker,
            edgecolors="white",
            linewidths=0.7,
            alpha=0.92,
            zorder=3,
        )
    for place, size, text in zip(places, area, number, strict=True):
        away = 0.5 * np.sqrt(size) + 1.5
        axes.annotate(
            str(text),
            (float(place[0]), float(place[1])),
            (0, away),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=font,
            color=style.BLACK,
            zorder=4,
        )


def _aside(figure: Figure, middle: float, text: str) -> None:
    across, up = figure.get_size_inches()
    figure.text(0.8 / across, middle / up, text, rotation=90, ha="center", va="center", fontsize=11)


def _legend(figure: Figure, state: States) -> None:
    handles = [
        Line2D([], [], color=colour, marker=marker, ls="", ms=9, label=name)
        for kind, (name, colour, marker) in enumerate(LOOKS)
        if np.any(state == kind)
    ]
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(1.35 / style.WIDTH, 0.1 / figure.get_size_inches()[1]),
        ncols=4,
        borderpad=0,
    )
