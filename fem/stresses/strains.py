"""Strain of a displacement field: at points of each element, at the nodes, and its energy.

A strain is the vector (ε_xx, ε_yy, ε_zz, γ_yz, γ_zx, γ_xy), with engineering shears γ = 2ε (Voigt).

At the nodes: the strains at each element's sampling points are extrapolated to its nodes, and a
node takes the mean of its elements, weighted by their volumes. Against projection onto the basis
functions this is no worse on regular meshes and better on distorted ones, and needs no solution.
"""

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.elements.reference import reference_element, sampling, shape_functions
from vanelock.fem.material import Material
from vanelock.fem.model import Model
from vanelock.mesh import Part

ENTRIES = 2**20
"""Displacement gradients held at a time; some tens of MB with what is made of them."""


def strain(part: Part, u: Array, growth: ArrayLike | None = None) -> Array:
    """Strain at the nodes of a part.

    Parameters
    ----------
    part : Part
        Mesh of the elements that `assemble` takes.
    u : (nodes, 3) or (nodes, 3, k), real or complex
        Displacement fields, m.
    growth : float or (nodes,) float, optional
        Thermal strain α (T - T_ref) that is taken off the normal strains: what is left is elastic.

    Returns
    -------
    (nodes, 6) or (nodes, 6, k)
        xx, yy, zz, yz, zx, xy; shears are engineering ones.

    Raises
    ------
    InputError
        If the field does not belong to the part.
    """
    total, volume = strain_sums(part, u, growth)
    total /= volume.reshape(-1, *(1,) * (total.ndim - 1))
    return total


def strain_sums(part: Part, u: Array, growth: ArrayLike | None = None) -> tuple[Array, Floats]:
    """Sum over each node's elements of strain times volume, shaped as `strain`; the volumes' sum.

    For nodes that have elements in a neighbouring part too. Thermal strain (nodes,), or one number,
    is taken off the normal strains where it is given as `growth`.
    """
    fields = columns(part, u)
    k = fields.shape[2]
    points, extrapolation = sampling(part.cell_type)
    total = np.zeros((len(part.points), 6 * k), fields.dtype)
    weight = np.zeros(len(part.points))
    free = None if growth is None else thermal_strain(part, growth)
    values, _ = shape_functions(part.cell_type, points)
    for cells, strains, determinant in strain_blocks(part, fields, points):
        e, g = determinant.shape
        if free is not None:
            strains[:, :, :3] -= (free[cells] @ values.T)[:, :, None, None]
        nodal = extrapolation @ strains.reshape(e, g, 6 * k)
        nodes, place = np.unique(cells, return_inverse=True)
        volume = np.repeat(determinant.mean(axis=1), cells.shape[1])
        gather = sp.csr_array(
            (volume, (place.ravel(), np.arange(cells.size))), shape=(len(nodes), cells.size)
        )
        total[nodes] += gather @ nodal.reshape(cells.size, 6 * k)
        weight[nodes] += gather.sum(axis=1)
    return total.reshape(len(total), 6, *u.shape[2:]), weight


def strain_energy(model: Model, u: Array) -> Array:
    """Half the integral of stress times conjugate strain over the part, J: () or (k,).

    Integrated at the points at which the stiffness is, so that it equals ½ uᴴ K u to round-off.

    Raises
    ------
    InputError
        If the field does not belong to the part.
    """
    fields = columns(model.part, u)
    reference = reference_element(model.part.cell_type)
    energy = np.zeros(fields.shape[2])
    for _, strains, determinant in strain_blocks(model.part, fields, reference.points):
        stresses = hooke(model.material, strains, axis=2)
        density = np.einsum("egck,egck->egk", stresses, strains.conj()).real
        energy += 0.5 * np.einsum("eg,egk->k", determinant * reference.weights, density)
    return energy.reshape(u.shape[2:])


def hooke(material: Material, strains: Array, axis: int = 1) -> Array:
    """Stress of strains whose six components lie along `axis`, Pa."""
    lame, shear = material.lame
    if strains.shape[axis : axis + 1 or None] != (6,):
        raise InputError(f"strains: given shape {strains.shape}: needs six along axis {axis}")
    e = np.moveaxis(strains, axis, 0)
    s = shear * e
    s[:3] += shear * e[:3] + lame * e[:3].sum(axis=0)
    return np.moveaxis(s, 0, axis)


def strain_rows(part: Part, nodes: Integers, direction: Floats) -> sp.csr_array:
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


def thermal_strain(part: Part, growth: ArrayLike) -> Floats:
    """(nodes,) thermal strain at the nodes, from that or from one number."""
    return nodal_values(part, growth, "thermal strain")


def nodal_values(part: Part, given: ArrayLike, what: str) -> Floats:
    """(nodes,) values at the nodes of a part, from these or from one number for all of them."""
    values, n = np.asarray(given, float), len(part.points)
    if values.shape not in ((), (n,)):
        raise InputError(f"{part.name}: {what} of shape {values.shape}: needed is one or ({n},)")
    if not np.isfinite(values).all():
        raise InputError(f"{part.name}: {what} must be finite")
    return np.broadcast_to(values, (n,))


def columns(part: Part, u: Array) -> Array:
    """A field as (nodes, 3, k)."""
    if u.ndim not in (2, 3) or u.shape[:2] != (len(part.points), 3):
        raise InputError(
            f"{part.name}: displacement of shape {u.shape}: needed is ({len(part.points)}, 3) or "
            f"({len(part.points)}, 3, k)"
        )
    return u.reshape(len(u), 3, -1)


def slopes(part: Part, cells: Integers, points: Floats) -> tuple[Floats, Floats]:
    """Derivatives (e, g, a, 3) of the basis functions by x, y, z, and the Jacobian's determinant.

    The latter, (e, g), is dV over the reference cell's volume element.
    """
    _, gradients = shape_functions(part.cell_type, points)
    corners = part.points[cells].transpose(0, 2, 1)
    jacobian = corners[:, None] @ gradients  # (e, g, 3, 3): dx_i / dξ_j
    return gradients @ np.linalg.inv(jacobian), np.linalg.det(jacobian)


def strain_blocks(part: Part, u: Array, points: Floats) -> Iterator[tuple[Integers, Array, Floats]]:
    """Cells of a block, strains (e, g, 6, k) at points of the reference cell, determinants."""
    k = u.shape[2]
    size = max(1, ENTRIES // (9 * len(points) * k + 3 * part.cells.shape[1] * (k + len(points))))
    for start in range(0, len(part.cells), size):
        cells = part.cells[start : start + size]
        gradients, determinant = slopes(part, cells, points)
        e, g, a, _ = gradients.shape
        turned = gradients.transpose(0, 1, 3, 2).reshape(e, 3 * g, a)
        # du_i/dx_j as [e, g, j, i, k]
        gradient = (turned @ u[cells].reshape(e, a, 3 * k)).reshape(e, g, 3, 3, k)
        strains = np.empty((e, g, 6, k), gradient.dtype)
        for i in range(3):
            strains[:, :, i] = gradient[:, :, i, i]
            j, m = (i + 1) % 3, (i + 2) % 3
            strains[:, :, 3 + i] = gradient[:, :, j, m] + gradient[:, :, m, j]
        yield cells, strains, determinant
