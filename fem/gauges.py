"""Virtual strain gauges, linear functionals of displacements, at places of a part's surface."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.elements import sampling
from vanelock.fem.stresses import slopes
from vanelock.mesh import Part
from vanelock.mesh.cells import Cell, area_vectors, exterior, solid, surface

# Lobatto's rule of five points along a gauge's length, -1 to 1: it has the ends, which must lie on
# the surface as well.
_POINTS = (-1.0, -((3 / 7) ** 0.5), 0.0, (3 / 7) ** 0.5, 1.0)
_WEIGHTS = (1 / 10, 49 / 90, 32 / 45, 49 / 90, 1 / 10)


@dataclass(frozen=True)
class _SkinPoint:
    """A point of the surface."""

    position: Floats  # (3,), m
    normal: Floats  # (3,), unit outward normal there
    nodes: Integers  # (a,), nodes of its face whose basis functions are not zero there
    weights: Floats  # (a,), these functions
    size: float  # longest side of the face, m


@dataclass(frozen=True)
class _Skin:
    """Faces that belong to one element only."""

    part: Part
    faces: Integers  # (f, m), nodes of each, outward by the right-hand rule
    normals: Floats  # (f, 3), unit outward normals at the faces' middles

    def nearest(self, position: Floats, normal: Floats | None = None) -> _SkinPoint:
        """The point of the surface that is nearest to a position."""
        part = self.part
        allowed = np.arange(len(self.faces))
        if normal is not None:
            allowed = np.flatnonzero(self.normals @ normal > 0.5)
        if not len(allowed):
            raise InputError(f"{part.name}: no face of its surface looks along {normal}")
        corners = part.points[self.faces[allowed, : surface(self.faces.shape[1]).corners]]
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
        """Nearest point of each face, on the reference face, and its distance.

        It is inside the face, or else on one of its sides; infinite where the bound from below of
        its distance is above another's.
        """
        cell = surface(self.faces.shape[1])
        points, ends = self.part.points[self.faces[faces]], cell.nodes[: cell.corners]
        inner, away = _approach(cell, points, position, ends[0], np.eye(2), beyond=1.0)
        inside = inner.min(axis=1) >= 0
        inside &= (inner.sum(axis=1) if cell.corners == 3 else inner.max(axis=1)) <= 1
        away[~inside] = np.inf
        left = np.flatnonzero(~inside & (bound <= away.min() + 1e-12))
        if len(left):
            for a, b in zip(ends, np.roll(ends, -1, axis=0), strict=True):
                place, gap = _approach(cell, points[left], position, a, (b - a)[None], beyond=0.0)
                nearer = gap < away[left]
                inner[left[nearer]], away[left[nearer]] = place[nearer], gap[nearer]
        return inner, away

    def _point(self, face: np.int64, local: Floats) -> _SkinPoint:
        """The point of a face at a place of the reference face."""
        nodes = self.faces[face]
        cell, points = surface(len(nodes)), self.part.points[nodes]
        (values,), (slopes,) = cell.functions(local[None])
        corners, used = points[: cell.corners], np.abs(values) > 1e-12
        size = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).max()
        normal = _unit(np.cross(*(points.T @ slopes).T))
        return _SkinPoint(values @ points, normal, nodes[used], values[used], float(size))


def skin(part: Part) -> _Skin:
    """Find the surface of a part."""
    faces = exterior(part.cells, solid(part.cell_type))
    cell = surface(faces.shape[1])
    middle = cell.nodes[: cell.corners].mean(axis=0)
    return _Skin(part, faces, _unit(area_vectors(part.points, faces, middle[None])[:, 0]))


def _approach(
    cell: Cell, points: Floats, position: Floats, origin: Floats, sides: Floats, beyond: float
) -> tuple[Floats, Floats]:
    """Gauss-Newton method for the nearest points of faces or edges, origin + t·sides.

    Returns those points of the reference face (f, 2), whose t stays within `beyond` of 0 to 1, and
    the distance (f,); nodes are (f, m, 3), sides (s, 2).
    """
    t = np.full((len(points), len(sides)), 1 / (1 + len(sides)))
    for _ in range(30):
        place = origin + t @ sides
        values, slopes = cell.functions(place)
        tangents = points.swapaxes(1, 2) @ slopes @ sides.T
        gap = position - np.einsum("fa,fai->fi", values, points)
        step = np.einsum("fsi,fi->fs", np.linalg.pinv(tangents), gap)
        new = np.clip(t + step, -beyond, 1 + beyond)
        t, moved = new, np.abs(new - t).max()
        if moved < 1e-13:
            break
    return place, np.linalg.norm(gap, axis=1)


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


def _row(part: Part, point: _SkinPoint, direction: Floats) -> sp.csr_array:
    rows = _strain_rows(part, point.nodes, direction)
    return sp.csr_array(sp.csr_array(point.weights[None]) @ rows)


def _in_surface(part: Part, direction: Floats, normal: Floats) -> Floats:
    flat = direction - (direction @ normal) * normal
    if not np.linalg.norm(flat) > 1e-6 * np.linalg.norm(direction):
        raise InputError(f"{part.name}: gauge direction ({_numbers(direction)}) leaves the surface")
    return _unit(flat)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _vector(part: Part, name: str, components: ArrayLike) -> Floats:
    vector = np.asarray(components, float)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)):
        raise InputError(f"{part.name}: gauge {name} = {components!r}: needed are three numbers")
    return vector


def _numbers(vector: Floats) -> str:
    return ", ".join(f"{value:.4g}" for value in vector)


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
