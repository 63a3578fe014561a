"""The faces of a part's surface, and the point of them that is nearest to a position."""

from dataclasses import dataclass

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.elements.reference import reference_element, shape_functions
from vanelock.mesh import Part

# A face of the reference cell: a corner, the two sides from it, and the outward normal.
_UNIT = np.eye(3)
_TETRA = [(np.zeros(3), np.delete(_UNIT, axis, axis=0), -_UNIT[axis]) for axis in range(3)] + [
    (_UNIT[0], np.array([_UNIT[1] - _UNIT[0], _UNIT[2] - _UNIT[0]]), np.ones(3))
]
_HEXA = [
    (side * _UNIT[axis], np.delete(_UNIT, axis, axis=0), (2 * side - 1) * _UNIT[axis])
    for axis in range(3)
    for side in (0, 1)
]


@dataclass(frozen=True)
class SkinPoint:
    """A point of the surface.

    Attributes
    ----------
    position, normal : (3,) float
        Where it is, m, and the unit outward normal there.
    nodes : (a,) int
        Nodes of its element.
    weights : (a,) float
        The element's basis functions there, zero off the face.
    size : float
        Longest side of the face, m.
    """

    position: Floats
    normal: Floats
    nodes: Integers
    weights: Floats
    size: float


@dataclass(frozen=True)
class Skin:
    """Faces that belong to one element only.

    Attributes
    ----------
    part : Part
    cells, faces : (f,) int
        Element of each, and which of its faces.
    corners : (f, 3 or 4) int
        Its corner nodes.
    normals : (f, 3) float
        Unit outward normals at the faces' middles.
    """

    part: Part
    cells: Integers
    faces: Integers
    corners: Integers
    normals: Floats

    def nearest(self, position: Floats, normal: Floats | None = None) -> SkinPoint:
        """The point of the surface that is nearest to a position."""
        part = self.part
        allowed = np.arange(len(self.cells))
        if normal is not None:
            allowed = np.flatnonzero(self.normals @ normal > 0.5)
        if not len(allowed):
            raise InputError(f"{part.name}: no face of its surface looks along {normal}")
        corners = part.points[self.corners[allowed]]
        middle = corners.mean(axis=1)
        # A curved face bulges out of the sphere round its corners; the margin allows for that.
        radius = 1.3 * np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
        away = np.linalg.norm(middle - position, axis=1)
        least = np.linalg.norm(corners - position, axis=2).min()
        bound = away - radius
        near = bound <= least
        inner, distance = self._closest(allowed[near], bound[near], position)
        best = int(np.lexsort((allowed[near], np.round(distance, 12)))[0])
        return self._point(allowed[near][best], inner[best])

    def _closest(self, faces: Integers, bound: Floats, position: Floats) -> tuple[Floats, Floats]:
        """Nearest point of each face, on the reference cell, and its distance.

        It is inside the face, or else on one of its sides; infinite where the bound from below of
        its distance is above another's.
        """
        cell_type = self.part.cell_type
        points = self.part.points[self.part.cells[self.cells[faces]]]
        known = _faces(cell_type)
        origin = np.array([known[face][0] for face in self.faces[faces]])
        sides = np.array([known[face][1] for face in self.faces[faces]])
        ends = [origin, origin + sides[:, 0], origin + sides[:, 1]]
        inner, local, away = _approach(cell_type, points, position, origin, sides, beyond=1.0)
        inside = local.min(axis=1) >= 0
        if len(self.corners[0]) == 3:
            inside &= local.sum(axis=1) <= 1
        else:
            inside &= local.max(axis=1) <= 1
            ends.insert(2, origin + sides.sum(axis=1))
        away[~inside] = np.inf
        left = np.flatnonzero(~inside & (bound <= away.min() + 1e-12))
        if len(left):
            for a, b in zip(ends, ends[1:] + ends[:1], strict=True):
                side = (b - a)[left, None]
                place, _, gap = _approach(
                    cell_type, points[left], position, a[left], side, beyond=0.0
                )
                nearer = gap < away[left]
                inner[left[nearer]], away[left[nearer]] = place[nearer], gap[nearer]
        return inner, away

    def _point(self, face: np.int64, place: Floats) -> SkinPoint:
        """The point of a face at a place of the reference cell."""
        nodes = self.part.cells[self.cells[face]]
        points = self.part.points[nodes]
        outward = _faces(self.part.cell_type)[self.faces[face]][2]
        values, slopes = shape_functions(self.part.cell_type, place[None])
        normal = np.linalg.solve((points.T @ slopes[0]).T, outward)
        corners = self.part.points[self.corners[face]]
        size = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).max()
        weights = np.where(np.abs(values[0]) > 1e-12, values[0], 0.0)
        return SkinPoint(
            values[0] @ points, normal / np.linalg.norm(normal), nodes, weights, float(size)
        )


def skin(part: Part) -> Skin:
    """Find the surface of a part."""
    reference = reference_element(part.cell_type)
    faces = _faces(part.cell_type)
    count = 8 if part.cell_type.startswith("hexa") else 4
    local = np.array(
        [
            np.flatnonzero(np.abs((reference.nodes[:count] - origin) @ outward) < 1e-12)
            for origin, _, outward in faces
        ]
    )
    corners = part.cells[:, local].reshape(-1, local.shape[1])
    _, first, times = np.unique(
        np.sort(corners, axis=1), axis=0, return_index=True, return_counts=True
    )
    single = np.sort(first[times == 1])
    cells, which = np.divmod(single, len(faces))
    normals = np.empty((len(single), 3))
    for face, (origin, sides, outward) in enumerate(faces):
        middle = _middle(origin, sides, triangle=local.shape[1] == 3)
        _, slopes = shape_functions(part.cell_type, middle[None])
        here = which == face
        jacobian = part.points[part.cells[cells[here]]].transpose(0, 2, 1) @ slopes[0]
        normals[here] = np.einsum("eji,j->ei", np.linalg.inv(jacobian), outward)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return Skin(part, cells, which, corners[single], normals)


def _faces(cell_type: str) -> list[tuple[Floats, Floats, Floats]]:
    return _HEXA if cell_type.startswith("hexa") else _TETRA


def _middle(origin: Floats, sides: Floats, triangle: bool) -> Floats:
    return np.asarray(origin + sides.sum(axis=0) / (3 if triangle else 2))


def _approach(
    cell_type: str, points: Floats, position: Floats, origin: Floats, sides: Floats, beyond: float
) -> tuple[Floats, Floats, Floats]:
    """Gauss-Newton method for the nearest points of faces or edges, origin + t·sides.

    Returns those points of the reference cell (f, 3), t (f, s), which stays within `beyond` of 0 to
    1, and the distance (f,); nodes are (f, a, 3), origins (f, 3), sides (f, s, 3).
    """
    t = np.full(sides.shape[:2], 1 / (1 + sides.shape[1]))
    for _ in range(30):
        place = origin + np.einsum("fs,fsi->fi", t, sides)
        values, slopes = shape_functions(cell_type, place)
        tangents = points.swapaxes(1, 2) @ slopes @ sides.swapaxes(1, 2)
        gap = position - np.einsum("fa,fai->fi", values, points)
        step = np.einsum("fsi,fi->fs", np.linalg.pinv(tangents), gap)
        new = np.clip(t + step, -beyond, 1 + beyond)
        t, moved = new, np.abs(new - t).max()
        if moved < 1e-13:
            break
    return place, t, np.linalg.norm(gap, axis=1)
