"""Hysteresis of one contact as it is traced, within the bounds that move with the normal force."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from vanelock.render import style
from vanelock.render.plots.contacts import loops
from vanelock.render.scenes import gif

Real = NDArray[np.float64]

FRAMES: Final = 36
MILLISECONDS: Final = 70
_PALE: Final = "#c4c4c4"  # the loop to be traced


def loop_animation(
    path: style.PathLike,
    displacement: ArrayLike,
    force: ArrayLike,
    mu: float,
    title: str,
    subtitle: str = "",
    direction: int | None = None,
    bounding: ArrayLike | None = None,
    isotropic: bool = False,
    frames: int = FRAMES,
    tangents: tuple[str, str] = loops.TANGENTS,
) -> Path:
    """Animate a contact's period, and return the path of the GIF.

    Left: friction over sliding, the loop traced so far, and the bounds ±μn of the instant as
    dashed lines, which friction never leaves. Right: normal force and friction over the period.
    Colours show where the contact sticks, slips or is open.

    Parameters
    ----------
    path : path
        GIF file to write.
    displacement, force, mu, title, subtitle, direction, bounding, isotropic, tangents
        As of `loop_picture`.
    frames : int
        Pictures of the period.

    Raises
    ------
    InputError
        If the arrays do not fit together or the file cannot be written.
    """
    period = loops.period(displacement, force, mu, direction, bounding, isotropic, tangents)
    text = f"{subtitle}. {period.taken}" if subtitle else period.taken
    with style.applied():
        figure = style.figure(5.6, title, text, width=9.6)
        loop = style.axes(figure, 0.85, 0.75, 3.75, 3.65)
        normal = style.axes(figure, 5.65, 2.9, 3.6, 1.5)
        friction = style.axes(figure, 5.65, 0.75, 3.6, 1.5)
        loops.histories(normal, friction, period)
        loops.legend(loop, period, isotropic)
        tracer = LoopTracer(period, loop, normal, friction)
        gif.canvas(figure)
        kept = figure.canvas.copy_from_bbox(figure.bbox)  # type: ignore[attr-defined]
        shots = []
        for frame in range(frames):
            figure.canvas.restore_region(kept)  # type: ignore[attr-defined]
            tracer.show(frame * len(period.friction) // frames)
            shots.append(np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy())  # type: ignore[attr-defined]
    return gif.write_gif(path, shots, MILLISECONDS)


class LoopTracer:
    """The parts of the figure that move.

    Parameters
    ----------
    period : Period
        What is traced.
    loop, normal, friction : Axes
        Where it is shown; the histories are drawn already, the loop is not.
    """

    def __init__(self, period: loops.LoopPeriod, loop: Axes, normal: Axes, friction: Axes) -> None:
        self.period = period
        self.sliding = 1e6 * period.sliding
        loop.plot(loops.closed(self.sliding), loops.closed(period.friction), lw=1.2, color=_PALE)
        loops.label(loop, period.direction)
        high = 1.08 * float(max(np.abs(period.bound).max(), np.abs(period.friction).max()))
        loop.set_ylim(-high, high)
        loop.margins(x=0.08)
        self.trace = loops.coloured(
            loop, self.sliding[:2], period.friction[:2], period.state[:2], 2.8
        )
        self.bounds = [
            loop.axhline(0.0, color=style.BLACK, lw=1.4, ls=loops.BROKEN) for _ in (0, 1)
        ]
        self.points = [
            axes.plot([], [], "o", ms=9, mec="white", mew=1.2, zorder=5)[0]
            for axes in (loop, normal, friction)
        ]
        self.moving: list[Any] = [self.trace, *self.bounds, *self.points]
        for artist in self.moving:
            artist.set_animated(True)

    def place(self, step: int) -> None:
        """Put everything where it is at a step of the period."""
        found = self.period
        pieces = np.column_stack([self.sliding, found.friction])[: step + 1]
        self.trace.set_segments(np.stack([pieces[:-1], pieces[1:]], axis=1))
        self.trace.set_color(loops.colours(found.state[1 : step + 1]) or "none")
        for line, sign in zip(self.bounds, (1, -1), strict=True):
            line.set_ydata([sign * found.bound[step]] * 2)
        time = step / len(found.friction)
        places = (
            (self.sliding[step], found.friction[step]),
            (time, found.normal[step]),
            (time, found.friction[step]),
        )
        (colour,) = loops.colours(found.state[step : step + 1])
        for point, (x, y) in zip(self.points, places, strict=True):
            point.set_data([x], [y])
            point.set_color(colour)
            point.set_markeredgecolor("white")

    def show(self, step: int) -> None:
        """Draw a step of the period over what stands still."""
        self.place(step)
        for artist in self.moving:
            artist.axes.draw_artist(artist)
