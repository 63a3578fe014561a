"""Maps over a plane of two parameters: what a quantity is in each cell, and where something holds.

Cells are drawn at equal size, whatever the distance of their values: each is one computed point.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.patches import Rectangle
from numpy.typing import ArrayLike, NDArray

from vanelock.common.errors import InputError
from vanelock.render import style

Real = NDArray[np.float64]

_HOLDS: Final = ("#f4c9a8", "#bfe3d2")  # no, yes: shown by a mark too
_UNKNOWN: Final = "#d9d9d9"
_SIDE: Final = 3.15  # of a panel, inches
_ACROSS: Final = 3


@dataclass(frozen=True)
class MapPanel:
    """One map.

    Attributes
    ----------
    title : str
    values : (m, v) float or bool
        m rows upwards, v columns to the right; NaN where nothing is known. Truth values are drawn
        as yes and no.
    form : str
        Format of the number in each cell, such as ".1f".
    logarithmic : bool
        Whether colours follow the logarithm.
    diverging : bool
        Whether colours show the sign, the same for equal sizes.
    """

    title: str
    values: ArrayLike
    form: str = ".3g"
    logarithmic: bool = False
    diverging: bool = False


def map_picture(
    path: style.PathLike,
    across: Sequence[float],
    up: Sequence[float],
    panels: Sequence[MapPanel],
    xlabel: str,
    ylabel: str,
    title: str,
    subtitle: str = "",
    marked: tuple[float, float] | None = None,
) -> Path:
    """Draw maps of one plane side by side, three in a row, and return the path.

    Parameters
    ----------
    path : path
        PNG file to write.
    across, up : sequence of float
        Values of the parameters, in the units of their labels.
    panels : sequence of MapPanel
    xlabel, ylabel : str
    title, subtitle : str
    marked : (float, float), optional
        Values (across, up) of a cell to be framed, such as the study's own; nothing is where no
        cell has them.

    Raises
    ------
    InputError
        If a panel's values do not fit the parameters, or the file cannot be written.
    """
    shape = len(up), len(across)
    for panel in panels:
        if np.shape(panel.values) != shape:
            raise InputError(
                f"map {panel.title}: shape {np.shape(panel.values)}: {shape} is needed"
            )
    rows = -(-len(panels) // _ACROSS)
    pitch = _SIDE + 0.72
    height = 1.0 + rows * (pitch + 0.1)
    with style.applied():
        figure = style.figure(height, title, subtitle, 12.0)
        for i, panel in enumerate(panels):
            row, column = divmod(i, _ACROSS)
            left = 0.8 + column * (pitch - 0.06)
            axes = style.axes(figure, left, height - 1.0 - (row + 1) * pitch + 0.4, _SIDE, _SIDE)
            _panel(axes, panel)
            _ticks(axes, across, up)
            if marked is not None:
                _mark(axes, across, up, marked)
            last = i + _ACROSS >= len(panels)
            axes.set_xlabel(xlabel if last else "", fontsize=11)
            axes.set_ylabel(ylabel if column == 0 else "", fontsize=11)
        return style.write(figure, path)


def _panel(axes: Axes, panel: MapPanel) -> None:
    values = np.asarray(panel.values)
    axes.set_title(panel.title, fontsize=11)
    axes.grid(False)
    if values.dtype.kind == "b":
        shades = ListedColormap(_HOLDS)
        axes.pcolormesh(values.astype(float), cmap=shades, vmin=0, vmax=1, ec="white", lw=1.5)
        for (i, j), holds in np.ndenumerate(values):
            _write(axes, i, j, "yes" if holds else "no", style.BLACK)
        return
    known = np.isfinite(values)
    if not known.any():
        axes.pcolormesh(np.zeros(values.shape), cmap=ListedColormap([_UNKNOWN]))
        return
    low, high = float(values[known].min()), float(values[known].max())
    norm: Normalize
    colours: Colormap
    if panel.diverging:
        size = max(abs(low), abs(high)) or 1.0
        norm, colours = Normalize(-size, size), colormaps["RdBu_r"]
    elif panel.logarithmic and low > 0:
        norm, colours = LogNorm(low, high if high > low else 1.01 * low), style.AMPLITUDE_MAP
    else:
        norm, colours = Normalize(low, high if high > low else low + 1), style.AMPLITUDE_MAP
    axes.set_facecolor(_UNKNOWN)
    shown = np.ma.masked_invalid(values)
    axes.pcolormesh(shown, cmap=colours, norm=norm, ec="white", lw=1.5)
    for (i, j), value in np.ndenumerate(values):
        text = format(value, panel.form) if np.isfinite(value) else "–"
        light = np.isfinite(value) and sum(colours(norm(value))[:3]) > 1.6
        _write(axes, i, j, text, style.BLACK if light or text == "–" else "white")


def _write(axes: Axes, row: int, column: int, text: str, colour: str) -> None:
    size = 9.5 if len(text) < 6 else 8.0
    axes.text(column + 0.5, row + 0.5, text, ha="center", va="center", color=colour, fontsize=size)


def _ticks(axes: Axes, across: Sequence[float], up: Sequence[float]) -> None:
    axes.set_xticks(np.arange(len(across)) + 0.5, [f"{value:g}" for value in across])
    axes.set_yticks(np.arange(len(up)) + 0.5, [f"{value:g}" for value in up])
    axes.tick_params(length=0, labelsize=9.5)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _mark(
    axes: Axes, across: Sequence[float], up: Sequence[float], marked: tuple[float, float]
) -> None:
    """Frame the cell of the marked values."""
    columns = np.flatnonzero(np.isclose(across, marked[0], rtol=1e-6))
    rows = np.flatnonzero(np.isclose(up, marked[1], rtol=1e-6))
    for i in rows:
        for j in columns:
            frame = Rectangle(
                (float(j), float(i)), 1, 1, fill=False, ec=style.VERMILION, lw=2.2, zorder=5
            )
            axes.add_patch(frame)
