"""A 3-D view as the page's viewer reads it: one sector, quantised, and the wave's shapes on it.

Coordinates are 16-bit fractions of a body's box, displacements 16-bit fractions of a motion's
largest component, normals 8-bit; all base64, little-endian. The viewer draws the sector N times.
"""

from base64 import b64encode
from typing import Any, Final

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.render import style
from vanelock.render.scenes import annulus
from vanelock.render.scenes import views as cameras
from vanelock.render.scenes.scene import Camera
from vanelock.common.arrays import Complex
from vanelock.report.blocks import Body, Motion, View
from vanelock.report.bodies import shaded

_DRAWN: Final = 0.05  # largest displacement as first drawn, as a share of the ring's outer radius
_STOPS: Final = 11  # of the colour map


def scene(view: View) -> dict[str, Any]:
    """What the viewer needs, ready for JSON."""
    _check(view)
    places = [shaded(body.points, body.triangles) for body in view.bodies]
    points = np.concatenate([np.asarray(body.points, float) for body in view.bodies])
    radius = float(np.hypot(points[:, 0], points[:, 1]).max())
    return {
        "sectors": view.bodies[0].sectors,
        "bodies": [_body(body, *place) for body, place in zip(view.bodies, places, strict=True)],
        "motions": [
            _motion(motion, [place[0] for place in places], view.bodies[0].sectors, radius)
            for motion in view.motions
        ],
        "cameras": {"ring": _ring_camera(points), "sector": _sector_camera(points)},
        "colours": [to_hex(style.AMPLITUDE_MAP(i / (_STOPS - 1))) for i in range(_STOPS)],
    }


def _check(view: View) -> None:
    if not view.bodies or not view.motions:
        raise InputError(f"{view.title}: a view needs a body and a motion")
    if len({body.sectors for body in view.bodies}) > 1:
        rings = [body.sectors for body in view.bodies]
        raise InputError(f"{view.title}: sectors: given {rings}: must be equal")
    for motion in view.motions:
        wanted = [np.shape(body.points) for body in view.bodies]
        given = [np.shape(shape) for shape in motion.shapes]
        if given != wanted:
            raise InputError(f"{motion.name}: shapes of {given}: {wanted} are needed")
        if not all(np.all(np.isfinite(shape)) for shape in motion.shapes):
            raise InputError(f"{motion.name}: shape holds values that are not finite")
        if not any(np.any(shape) for shape in motion.shapes):
            raise InputError(f"{motion.name}: zero everywhere: there is nothing to draw")


def _body(
    body: Body, split: NDArray[np.int64], triangles: NDArray[np.int64], normals: Floats
) -> dict[str, Any]:
    points = np.asarray(body.points, float)
    low = points.min(axis=0)
    span = np.maximum(np.ptp(points, axis=0), 1e-9)
    place = np.round((points - low) / span * 65535).astype("<u2")[split]
    first = np.zeros(len(points), np.int64)
    first[split[::-1]] = np.arange(len(split))[::-1]  # a doubled point's lines run through one
    return {
        "name": body.name,
        "colour": style.part_colour(body.name),
        "low": low.tolist(),
        "span": span.tolist(),
        "points": _text(_padded(place)),
        "normals": _text(_padded(np.round(127 * normals).astype("i1"))),
        "triangles": _text(triangles.astype("<u4")),
        "outline": _text(first[np.asarray(body.outline, np.int64).reshape(-1, 2)].astype("<u4")),
    }


def _motion(
    motion: Motion, splits: list[NDArray[np.int64]], sectors: int, radius: float
) -> dict[str, Any]:
    shapes: list[Complex] = [np.asarray(shape, complex) for shape in motion.shapes]
    unit = max(float(np.abs(np.array([s.real, s.imag])).max()) for s in shapes)
    largest = max(float(annulus.peak(shape).max()) for shape in shapes)
    drawn = _DRAWN * radius
    return {
        "name": motion.name,
        "note": motion.note,
        "diameter": motion.nodal_diameter,
        "wave": annulus.wave_name(motion.nodal_diameter, sectors),
        "frequency": motion.frequency if np.isfinite(motion.frequency) else None,
        "relative": motion.relative,
        "unit": unit,
        "largest": largest,
        "instant": annulus.largest_instant(*shapes) % (2 * np.pi),
        "scale": drawn / largest if motion.relative else annulus.round_scale(largest, drawn),
        "shapes": [_shape(s[split] / unit) for s, split in zip(shapes, splits, strict=True)],
    }


def _shape(shape: Complex) -> dict[str, str]:
    """Real and imaginary part of a shape whose components are at most 1."""
    parts = {"re": shape.real, "im": shape.imag}
    return {
        name: _text(_padded(np.round(32767 * value).astype("<i2"))) for name, value in parts.items()
    }


def _ring_camera(points: Floats) -> dict[str, Any]:
    """Right, up and backward direction, and centre and radius of what is to be seen."""
    low, high = points[:, 2].min(), points[:, 2].max()
    radius = float(np.hypot(points[:, 0], points[:, 1]).max())
    middle = np.array([0.0, 0.0, (low + high) / 2])
    return _framed(_rows(cameras.ring_camera(points)), middle, radius)


def _sector_camera(points: Floats) -> dict[str, Any]:
    rows = _rows(cameras.sector_camera(points))
    seen = points @ rows.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    radius = 1.1 * float((high - low)[:2].max()) / 2  # room for its motion
    return _framed(rows, (low + high) / 2 @ rows, radius)


def _rows(camera: Camera) -> Floats:
    """Right, up and backward direction of a camera, as rows."""
    backward = -np.asarray(camera.direction, float)
    backward = backward / np.linalg.norm(backward)
    right = np.cross(np.asarray(camera.up, float), backward)
    right = right / np.linalg.norm(right)
    return np.vstack([right, np.cross(backward, right), backward])


def _framed(rows: Floats, centre: Floats, radius: float) -> dict[str, Any]:
    return {"rows": rows.tolist(), "centre": centre.tolist(), "radius": radius}


def _padded(values: NDArray[Any]) -> NDArray[Any]:
    """(n, 4) from (n, 3): graphics hardware wants rows at multiples of four bytes."""
    return np.pad(values, ((0, 0), (0, 1)))


def _text(values: NDArray[Any]) -> str:
    return b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
