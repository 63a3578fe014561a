"""Strain and stress of a displacement field: in each element, at the nodes, over a period.

A strain is the vector (ε_xx, ε_yy, ε_zz, γ_yz, γ_zx, γ_xy), with engineering shears γ = 2ε (Voigt).

At the nodes: the strains at each element's sampling points are extrapolated to its nodes, and a
node takes the mean of its elements, weighted by their volumes. Against projection onto the basis
functions this is no worse on regular meshes and better on distorted ones, and needs no solution.

A stress is the vector (σ_xx, σ_yy, σ_zz, τ_yz, τ_zx, τ_xy). Harmonic h of a periodic one is its
complex coefficient σ_h in σ(t) = σ_0 + Re Σ σ_h e^{ihωt}.
"""

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.elements import sampling
from vanelock.fem.model import Material, Model
from vanelock.mesh import Part
from vanelock.mesh.cells import solid

_ENTRIES = 2**20  # displacement gradients held at a time; some tens of MB with what is made of them


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
    free = None if growth is None else nodal_values(part, growth, "thermal strain")
    values, _ = solid(part.cell_type).functions(points)
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


def hooke(material: Material, strains: Array, axis: int = 1) -> Array:
    """Stress of strains whose six components lie along `axis`, Pa."""
    lame, shear = material.lame
    if strains.shape[axis : axis + 1 or None] != (6,):
        raise InputError(f"strains: given shape {strains.shape}: needs six along axis {axis}")
    e = np.moveaxis(strains, axis, 0)
    s = shear * e
    s[:3] += shear * e[:3] + lame * e[:3].sum(axis=0)
    return np.moveaxis(s, 0, axis)


def nodal_values(part: Part, field: ArrayLike, what: str) -> Floats:
    """(nodes,) values at the nodes of a part, from these or from one number for all of them."""
    values, n = np.asarray(field, float), len(part.points)
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
    _, gradients = solid(part.cell_type).functions(points)
    corners = part.points[cells].transpose(0, 2, 1)
    jacobian = corners[:, None] @ gradients  # (e, g, 3, 3): dx_i / dξ_j
    return gradients @ np.linalg.inv(jacobian), np.linalg.det(jacobian)


def strain_blocks(part: Part, u: Array, points: Floats) -> Iterator[tuple[Integers, Array, Floats]]:
    """Cells of a block, strains (e, g, 6, k) at points of the reference cell, determinants."""
    k = u.shape[2]
    size = max(1, _ENTRIES // (9 * len(points) * k + 3 * part.cells.shape[1] * (k + len(points))))
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


_NODES = 4096  # nodes whose period is looked at together

_DEVIATOR = np.sqrt(np.array([[0.75], [0.25], [3.0], [3.0], [3.0]])) * [
    [1, -1, 0, 0, 0, 0],
    [1, 1, -2, 0, 0, 0],
    [0, 0, 0, 1, 0, 0],
    [0, 0, 0, 0, 1, 0],
    [0, 0, 0, 0, 0, 1],
]  # five numbers of a stress, whose Euclidean norm is its von Mises stress

_PLACES = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])  # of the components in a 3 x 3 tensor


def stress(model: Model, u: Array, growth: ArrayLike | None = None) -> Array:
    """Stress at the nodes, (nodes, 6) or (nodes, 6, k), Pa, of displacement fields; see `strain`.

    Parameters
    ----------
    model : Model
        Part and material.
    u : (nodes, 3) or (nodes, 3, k), real or complex
        Displacement fields, m.
    growth : float or (nodes,) float, optional
        Thermal strain α (T - T_ref) of the fields: σ = D (ε - α (T - T_ref)).

    Raises
    ------
    InputError
        If the field does not belong to the part.
    """
    return hooke(model.material, strain(model.part, u, growth))


def von_mises(s: Floats) -> Floats:
    """Von Mises stress of real stresses whose second axis holds the components.

    Examples
    --------
    >>> import numpy as np
    >>> von_mises(np.array([[3.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1.0]])).round(4).tolist()
    [3.0, 1.7321]
    """
    return np.asarray(np.linalg.norm(np.tensordot(_DEVIATOR, s, (1, 1)), axis=0))


def peak_von_mises(harmonics: Complex) -> Floats:
    """Largest von Mises stress over a period at each node, Pa.

    Parameters
    ----------
    harmonics : (H+1, nodes, 6) complex
        Coefficients of harmonics 0, the mean, to H.

    Returns
    -------
    (nodes,) float
        Its square is a trigonometric polynomial of degree 2H; every maximum of its samples is
        followed to the maximum of the polynomial.
    """
    nodes = harmonics.shape[1]
    peaks = np.empty(nodes)
    for start in range(0, nodes, _NODES):
        block = slice(start, start + _NODES)
        peaks[block] = _peaks(harmonics[:, block])
    return peaks


def deviators(harmonics: Complex, count: int) -> Floats:
    """Five numbers of a periodic stress, whose Euclidean norm is its von Mises stress, Pa.

    Parameters
    ----------
    harmonics : (H+1, nodes, 6) complex
        Coefficients of harmonics 0, the mean, to H.
    count : int
        Instants of the period, evenly spread, at least 2H + 1.

    Returns
    -------
    (count, nodes, 5) float
        Linear in the stress, so that differences are those of stresses.
    """
    halves = harmonics @ _DEVIATOR.T / 2
    halves[0] = 2 * halves[0].real
    return np.asarray(np.fft.irfft(halves, count, axis=0, norm="forward"))


def turned(s: Array, rotation: Floats, shear: float = 1.0) -> Array:
    """Components of tensors (..., 6, ...) along axis 1 after a rotation of the body.

    Parameters
    ----------
    s : (nodes, 6) or (nodes, 6, k)
        Stresses, or strains with `shear` = 2.
    rotation : (3, 3) float
    shear : float
        What the off-diagonal components are multiplied by in the vector.
    """
    factor = np.array([1, 1, 1, shear, shear, shear])
    factor = factor.reshape(6, *(1,) * (s.ndim - 2))
    tensor = (s / factor)[:, _PLACES]
    new = np.einsum("ia,nab...,jb->nij...", rotation, tensor, rotation)
    first, second = [0, 1, 2, 1, 2, 0], [0, 1, 2, 2, 0, 1]
    return np.asarray(new[:, first, second] * factor)


def _peaks(harmonics: Complex) -> Floats:
    degree = len(harmonics) - 1
    count = 16 * degree + 1
    step = 2 * np.pi / count
    samples = np.sum(deviators(harmonics, count) ** 2, axis=2)
    best = samples.max(axis=0)
    rise = (samples >= np.roll(samples, 1, axis=0)) & (samples >= np.roll(samples, -1, axis=0))
    at, node = np.nonzero(rise)
    order = np.arange(2 * degree + 1)
    polynomial = np.fft.rfft(samples, axis=0)[: len(order)] / count
    polynomial[1:] *= 2
    c = polynomial[:, node]
    angle = at * step
    for _ in range(6):  # Newton's method, no further than the neighbouring samples
        wave = c * np.exp(1j * order[:, None] * angle)
        slope = -(order @ wave.imag)
        bend = -(order**2 @ wave.real)
        move = np.divide(-slope, bend, out=np.zeros_like(slope), where=bend < 0)
        angle = np.clip(angle + move, (at - 1) * step, (at + 1) * step)
    refined = np.sum((c * np.exp(1j * order[:, None] * angle)).real, axis=0)
    np.maximum.at(best, node, refined)
    return np.asarray(np.sqrt(best.clip(0)))
