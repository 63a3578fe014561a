"""House style of every picture: sizes, fonts, colours, titles, and how a figure is written.

Figures are made without pyplot, so that neither the caller's backend nor its settings change.
Colours are those of Okabe and Ito (2008), which people with any common colour blindness can tell
apart; the colour maps are perceptually uniform.
"""

import io
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

from vanelock.common.files.files import PathLike as PathLike
from vanelock.common.files.files import placed

DPI: Final = 150
_PRESSED: Final = 4  # of a PNG: 5 % larger than at 6, in two thirds of the time
WIDTH: Final = 12.0  # inches: 1800 pixels
BLACK: Final = "#1a1a1a"
GREY: Final = "#6b6b6b"
LIGHT: Final = "#d9d9d9"
BLUE: Final = "#0072b2"
ORANGE: Final = "#e69f00"
GREEN: Final = "#009e73"
VERMILION: Final = "#d55e00"
PURPLE: Final = "#cc79a7"
SKY: Final = "#56b4e9"
SERIES: Final = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
PART_COLOURS: Final = {"vane": "#c9b28a", "casing": "#a9b7c6"}
# From the grey of what stands still, evenly darker.
AMPLITUDE_MAP: Final = LinearSegmentedColormap.from_list(
    "amplitude", ["#ecedee", "#bfe0df", "#6cbfc8", "#2c8ab8", "#28509c", "#22195a"]
)
# Cyclic: lightness separates 0 from 180 degrees, hue a lead from a lag.
PHASE_MAP: Final = LinearSegmentedColormap.from_list(
    "phase", ["#f7f0b6", "#5aa9d6", "#1d2a5e", "#c2482b", "#f7f0b6"]
)

SETTINGS: Final[dict[str, Any]] = {
    "font.family": "DejaVu Sans",  # shipped with matplotlib
    "font.size": 12.0,
    "axes.titlesize": 12.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 12.5,
    "axes.edgecolor": GREY,
    "axes.labelcolor": BLACK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": LIGHT,
    "grid.linewidth": 0.7,
    "xtick.color": BLACK,
    "ytick.color": BLACK,
    "text.color": BLACK,
    "legend.frameon": False,
    "legend.fontsize": 11.0,
    "lines.linewidth": 1.8,
    "figure.facecolor": "white",
    "axes.facecolor": "white",
}


def part_colour(name: str) -> str:
    """Colour of a part's surface where nothing else colours it."""
    return PART_COLOURS.get(name, LIGHT)


def applied() -> Any:
    """Context in which matplotlib uses the house style: `with style.applied(): ...`."""
    plain: dict[Any, Any] = {k: v for k, v in mpl.rcParamsDefault.items() if "backend" not in k}
    plain.update(SETTINGS)
    return mpl.rc_context(plain)


class _HouseFigure(Figure):
    """A figure that a notebook shows where it is a cell's last value."""

    def _repr_png_(self) -> bytes:
        written = io.BytesIO()
        with applied():
            self.savefig(written, format="png", dpi=DPI / 2)
        return written.getvalue()


def figure(height: float, title: str, subtitle: str = "", width: float = WIDTH) -> Figure:
    """Figure of that size in inches with its title, and room of 0.9 inches for it at the top."""
    made = _HouseFigure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(made)
    left = 0.35 / width
    texts = [made.text(left, 1 - 0.22 / height, title, fontsize=16, fontweight="bold", va="top")]
    if subtitle:
        texts.append(
            made.text(left, 1 - 0.58 / height, subtitle, fontsize=11.5, color=GREY, va="top")
        )
    for text in texts:
        _fit(text, (width - 0.7) * DPI)
    return made


def _fit(text: Text, pixels: float) -> None:
    """Make a text smaller until it is no wider than that."""
    wide = text.get_window_extent().width
    if wide > pixels:
        text.set_fontsize(float(text.get_fontsize()) * pixels / wide)


def axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place given in inches from the figure's lower left corner."""
    across, up = figure.get_size_inches()
    return figure.add_axes((left / across, bottom / up, width / across, height / up))


def image_axes(
    figure: Figure, left: float, bottom: float, width: float, height: float
) -> tuple[Axes, tuple[int, int]]:
    """Bare axes for an image, in inches, and the image's size in pixels that fills them exactly."""
    size = round(width * DPI), round(height * DPI)
    left, bottom = round(left * DPI) / DPI, round(bottom * DPI) / DPI
    made = axes(figure, left, bottom, size[0] / DPI, size[1] / DPI)
    made.set_axis_off()
    return made, size


def show(axes: Axes, picture: Any) -> None:
    """Put an image of just their size into axes of `image_axes`, pixel on pixel."""
    axes.imshow(picture, aspect="auto", interpolation="nearest")


def heading(figure: Figure, left: float, bottom: float, text: str) -> None:
    """A heading at a place given in inches."""
    across, up = figure.get_size_inches()
    figure.text(left / across, bottom / up, text, fontsize=12.5)


def colour_bar(axes: Axes, colours: Colormap, low: float, high: float, label: str) -> Any:
    """Vertical colour bar that fills `axes`, with its label beside it."""
    shown = mpl.cm.ScalarMappable(mpl.colors.Normalize(low, high), colours)
    bar = axes.figure.colorbar(shown, cax=axes)
    bar.set_label(label)
    bar.outline.set_edgecolor(GREY)
    axes.grid(False)
    return bar


def series(count: int) -> list[str]:
    """Colours of that many series: distinct ones for a few, an even scale for many."""
    if count <= len(SERIES):
        return list(SERIES[:count])
    scale = mpl.colormaps["viridis"]
    return [to_hex(scale(0.92 * position / (count - 1))) for position in range(count)]


def number(value: float) -> str:
    """Text of a number to three significant digits, trailing zeros kept: 70.0, 131, 0.250."""
    if value == 0:
        return "0"
    return f"{value:#.3g}".rstrip(".") if 1e-3 <= abs(value) < 1e3 else f"{value:.3g}"


def write(figure: Figure, path: PathLike) -> Path:
    """Write a figure as PNG, making its folder, and return the path."""
    target = Path(path)
    with placed(target) as temporary:
        figure.set_dpi(DPI)
        figure.canvas.draw()
        pixels = np.asarray(figure.canvas.buffer_rgba())[:, :, :3]  # type: ignore[attr-defined]
        image = Image.fromarray(np.ascontiguousarray(pixels))
        image.save(temporary, format="PNG", compress_level=_PRESSED, dpi=(DPI, DPI))
    return target
