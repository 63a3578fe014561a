"""Where two parts' meshes have their error."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import scene, views, window

LOW, HIGH = -2.0, 2.0
"""Powers of ten of the mean between which colours lie."""


def mesh_error_picture(
    path: style.PathLike,
    parts: Sequence[Part],
    densities: Sequence[Floats],
    title: str,
    subtitle: str = "",
) -> Path:
    """Draw what meshes add to a mode's stiffness, and return the path.

    Parameters
    ----------
    path : path
        PNG file to write.
    parts : sequence of Part
        Vane and casing.
    densities : sequence of (n,) float
        At each node, energy per volume over the mean of both.
    title, subtitle : str
        Heading, and the line under it.

    Raises
    ------
    InputError
        If this machine cannot draw.
    """
    with style.applied():
        figure = style.figure(6.9, title, subtitle)
        across, up = figure.get_size_inches()
        headings = (f"The {part.name}'s elements" for part in parts)
        for left, part, values, heading in zip((0.3, 5.7), parts, densities, headings, strict=True):
            skin, split, triangles = scene.smooth_skin(part, corners_only=True)
            points = part.points[skin.nodes]
            powers = np.log10(np.maximum(values[skin.nodes], 10**LOW)).clip(LOW, HIGH)
            colour = scene.colours(powers, style.AMPLITUDE_MAP, LOW, HIGH)
            sides = np.sort(skin.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
            lines = [scene.SceneLines(points, np.unique(sides, axis=0), style.BLACK, 0.5, 0.35)]
            axes, size = style.image_axes(figure, left, 0.4, 5.1, 5.25)
            body = scene.SceneBody(points[split], triangles, colour[split])
            drawn = scene.DrawnScene(views.sector_camera(part.points), [body], lines, [])
            style.show(axes, window.snapshot(drawn, size))
            figure.text((left + 0.05) / across, 5.72 / up, heading, fontsize=12.5)
        bar = style.axes(figure, 10.95, 1.6, 0.15, 3.2)
        label = "error per volume, over its mean"
        shown = style.colour_bar(bar, style.AMPLITUDE_MAP, LOW, HIGH, label)
        ticks = np.arange(LOW, HIGH + 1)
        shown.set_ticks(ticks, labels=[f"{10.0**tick:g}" for tick in ticks])
        return style.write(figure, path)
