"""The faces of a part's surface, and the point of them that is nearest to a position."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.fem.elements.reference import reference_element, shape_functions
from vanelock.mesh import Part

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

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

    position: Array
    normal: Array
    nodes: Integers
    weights: Array
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
    normals: Array

    def nearest(self, position: Array, normal: Array | None = None) -> SkinPoint:
        """The point of the surface that is nearest to a position.

        Parameters
        ----------
        position : (3,) float
        normal : (3,) float, optional
            Unit vector; only faces whose outward normal leans from it by less than 60 degrees.

        Raises
        ------
        InputError
            If there is no such face.
        """
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
        candidates = np.flatnonzero(bound <= least)
        found: list[tuple[float, int, SkinPoint]] = []
        for i in candidates[np.argsort(bound[candidates])]:
            if found and bound[i] > min(found)[0] + 1e-12:
                break  # no further face is nearer
            point = self._closest(allowed[i], position)
            distance = float(np.linalg.norm(point.position - position))
            found.append((round(distance, 12), int(i), point))
        return min(found)[2]

    def _closest(self, face: np.int64, position: Array) -> SkinPoint:
        """Nearest point of one face: inside it, or else on one of its sides."""
        cell_type, nodes = self.part.cell_type, self.part.cells[self.cells[face]]
        points = self.part.points[nodes]
        origin, sides, outward = _faces(cell_type)[self.faces[face]]
        triangle = len(self.corners[face]) == 3
        inner, local = _approach(cell_type, points, position, origin, sides, beyond=1.0)
        inside = local.min() >= 0 and (local.sum() <= 1 if triangle else local.max() <= 1)
        if not inside:
            ends = [origin, origin + sides[0], origin + sides[1]]
            if not triangle:
                ends.insert(2, origin + sides.sum(axis=0))
            tries = [
                _approach(cell_type, points, position, a, (b - a)[None], beyond=0.0)[0]
                for a, b in zip(ends, ends[1:] + ends[:1], strict=True)
            ]
            places = [shape_functions(cell_type, p[None])[0][0] @ points for p in tries]
            inner = tries[int(np.argmin([np.linalg.norm(p - position) for p in places]))]
        values, slopes = shape_functions(cell_type, inner[None])
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


def _faces(cell_type: str) -> list[tuple[Array, Array, Array]]:
    return _HEXA if cell_type.startswith("hexa") else _TETRA


def _middle(origin: Array, sides: Array, triangle: bool) -> Array:
    return np.asarray(origin + sides.sum(axis=0) / (3 if triangle else 2))


def _approach(
    cell_type: str, points: Array, position: Array, origin: Array, sides: Array, beyond: float
) -> tuple[Array, Array]:
    """Gauss-Newton method for the nearest point of a face or an edge, origin + t·sides.

    Returns that point of the reference cell, and t, which stays within `beyond` of 0 to 1.
    """
    t = np.full(len(sides), 1 / (1 + len(sides)))
    for _ in range(30):
        values, slopes = shape_functions(cell_type, (origin + t @ sides)[None])
        tangents = points.T @ slopes[0] @ sides.T
        step = np.linalg.lstsq(tangents, position - values[0] @ points, rcond=None)[0]
        new = np.clip(t + step, -beyond, 1 + beyond)
        t, moved = new, np.abs(new - t).max()
        if moved < 1e-13:
            break
    return origin + t @ sides, t
