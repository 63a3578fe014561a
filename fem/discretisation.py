"""How much a mesh stiffens a part, found from its displacement fields alone.

Finite elements are too stiff: a mode's ω² exceeds the true one by ∫ ε(e) : C : ε(e) dV, at unit
modal mass, e being the error of its shape, but for smaller terms (G. Strang and G. Fix, An Analysis
of the Finite Element Method, 1973, 6.3). The strain ε(e) is estimated as the difference between a
continuous strain, recovered from the elements' own, and these (O. C. Zienkiewicz and J. Z. Zhu, A
simple error estimator and adaptive procedure for practical engineering analysis, Int. J. Numer.
Meth. Engng 24 (1987) 337-357).

The continuous strain is recovered patch by patch. About every corner of an element a polynomial of
the displacements' own degree, component by component, is fitted to the strains at the best points
of the elements that meet there (O. C. Zienkiewicz and J. Z. Zhu, The superconvergent patch recovery
and a posteriori error estimates, Int. J. Numer. Meth. Engng 33 (1992) 1331-1364). Inside an element
the polynomials of its corners are blended by the linear basis functions of these.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.fem.elements import reference_element, sampling
from vanelock.fem.model import Model
from vanelock.fem.stresses import columns, hooke, strain_blocks
from vanelock.mesh import Part
from vanelock.mesh.cells import linear_type, solid


def excess_stiffness(model: Model, u: Array) -> Array:
    """Estimate by how much the mesh makes uᴴ K u larger than it would be without a mesh.

    Divided by the modal mass, and summed over the parts of a structure, this is what a mode's ω² is
    too high by; its frequency is by half as much: Δf / f = Σ Δ / (2 ω² m).

    Parameters
    ----------
    model : Model
        Part and material.
    u : (nodes, 3) or (nodes, 3, k), real or complex
        Displacement fields, m: modes, or what they are combined from. Those of a joined or reduced
        structure are taken as expanded to all nodes of the part.

    Returns
    -------
    () or (k, k)
        Hermitian and positive semi-definite, J: entry ij is ∫ ε(e_i)* : C : ε(e_j) dV, e_i the
        error of field i. The diagonal is twice the strain energy of the errors.

    Raises
    ------
    InputError
        If the field does not belong to the part.

    Notes
    -----
    Curved quadratic tetrahedra, measured against the true error: 0.75 to 0.92 of it on average over
    ten modes of either part of a study at any size with a name, single ones 0.6 to 1.3, and below
    where a coarse mesh has the modes in another order; 0.9 to 1.4 where the exact frequencies are
    known, with or without a singular edge; up to 2.5 in a bar of one element's width
    (docs/benchmarks/mesh_error.md, docs/verification/discretisation.md). Quadratic hexahedra: 1.5
    to 13, on the safe side.

    On the cyclic faces of a sector the strain is that of the sector's own elements; to count its
    neighbour's as well changes a study's by less than 1%. A mesh cannot resolve what is
    lost of the geometry between its nodes, nor that displacements under point forces, as of
    contacts that act on single nodes, grow without bound as elements shrink.
    """
    fields = columns(model.part, u)
    k = fields.shape[2]
    total = np.zeros((k, k), fields.dtype)
    for error, weighted in _errors(model, fields):
        total += error.reshape(-1, k).conj().T @ weighted.reshape(-1, k)
    total = (total + total.conj().T) / 2
    return total if u.ndim == 3 else total[0, 0]


def excess_by_element(model: Model, u: Array) -> Floats:
    """(e,) what each element adds to `excess_stiffness` of one field (nodes, 3), J."""
    found = [
        np.einsum("egck,egck->e", error.conj(), weighted).real
        for error, weighted in _errors(model, columns(model.part, u))
    ]
    return np.concatenate(found)


def _errors(model: Model, fields: Array) -> Iterator[tuple[Array, Array]]:
    """Errors of strain (e, g, 6, k) of a block of elements, and their stresses times volume."""
    reference = reference_element(model.part.cell_type)
    smooth = _patch_strain(model.part, fields)
    done = 0
    for cells, strains, determinant in strain_blocks(model.part, fields, reference.points):
        block = slice(done, done + len(cells))
        done = block.stop
        error = smooth.at(block, reference.points).reshape(strains.shape) - strains
        weighted = hooke(model.material, error, axis=2)
        weighted *= (determinant * reference.weights)[:, :, None, None]
        yield error, weighted


_FEWEST = {"tetra": 5, "hexahedron": 2}
"""Elements about a corner, or else those about them join the patch."""
_CONDITION = 1e-4  # of the normal equations: what is smaller is left to the smallest coefficients
_FLAT = 1e-4  # least thickness of a patch, over its length


@dataclass(frozen=True)
class _PatchStrain:
    """Polynomials about the corners of a part's elements."""

    part: Part  # the mesh
    corners: Integers  # (e, c), rows of the elements' corners in what follows
    places: Floats  # (n, 3), middle of each corner's patch, m
    axes: Floats  # (n, 3, 3)
    coefficients: Array  # (n, q, 6 k), of each polynomial, strain components and fields

    def at(self, elements: slice, points: Floats) -> Array:
        """Strain (e, g, 6 k) in some elements at points (g, 3) of the reference cell."""
        values, _ = solid(self.part.cell_type).functions(points)
        share, _ = solid(linear_type(self.part.cell_type)).functions(points)  # (g, c)
        corners = self.corners[elements]
        x = values @ self.part.points[self.part.cells[elements]]  # (e, g, 3)
        off = x[:, None] - self.places[corners][:, :, None]  # (e, c, g, 3)
        off = (off @ self.axes[corners]).transpose(0, 2, 1, 3)
        terms = _terms(off, self.coefficients.shape[1]) * share[:, :, None]  # (e, g, c, q)
        weights = terms.reshape(*terms.shape[:2], -1)
        return weights @ self.coefficients[corners].reshape(len(corners), weights.shape[2], -1)


def _patch_strain(part: Part, u: Array) -> _PatchStrain:
    """Fit the strains of displacement fields."""
    points, _ = sampling(part.cell_type)
    values, _ = solid(part.cell_type).functions(points)
    linear = linear_type(part.cell_type)
    count = solid(linear).corners
    used, corners = np.unique(part.cells[:, :count], return_inverse=True)
    corners = corners.reshape(-1, count)
    patches = _patches(corners, len(used), _FEWEST[linear])
    element = patches.indices
    corner = np.repeat(np.arange(len(used)), np.diff(patches.indptr))
    x = (values @ part.points[part.cells])[element]  # (p, g, 3), elements of one patch in a row

    def mean(of: Floats) -> Floats:
        """Mean over the points of each patch, of sums over an element's points."""
        count = np.diff(patches.indptr) * len(points)
        return np.asarray(np.add.reduceat(of, patches.indptr[:-1]) / count[:, None, None])

    places = mean(x.sum(axis=1, keepdims=True))[:, 0]
    off = x - places[corner][:, None]
    axes = _axes(mean(off.transpose(0, 2, 1) @ off))
    terms = _terms(off @ axes[corner], 4 if part.cell_type == linear else 10)
    normal = mean(terms.transpose(0, 2, 1) @ terms)
    strains = np.concatenate(
        [s.reshape(-1, 6 * u.shape[2]) for _, s, _ in strain_blocks(part, u, points)]
    )
    share = 1 / (np.diff(patches.indptr) * len(points))
    moments = sp.bsr_array(
        (terms.transpose(0, 2, 1) * share[corner, None, None], element, patches.indptr),
        shape=(len(used) * terms.shape[2], len(strains)),
    )
    right = (moments @ strains).reshape(*normal.shape[:2], -1)
    # Constants first, so that a patch of too few elements for the rest has at least these.
    constant = right[:, :1].copy()
    inverse = np.linalg.pinv(normal, rcond=_CONDITION, hermitian=True)
    coefficients = inverse @ (right - normal[:, :, :1] * constant)
    coefficients[:, :1] += constant
    return _PatchStrain(part, corners, places, axes, coefficients)


def _patches(corners: Integers, count: int, fewest: int) -> sp.csr_array:
    """Elements of each corner's patch, as the pattern of a matrix (corners, elements)."""
    cells = len(corners)
    touch = sp.csr_array(
        (np.ones(corners.size), (corners.ravel(), np.repeat(np.arange(cells), corners.shape[1]))),
        shape=(count, cells),
    )
    few = np.diff(touch.indptr) < fewest
    if few.any():
        wider = touch[few] @ touch.T @ touch
        touch = sp.csr_array(sp.vstack([touch[~few], wider]))
        order = np.concatenate([np.flatnonzero(~few), np.flatnonzero(few)])
        touch = touch[np.argsort(order)]
    return touch


def _axes(moments: Floats) -> Floats:
    """Principal axes (n, 3, 3), in columns, over the root mean squares along them, of moments."""
    squared, directions = np.linalg.eigh(moments)
    squared = np.maximum(squared, _FLAT**2 * squared[:, -1:] + np.finfo(float).tiny)
    return np.asarray(directions / np.sqrt(squared)[:, None])


def _terms(x: Floats, count: int) -> Floats:
    """Terms (..., count) of a linear or quadratic polynomial at places (..., 3)."""
    found = np.empty((*x.shape[:-1], count))
    found[..., 0], found[..., 1:4] = 1, x
    if count > 4:
        found[..., 4:7] = x**2
        found[..., 7:] = x * np.roll(x, 1, axis=-1)
    return found
