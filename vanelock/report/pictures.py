"""Pictures inside a page: the file's pixels, packed anew as WebP, which every browser reads.

Animations and drawings of lines stay exact and take a third to two thirds of a GIF's or PNG's
bytes; shaded pictures, of many colours, are kept to what the eye tells apart, in a quarter.
"""

import io
from base64 import b64encode
from pathlib import Path
from typing import Any, Final

from PIL import Image, ImageSequence, UnidentifiedImageError, features

from vanelock.common.errors import InputError

_FORMATS: Final = {"PNG": "image/png", "GIF": "image/gif"}
_FEW: Final = 2500  # colours among every ninth pixel: a drawing of lines, smooth edges included
_EXACT: Final[dict[str, Any]] = {"lossless": True, "method": 2, "quality": 20}
_SHADED: Final[dict[str, Any]] = {"quality": 90, "method": 2, "use_sharp_yuv": True}


def embedded(path: Path) -> tuple[str, tuple[int, int]]:
    """A PNG or GIF file as a data URI, and its width and height in pixels."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        with Image.open(io.BytesIO(data), formats=list(_FORMATS)) as picture:
            size, kind = picture.size, _FORMATS[picture.format or ""]
            packed = _webp(picture) if features.check("webp") else data
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError):
        raise InputError(f"{path}: is neither a PNG nor a GIF picture") from None
    if len(packed) < len(data):
        data, kind = packed, "image/webp"
    return f"data:{kind};base64,{b64encode(data).decode('ascii')}", size


def _webp(picture: Image.Image) -> bytes:
    target = io.BytesIO()
    if getattr(picture, "is_animated", False):
        frames, shown = [], []
        for frame in ImageSequence.Iterator(picture):
            frames.append(frame.convert("RGB"))
            shown.append(frame.info.get("duration", 100))  # ms
        rest: dict[str, Any] = {"append_images": frames[1:], "duration": shown, "loop": 0}
        frames[0].save(target, "WEBP", save_all=True, **rest, **_EXACT)
    else:
        whole = picture.convert("RGBA" if "A" in picture.getbands() else "RGB")
        sample = whole.resize((max(whole.width // 3, 1), max(whole.height // 3, 1)), 0)
        drawn = sample.getcolors(_FEW) is not None
        whole.save(target, "WEBP", **(_EXACT if drawn else _SHADED))
    return target.getvalue()
