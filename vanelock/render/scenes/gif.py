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
WHITE: Final = 1 << 15
"""Its code, beyond those of 5 bits a channel."""


def canvas(figure: Figure) -> Pixels:
    """A figure of `style.figure` as (height, width, 3) bytes, in an animation's resolution."""
    figure.set_dpi(DPI)
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy()  # type: ignore[attr-defined]


def write_gif(path: style.PathLike, frames: Sequence[Pixels], milliseconds: int) -> Path:
    """Write frames of one size, each shown for so long, and return the path."""
    target = Path(path)
    palette = _palette(frames[:: -(-len(frames) // 4)])
    codes = [_code(frame) for frame in frames]
    numbers = _nearest(palette, codes)
    images = []
    for code in codes:
        image = Image.fromarray(numbers[code])
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


def _code(frame: Pixels) -> NDArray[np.uint16]:
    """Each pixel's colour in 5 bits a channel; WHITE for white alone."""
    r, g, b = (frame[:, :, i] for i in range(3))
    r5, g5, b5 = ((channel >> 3).astype(np.uint16) for channel in (r, g, b))
    return np.where(r & g & b == 255, np.uint16(WHITE), r5 << 10 | g5 << 5 | b5)


def _nearest(palette: Pixels, codes: Sequence[NDArray[np.uint16]]) -> Pixels:
    """(WHITE + 1,) number in the palette of the colour nearest to each code that occurs.

    Pillow's own search is not exact, and takes a grey for white, which is number 0 here.
    """
    numbers = np.zeros(WHITE + 1, np.uint8)
    for code in codes:
        numbers[code] = 1
    (used,) = np.nonzero(numbers[:WHITE])
    colours = 8 * (used[:, None] >> np.array([10, 5, 0]) & 31) + 3.5
    shades = palette.astype(float)
    distance = (shades**2).sum(axis=1) - 2 * colours @ shades.T  # but for what is the same for all
    numbers[used], numbers[WHITE] = distance.argmin(axis=1), 0
    return numbers
