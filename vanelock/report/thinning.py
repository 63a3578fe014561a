"""Fewer triangles of a skin, over some of its own points, so that shapes need no interpolation.

Points are gathered in the cells of a grid (Rossignac and Borrel, "Multi-resolution 3D
approximations for rendering complex scenes", 1993); one of each cell stands for all. The two sides
of a thin wall stay apart, since only points that face the same octant are gathered.
"""

import numpy as np

from vanelock.common.arrays import Floats, Integers


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
