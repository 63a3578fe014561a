"""Virtual strain gauges, linear functionals of displacements, at places of a part's surface."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.elements import reference_element, sampling, shape_functions
from vanelock.fem.model import Model
from vanelock.fem.solvers.backend import Sparse
from vanelock.fem.stresses import slopes
from vanelock.mesh import Part

# Lobatto's rule of five points along a gauge's length, -1 to 1: it has the ends, which must lie on
# the surface as well.
_POINTS = (-1.0, -((3 / 7) ** 0.5), 0.0, (3 / 7) ** 0.5, 1.0)
_WEIGHTS = (1 / 10, 49 / 90, 32 / 45, 49 / 90, 1 / 10)


@dataclass(frozen=True)
class _SkinPoint:
    """A point of the surface."""

    position: Floats  # (3,), m
    normal: Floats  # (3,), unit outward normal there
    nodes: Integers  # (a,), nodes of its element
    weights: Floats  # (a,), the element's basis functions there, zero off the face
    size: float  # longest side of the face, m


@dataclass(frozen=True)
class _Skin:
    """Faces that belong to one element only."""

    part: Part
    cells: Integers  # (f,), element of each
    faces: Integers  # (f,), which of its faces it is
    corners: Integers  # (f, 3 or 4), its corner nodes
    normals: Floats  # (f, 3), unit outward normals at the faces' middles

    def nearest(self, position: Floats, normal: Floats | None = None) -> _SkinPoint:
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

    def _point(self, face: np.int64, local: Floats) -> _SkinPoint:
        """The point of a face at a place of the reference cell."""
        nodes = self.part.cells[self.cells[face]]
        points = self.part.points[nodes]
        outward = _faces(self.part.cell_type)[self.faces[face]][2]
        values, slopes = shape_functions(self.part.cell_type, local[None])
        normal = np.linalg.solve((points.T @ slopes[0]).T, outward)
        corners = self.part.points[self.corners[face]]
        size = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).max()
        weights = np.where(np.abs(values[0]) > 1e-12, values[0], 0.0)
        return _SkinPoint(
            values[0] @ points, normal / np.linalg.norm(normal), nodes, weights, float(size)
        )


def skin(part: Part) -> _Skin:
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
        middle = origin + sides.sum(axis=0) / (3 if local.shape[1] == 3 else 2)
        _, slopes = shape_functions(part.cell_type, middle[None])
        here = which == face
        jacobian = part.points[part.cells[cells[here]]].transpose(0, 2, 1) @ slopes[0]
        normals[here] = np.einsum("eji,j->ei", np.linalg.inv(jacobian), outward)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return _Skin(part, cells, which, corners[single], normals)


def _faces(cell_type: str) -> list[tuple[Floats, Floats, Floats]]:
    return _HEXA if cell_type.startswith("hexa") else _TETRA


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


@dataclass(frozen=True)
class Gauge:
    """A strain gauge on the surface of a part.

    Attributes
    ----------
    position, direction, normal : (3,) float
        Its middle, m, its direction in the surface, and the surface's outward normal there.
    distance : float
        From the position that was asked for to the surface, m.
    row : (1, 3 n) csr_array
        Strain = row @ displacements of the part's n nodes, x, y and z of each in turn; 1/m.
    """

    position: Floats
    direction: Floats
    normal: Floats
    distance: float
    row: sp.csr_array

    def strain(self, u: Array) -> Any:
        """Strain, () or (k,), of displacement fields (n, 3) or (n, 3, k), m."""
        return (self.row @ u.reshape(3 * len(u), -1))[0].reshape(u.shape[2:])[()]


def gauge(
    part: Part,
    position: ArrayLike,
    direction: ArrayLike,
    length: float | None = None,
    normal: ArrayLike | None = None,
    tolerance: float | None = None,
    surface: _Skin | None = None,
) -> Gauge:
    """Place a strain gauge on a part.

    It reads the field of `strain`, interpolated between the nodes of the face, along a direction
    of the surface: at a point, or as the mean over a length.

    Parameters
    ----------
    part : Part
    position : (3,)
        Where, m; the gauge sits at the nearest point of the surface.
    direction : (3,)
        Which strain, projected into the surface.
    length : float, optional
        Length of the gauge, m, that it takes the mean over; a real one has 1 to 3 mm.
    normal : (3,), optional
        The outward normal, roughly: faces that lean from it by more than 60 degrees, such as a
        thin wall's other side, are left out.
    tolerance : float, optional
        Largest distance between position and surface, m; by default a quarter of the face's
        longest side.
    surface : Skin, optional
        `skin(part)`, to place many gauges on one part.

    Raises
    ------
    InputError
        If the surface is further away, the direction is normal to it, or the gauge's ends lie off
        the surface.
    """
    where, along = _vector(part, "position", position), _vector(part, "direction", direction)
    outward = None if normal is None else _unit(_vector(part, "normal", normal))
    surface = surface or skin(part)
    middle = surface.nearest(where, outward)
    distance = float(np.linalg.norm(middle.position - where))
    allowed = middle.size / 4 if tolerance is None else tolerance
    if distance > allowed:
        raise InputError(
            f"{part.name}: gauge at ({_numbers(where)}) m: the surface is {distance:.3g} m away; "
            f"allowed are {allowed:.3g} m"
        )
    flat = _in_surface(part, along, middle.normal)
    if length is None:
        row = _row(part, middle, flat)
        return Gauge(middle.position, flat, middle.normal, distance, row)
    if not length > 0:
        raise InputError(f"{part.name}: gauge length = {length:g} m: must be positive")
    rows = []
    for place, weight in zip(_POINTS, _WEIGHTS, strict=True):
        target = middle.position + 0.5 * length * place * flat
        point = surface.nearest(target, middle.normal)
        off = target - point.position
        if np.linalg.norm(off - (off @ point.normal) * point.normal) > length / 20:
            raise InputError(
                f"{part.name}: gauge of {length:g} m at ({_numbers(middle.position)}) m: an end "
                "lies off the surface"
            )
        rows.append(0.5 * weight * _row(part, point, _in_surface(part, flat, point.normal)))
    row = sp.csr_array(sum(rows[1:], rows[0]))
    return Gauge(middle.position, flat, middle.normal, distance, row)


def free_rows(model: Model, rows: Sparse | Array) -> sp.csr_array:
    """Rows (g, 3 n) on all nodes' displacements as rows on a model's free dofs, (g, free)."""
    dofs = model.dofs.ravel()
    free = np.flatnonzero(dofs >= 0)
    spread = sp.csr_array(
        (np.ones(len(free)), (free, dofs[free])), shape=(len(dofs), model.K.shape[0])
    )
    return sp.csr_array(sp.csr_array(rows) @ spread)


def _row(part: Part, point: _SkinPoint, direction: Floats) -> sp.csr_array:
    used = point.weights != 0
    rows = _strain_rows(part, point.nodes[used], direction)
    return sp.csr_array(sp.csr_array(point.weights[None, used]) @ rows)


def _in_surface(part: Part, direction: Floats, normal: Floats) -> Floats:
    flat = direction - (direction @ normal) * normal
    if not np.linalg.norm(flat) > 1e-6 * np.linalg.norm(direction):
        raise InputError(f"{part.name}: gauge direction ({_numbers(direction)}) leaves the surface")
    return _unit(flat)


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.linalg.norm(vector))


def _vector(part: Part, name: str, components: ArrayLike) -> Floats:
    vector = np.asarray(components, float)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)):
        raise InputError(f"{part.name}: gauge {name} = {components!r}: needed are three numbers")
    return vector


def _numbers(vector: Floats) -> str:
    return ", ".join(f"{value:.4g}" for value in vector)


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


def _strain_rows(part: Part, nodes: Integers, direction: Floats) -> sp.csr_array:
    """Rows that give the nodal strain of `strain` along a unit vector, at a few nodes."""
    chosen = np.flatnonzero(np.isin(part.cells, nodes).any(axis=1))
    cells = part.cells[chosen]
    points, extrapolation = sampling(part.cell_type)
    gradients, determinant = slopes(part, cells, points)
    e, g, a, _ = gradients.shape
    along = (gradients @ direction)[..., None] * direction  # d ε_dd / d u, (e, g, a, 3)
    nodal = extrapolation @ along.reshape(e, g, 3 * a)
    volume = determinant.mean(axis=1)
    columns = (3 * cells[:, :, None] + np.arange(3)).reshape(e, 3 * a)
    rows = []
    for node in nodes:
        here, corner = np.nonzero(cells == node)
        share = volume[here] / volume[here].sum()
        values = share[:, None] * nodal[here, corner]
        row = sp.coo_array(
            (values.ravel(), (np.zeros(values.size, int), columns[here].ravel())),
            shape=(1, 3 * len(part.points)),
        )
        rows.append(row.tocsr())
    return sp.csr_array(sp.vstack(rows))
