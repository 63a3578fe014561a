"""What a canvas of a page holds, as pixels."""

import io

import matplotlib.image
import numpy as np


def read(picture):
    """(height, width, 3) bytes of a PNG file's content."""
    return np.round(255 * matplotlib.image.imread(io.BytesIO(picture))[..., :3]).astype(np.uint8)


def seen(page):
    """The canvas as it stands on the page."""
    return read(page.locator("figure.view canvas").screenshot())


def colours(picture):
    return len(np.unique(picture.reshape(-1, 3), axis=0))
