"""A 3-D view as the page's viewer reads it: one sector, quantised, and the wave's shapes on it.

Coordinates are 16-bit fractions of a body's box, displacements 16-bit fractions of a motion's
largest component, normals 8-bit; all base64, little-endian. The viewer draws the sector N times.

The skin of a mesh as a body of the 3-D view, and its shading.

Fewer triangles of a skin, over some of its own points, so that shapes need no interpolation.

Points are gathered in the cells of a grid (Rossignac and Borrel, "Multi-resolution 3D
approximations for rendering complex scenes", 1993); one of each cell stands for all. The two sides
of a thin wall stay apart, since only points that face the same octant are gathered.
"""

from base64 import b64encode
from typing import Any, Final

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from vanelock.common.arrays import Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import annulus
from vanelock.render.scenes.scene import Camera, ring_camera, sector_camera
from vanelock.render.scenes.surface import surface
from vanelock.report.blocks import Body, Motion, View

_BEND: Final = np.radians(35.0)


def thinned(
    points: Floats, triangles: Integers, outline: Integers, most: int
) -> tuple[Integers, Integers, Integers]:
    """At most so many triangles."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], area)
    octant = (normals > 0) @ np.array([1, 2, 4])
    edges = np.bincount(outline.ravel(), minlength=len(points))
    stands = np.arange(len(points))
    size = np.sqrt(np.linalg.norm(area, axis=1).sum() / most)  # two triangles a square
    drawn = triangles
    while len(drawn) > most:
        stands = _representatives(points, octant, edges, size)
        drawn = _distinct(stands[triangles])
        size *= 1.15
    kept = np.unique(drawn)
    place = np.full(len(points), -1)
    place[kept] = np.arange(len(kept))
    lines = place[_distinct(stands[outline])]
    return kept, place[drawn], lines[np.all(lines >= 0, axis=1)]


def _representatives(points: Floats, octant: Integers, edges: Integers, size: float) -> Integers:
    """(m,) the point that stands for each: where most outlines meet, else nearest the middle."""
    cells = np.floor((points - points.min(axis=0)) / size).astype(np.int64)
    keys = np.column_stack([cells, octant])
    _, cell = np.unique(keys, axis=0, return_inverse=True)
    cell = cell.ravel()
    count = np.bincount(cell)
    middle = np.column_stack([np.bincount(cell, points[:, i]) / count for i in range(3)])
    far = np.linalg.norm(points - middle[cell], axis=1)
    order = np.lexsort((far, -edges, cell))
    first = order[np.concatenate([[0], np.cumsum(count)[:-1]])]
    return np.asarray(first[cell])


def _distinct(faces: Integers) -> Integers:
    """Faces whose corners differ, each once, in their own sense."""
    ordered = np.sort(faces, axis=1)
    whole = np.all(ordered[:, 1:] != ordered[:, :-1], axis=1)
    _, first = np.unique(ordered[whole], axis=0, return_index=True)
    return np.asarray(faces[whole][first])


def body_of(part: Part, most: int = 60_000) -> tuple[Body, Integers]:
    """Skin of a part as a body, and the part's nodes (m,) that it took.

    A shape of the part (n, 3) becomes the body's by `shape[nodes]`.

    Parameters
    ----------
    part : Part
        The part.
    most : int
        A skin of more triangles is thinned: N times as many have to turn smoothly.

    Raises
    ------
    InputError
        If pictures do not know the part's elements.
    """
    skin = surface(part, corners_only=True)  # a quarter of the triangles
    points, triangles, outline = part.points[skin.nodes], skin.triangles, skin.outline
    nodes = skin.nodes
    if len(triangles) > most:
        kept, triangles, outline = thinned(points, triangles, outline, most)
        points, nodes = points[kept], nodes[kept]
    return Body(points, triangles, part.sectors, outline, part.name), nodes


def shaded(points: Floats, triangles: NDArray[np.integer]) -> tuple[Integers, Integers, Floats]:
    """Points doubled along edges that bend by more than `_BEND`, and their normals.

    The corners of triangles that meet in a point are one point where a chain of blunt edges joins
    them: shading is smooth there and crisp across sharp edges.
    """
    faces: Integers = triangles.astype(np.int64)
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)  # twice the area, along the normal
    length = np.linalg.norm(area, axis=1, keepdims=True)
    normal = area / np.where(length > 0, length, 1)
    # Corner 3 t + i is triangle t's i-th; edge i of a triangle runs from its corner i to the next.
    count = 3 * len(faces)
    corner = np.arange(count).reshape(-1, 3)
    first, second = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    ends = faces.ravel()[np.column_stack([first, second])]
    order = np.lexsort(np.sort(ends, axis=1).T)
    ends, first, second = ends[order], first[order], second[order]
    pair = np.flatnonzero(np.all(np.sort(ends[1:], axis=1) == np.sort(ends[:-1], axis=1), axis=1))
    cosine = np.sum(normal[first[pair] // 3] * normal[first[pair + 1] // 3], axis=1)
    pair = pair[cosine > np.cos(_BEND)]
    same = ends[pair, 0] == ends[pair + 1, 0]  # two triangles seen alike run it against each other
    mates = np.where(same, first[pair + 1], second[pair + 1])
    others = np.where(same, second[pair + 1], first[pair + 1])
    one = np.concatenate([first[pair], second[pair]])
    two = np.concatenate([mates, others])
    joined = coo_array((np.ones(len(one)), (one, two)), shape=(count, count))
    _, group = connected_components(joined, directed=False)
    _, representative, numbered = np.unique(group, return_index=True, return_inverse=True)
    split = faces.ravel()[representative]
    normals = np.zeros((len(split), 3))
    np.add.at(normals, numbered, np.repeat(area, 3, axis=0))
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    corners: Integers = numbered.astype(np.int64).reshape(-1, 3)
    return split, corners, normals / np.where(size > 0, size, 1)


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


def _body(body: Body, split: Integers, triangles: Integers, normals: Floats) -> dict[str, Any]:
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


def _motion(motion: Motion, splits: list[Integers], sectors: int, radius: float) -> dict[str, Any]:
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
    rows = _rows(ring_camera(points)).tolist()
    return {"rows": rows, "centre": [0.0, 0.0, float(low + high) / 2], "radius": radius}


def _sector_camera(points: Floats) -> dict[str, Any]:
    rows = _rows(sector_camera(points))
    seen = points @ rows.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    radius = 1.1 * float((high - low)[:2].max()) / 2  # room for its motion
    centre = ((low + high) / 2 @ rows).tolist()
    return {"rows": rows.tolist(), "centre": centre, "radius": radius}


def _rows(camera: Camera) -> Floats:
    """Right, up and backward direction of a camera, as rows."""
    backward = -np.asarray(camera.direction, float)
    backward = backward / np.linalg.norm(backward)
    right = np.cross(np.asarray(camera.up, float), backward)
    right = right / np.linalg.norm(right)
    return np.vstack([right, np.cross(backward, right), backward])


def _padded(values: NDArray[Any]) -> NDArray[Any]:
    """(n, 4) from (n, 3): graphics hardware wants rows at multiples of four bytes."""
    return np.pad(values, ((0, 0), (0, 1)))


def _text(values: NDArray[Any]) -> str:
    return b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
