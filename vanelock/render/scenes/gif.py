"""Pictures that follow each other as one GIF, played without end."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from vanelock.common.files.files import placed
from vanelock.render import style

Pixels = NDArray[np.uint8]

DPI: Final = 100
"""Of an animation's figure: coarser than that of a picture, since each frame costs its pixels."""
COLOURS: Final = 256
"""Of an animation, white among them, the same in all frames: shades do not flicker."""


def canvas(figure: Figure) -> Pixels:
    """A figure of `style.figure` as (height, width, 3) bytes, in an animation's resolution."""
    figure.set_dpi(DPI)
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy()  # type: ignore[attr-defined]


def write_gif(path: style.PathLike, frames: Sequence[Pixels], milliseconds: int) -> Path:
    """Write frames of one size, each shown for so long, and return the path.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    target = Path(path)
    palette = _palette(frames[:: -(-len(frames) // 4)])
    nearest = _nearest(palette)
    images = []
    for frame in frames:
        image = Image.fromarray(_numbered(frame, nearest))
        image.putpalette(palette.tobytes())
        images.append(image)
    with placed(target) as temporary:
        images[0].save(
            temporary,
            format="GIF",
            save_all=True,
            append_images=images[1:],
            duration=milliseconds,
            loop=0,
            optimize=False,
        )
    return target


def _palette(frames: Sequence[Pixels]) -> Pixels:
    """(COLOURS, 3) white, and colours near to all others in some frames."""
    pixels = np.concatenate([frame.reshape(-1, 3) for frame in frames])
    coloured = pixels[np.any(pixels < 255, axis=1)][None]
    palette = np.full((COLOURS, 3), 255, np.uint8)
    if coloured.size:
        found = Image.fromarray(coloured).quantize(COLOURS - 1, method=Image.Quantize.MEDIANCUT)
        chosen = np.array(found.getpalette(), np.uint8).reshape(-1, 3)[: COLOURS - 1]
        palette[1 : 1 + len(chosen)] = chosen
    return palette


def _nearest(palette: Pixels) -> Pixels:
    """(32768,) number of the colour nearest to each one of 5 bits a channel.

    Pillow's own search is not exact, and takes a grey for white.
    """
    levels = 8 * np.arange(32) + 3.5
    grid = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), -1).reshape(-1, 3)
    shades = palette.astype(float)
    distance = (shades**2).sum(axis=1) - 2 * grid @ shades.T  # but for what is the same for all
    found: Pixels = distance.argmin(axis=1).astype(np.uint8)
    return found


def _numbered(frame: Pixels, nearest: Pixels) -> Pixels:
    """Each pixel's number in the palette, white's being 0."""
    r, g, b = (frame[:, :, i].astype(np.int32) >> 3 for i in range(3))
    numbers: Pixels = nearest[(r << 10) | (g << 5) | b]
    numbers[frame.min(axis=2) == 255] = 0
    return numbers
