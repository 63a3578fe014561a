"""Pictures inside a page: the same pixels in fewer bytes."""

import io
from base64 import b64decode

import numpy as np
import pytest
from PIL import Image, ImageSequence

from vanelock.common.errors import InputError
from vanelock.report import writer


def opened(uri):
    kind, _, text = uri.partition(";base64,")
    data = b64decode(text)
    return kind, len(data), Image.open(io.BytesIO(data))


def waves(height, width):
    """(height, width, 3) bytes of many colours, smooth as a shaded body."""
    y, x = np.mgrid[:height, :width] / height
    bands = [np.sin(3 * x + 2 * y), np.cos(4 * y - x), np.sin(5 * x * y)]
    return np.round(127 * (1 + np.stack(bands, -1))).astype(np.uint8)


def test_drawing_of_lines_stays_exact(tmp_path):
    pixels = np.full((300, 500, 3), 255, np.uint8)
    x = np.arange(500)
    pixels[(150 + 100 * np.sin(x / 40)).astype(int), x] = [0, 114, 178]
    Image.fromarray(pixels).save(tmp_path / "curve.png", compress_level=1)
    uri, size = writer.embedded(tmp_path / "curve.png")
    kind, weight, picture = opened(uri)
    assert size == (500, 300)
    assert kind == "data:image/webp"
    assert weight < (tmp_path / "curve.png").stat().st_size
    assert np.array_equal(np.asarray(picture.convert("RGB")), pixels)


def test_shaded_picture_looks_the_same(tmp_path):
    pixels = waves(600, 900)
    Image.fromarray(pixels).save(tmp_path / "shape.png")
    kind, weight, picture = opened(writer.embedded(tmp_path / "shape.png")[0])
    assert kind == "data:image/webp"
    assert weight < 0.5 * (tmp_path / "shape.png").stat().st_size
    off = np.abs(np.asarray(picture.convert("RGB"), int) - pixels)
    assert off.mean() < 1.5  # of 255


def test_animation_keeps_its_frames_and_their_time(tmp_path):
    pixels = waves(80, 100)
    frames = [Image.fromarray(np.roll(pixels, 7 * i, 1)).quantize(64) for i in range(6)]
    path = tmp_path / "motion.gif"
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=80, loop=0)
    kind, _, picture = opened(writer.embedded(path)[0])
    assert kind == "data:image/webp"
    with Image.open(path) as given:
        for frame, exact in zip(
            ImageSequence.Iterator(picture), ImageSequence.Iterator(given), strict=True
        ):
            assert frame.convert("RGB").tobytes() == exact.convert("RGB").tobytes()
    assert picture.n_frames == 6
    assert picture.info["duration"] == 80
    assert picture.info["loop"] == 0  # for ever


@pytest.mark.parametrize("content", [b"<svg/>", b"\x89PNG\r\n\x1a\n", b""])
def test_what_is_no_picture_is_refused(tmp_path, content):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.png: is neither a PNG nor a GIF picture"):
        writer.embedded(tmp_path / "a.png")
