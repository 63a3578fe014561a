"""The skin of a mesh as a body of the 3-D view, and its shading."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from vanelock.common.arrays import Floats, Integers
from vanelock.mesh import Part
from vanelock.render.scenes.surface import surface
from vanelock.report.blocks import Body
from vanelock.report.thinning import thinned


def body_of(part: Part, corners_only: bool = True, most: int = 60_000) -> tuple[Body, Integers]:
    """Skin of a part as a body, and the part's nodes (m,) that it took.

    A shape of the part (n, 3) becomes the body's by `shape[nodes]`.

    Parameters
    ----------
    part : Part
        The part.
    corners_only : bool
        Draw through the elements' corners alone: a quarter of the triangles.
    most : int
        A skin of more triangles is thinned: N times as many have to turn smoothly.

    Raises
    ------
    InputError
        If pictures do not know the part's elements.
    """
    skin = surface(part, corners_only=corners_only)
    points, triangles, outline = part.points[skin.nodes], skin.triangles, skin.outline
    nodes = skin.nodes
    if len(triangles) > most:
        kept, triangles, outline = thinned(points, triangles, outline, most)
        points, nodes = points[kept], nodes[kept]
    return Body(points, triangles, part.sectors, outline, part.name), nodes


def shaded(
    points: Floats, triangles: NDArray[np.integer], bend: float = 35.0
) -> tuple[Integers, Integers, Floats]:
    """Points doubled along edges that bend by more than `bend` degrees, and their normals.

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
    pair = pair[cosine > np.cos(np.radians(bend))]
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
