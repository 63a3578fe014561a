"""Virtual strain gauges: linear functionals of the displacements of a part's nodes."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Floats
from vanelock.common.errors import InputError
from vanelock.fem.model import Model
from vanelock.fem.solvers.backend import Sparse
from vanelock.fem.stresses.skin import Skin, SkinPoint, skin
from vanelock.fem.stresses.strains import strain_rows
from vanelock.mesh import Part

# Lobatto's rule of five points along a gauge's length, -1 to 1: it has the ends, which must lie on
# the surface as well.
POINTS = (-1.0, -((3 / 7) ** 0.5), 0.0, (3 / 7) ** 0.5, 1.0)
WEIGHTS = (1 / 10, 49 / 90, 32 / 45, 49 / 90, 1 / 10)


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
    surface: Skin | None = None,
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
    for place, weight in zip(POINTS, WEIGHTS, strict=True):
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


def _row(part: Part, point: SkinPoint, direction: Floats) -> sp.csr_array:
    used = point.weights != 0
    rows = strain_rows(part, point.nodes[used], direction)
    return sp.csr_array(sp.csr_array(point.weights[None, used]) @ rows)


def _in_surface(part: Part, direction: Floats, normal: Floats) -> Floats:
    flat = direction - (direction @ normal) * normal
    if not np.linalg.norm(flat) > 1e-6 * np.linalg.norm(direction):
        raise InputError(f"{part.name}: gauge direction ({_numbers(direction)}) leaves the surface")
    return _unit(flat)


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.linalg.norm(vector))


def _vector(part: Part, name: str, given: ArrayLike) -> Floats:
    vector = np.asarray(given, float)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)):
        raise InputError(f"{part.name}: gauge {name} = {given!r}: needed are three numbers")
    return vector


def _numbers(vector: Floats) -> str:
    return ", ".join(f"{value:.4g}" for value in vector)
