"""Contact frames at the nodes of given meshes, from the faces around them.

A node on an edge belongs to faces of several directions. Contact presses opposed faces together, so
of all pairs of a node's and its mate's normals the most opposed one counts.
"""

import numpy as np
from numpy.typing import NDArray

from vanelock.mesh.exterior import normals

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

ALIKE = np.cos(np.radians(30.0))  # normals of one smooth surface, at one node
ROUND = 2e-6  # of a radius, by which faces on a cylinder may miss it: six digits in a file
OPPOSED = 15.0  # degrees by which mates' faces may miss being parallel
_CLEAR = np.cos(np.radians(45.0))


def candidates(points: Array, faces: Integers, nodes: Integers) -> list[Array]:
    """For each node the directions (c, 3) in which faces around it look.

    The normals of curved faces are taken at the node itself; those of about one direction are
    averaged by the faces' areas. Where their corners lie on a cylinder about the engine axis, as at
    a hook, its normal is taken instead, which flat elements would miss by half the angle they span.
    """
    around = faces[np.isin(faces, nodes).any(axis=1)]
    if not len(around):
        return [np.empty((0, 3)) for _ in nodes]
    normal, area = normals(points, around)
    corners = 3 if faces.shape[1] in (3, 6) else 4
    face, corner = np.nonzero(np.isin(around, nodes))
    order = np.argsort(around[face, corner], kind="stable")
    face, corner = face[order], corner[order]
    owner = around[face, corner]
    found = []
    for node in nodes:
        first, last = np.searchsorted(owner, [node, node + 1])
        own = face[first:last]
        weighted = normal[own, corner[first:last]] * area[own, None]
        radial = cylindrical_axes(points[[node]])[0][0]
        directions = []
        for mean, members in _directions(weighted):
            ends = points[around[own[members], :corners]].reshape(-1, 3)
            radii = np.hypot(ends[:, 0], ends[:, 1])
            if np.ptp(radii) < ROUND * radii.max() and abs(mean @ radial) > ALIKE:
                mean = np.sign(mean @ radial) * radial
            directions.append(mean)
        found.append(np.array(directions).reshape(-1, 3))
    return found


def _directions(weighted: Array) -> list[tuple[Array, list[int]]]:
    """Unit means of vectors (k, 3) grouped by direction, with the rows of each, longest first."""
    groups: list[tuple[Array, list[int]]] = []
    length = np.linalg.norm(weighted, axis=1)
    for row in np.argsort(-length, kind="stable"):
        if not length[row] > 0:
            continue
        for i, (mean, members) in enumerate(groups):
            if mean @ weighted[row] > ALIKE * length[row] * np.linalg.norm(mean):
                groups[i] = mean + weighted[row], [*members, int(row)]
                break
        else:
            groups.append((weighted[row], [int(row)]))
    return [(mean / np.linalg.norm(mean), members) for mean, members in groups]


def opposed(own: Array, other: Array) -> tuple[Array, float, bool]:
    """The normal that two nodes in contact share, from the directions of their faces."""
    if not len(own) or not len(other):
        return np.zeros(3), 180.0, False
    cosine = (-own @ other.T).clip(-1, 1)
    a, b = np.unravel_index(cosine.argmax(), cosine.shape)
    normal = own[a] - other[b]
    normal /= max(float(np.linalg.norm(normal)), 1e-300)
    rivals = (cosine > np.cos(np.radians(OPPOSED))) & (own @ normal < _CLEAR)[:, None]
    return normal, float(np.degrees(np.arccos(cosine[a, b]))), bool(rivals.any())


def frames(normal: Array, wanted: Array, instead: Array) -> Array:
    """Frames (k, 3, 3): the normals, a first tangent, and their cross product."""
    along = np.abs(np.sum(normal * wanted, axis=1)) > _CLEAR
    first = np.where(along[:, None], instead, wanted)
    first = first - np.sum(first * normal, axis=1, keepdims=True) * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normal, first, np.cross(normal, first)], axis=1)


def cylindrical_axes(points: Array) -> tuple[Array, Array]:
    """Radial and circumferential unit vectors (k, 3) at points."""
    angle = np.arctan2(points[:, 1], points[:, 0])
    c, s, zero = np.cos(angle), np.sin(angle), np.zeros(len(angle))
    return np.stack([c, s, zero], axis=1), np.stack([-s, c, zero], axis=1)
