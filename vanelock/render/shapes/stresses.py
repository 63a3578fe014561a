"""Von Mises stress on the surface of a part."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import scene, views, window

_SHOWN: Final = 0.995
"""Share of the surface's nodes within the colours: what stands out there are point forces."""


def stress_picture(
    path: style.PathLike,
    part: Part,
    total: Floats,
    vibration: Floats,
    title: str,
    subtitle: str = "",
    gauges: Sequence[Sequence[float]] | Floats = (),
) -> Path:
    """Draw stresses on a part, and return the path.

    Left: with what acts at rest; right: of the vibration alone. Colours end where 99.5 % of the
    surface's nodes lie below: the stress at a node that carries a contact's force has no meaning.

    Parameters
    ----------
    path : path
        PNG file to write.
    part : Part
    total, vibration : (n,) float
        Largest von Mises stress over a period at each node, Pa.
    title, subtitle : str
        Heading, and a line before the statement of the scales.
    gauges : (g, 3), optional
        Positions to mark, m.

    Raises
    ------
    InputError
        If the stresses do not fit the part, or this machine cannot draw.
    """
    for values in (total, vibration):
        if values.shape != (len(part.points),) or not np.all(np.isfinite(values)):
            raise InputError(
                f"{part.name}: stresses of shape {values.shape}: finite ones of its "
                f"{len(part.points)} nodes are needed"
            )
    skin, split, triangles = scene.smooth_skin(part)
    points = part.points[skin.nodes]
    camera = views.sector_camera(part.points)
    lines = [scene.SceneLines(points, skin.outline, style.BLACK, 1.2, 0.7)]
    gauge_places = np.asarray(gauges, float).reshape(-1, 3)
    marks = [scene.Marks(gauge_places, style.VERMILION, 7.0)] if len(gauge_places) else []
    panels = (("With the preload at rest", total), ("Of the vibration alone", vibration))
    with style.applied():
        stated = "Colours end where 99.5 % of the surface lies below"
        marked = ". Balls: strain gauges, pale where hidden" if len(gauge_places) else ""
        figure = style.figure(
            6.9, title, f"{subtitle.rstrip('. ')}. {stated}{marked}.".lstrip(". ")
        )
        across, up = figure.get_size_inches()
        for left, (heading, values) in zip((0.3, 6.1), panels, strict=True):
            shown = 1e-6 * values[skin.nodes]
            top = float(np.quantile(shown, _SHOWN)) or 1.0
            colour = scene.colours(np.minimum(shown, top), style.AMPLITUDE_MAP, 0, top)
            body = scene.SceneBody(points[split], triangles, colour[split])
            axes, size = style.image_axes(figure, left, 0.4, 4.75, 5.25)
            drawn = scene.DrawnScene(camera, [body], lines, marks)
            style.show(axes, window.snapshot(drawn, size))
            figure.text((left + 0.05) / across, 5.72 / up, heading, fontsize=12.5)
            bar = style.axes(figure, left + 4.8, 1.6, 0.15, 3.2)
            style.colour_bar(bar, style.AMPLITUDE_MAP, 0, top, "von Mises stress (MPa)")
        return style.write(figure, path)
