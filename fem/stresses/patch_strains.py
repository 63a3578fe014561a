"""A continuous strain field, recovered from a displacement field patch by patch.

About every corner of an element a polynomial of the displacements' own degree, component by
component, is fitted to the strains at the best points of the elements that meet there (O. C.
Zienkiewicz and J. Z. Zhu, The superconvergent patch recovery and a posteriori error estimates, Int.
J. Numer. Meth. Engng 33 (1992) 1331-1364). Inside an element the polynomials of its corners are
blended by the linear basis functions of these.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Array, Floats, Integers
from vanelock.fem.elements.reference import (
    linear_type,
    reference_element,
    sampling,
    shape_functions,
)
from vanelock.fem.stresses.strains import strain_blocks
from vanelock.mesh import Part

FEWEST = {"tetra": 5, "hexahedron": 2}
"""Elements about a corner, or else those about them join the patch."""
CONDITION = 1e-4
"""Of the normal equations: what is smaller is left to the smallest coefficients."""
FLAT = 1e-4
"""Least thickness of a patch, over its length."""


@dataclass(frozen=True)
class PatchStrain:
    """Polynomials about the corners of a part's elements.

    Attributes
    ----------
    part : Part
        The mesh.
    corners : (e, c) int
        Rows of the elements' corners in what follows.
    places : (n, 3) float
        Middle of each corner's patch, m.
    axes : (n, 3, 3) float
        Local coordinates about each: (x - place) @ axes, of the patch's own shape and size.
    coefficients : (n, q, 6 k)
        Of each polynomial, strain components and fields.
    """

    part: Part
    corners: Integers
    places: Floats
    axes: Floats
    coefficients: Array

    def at(self, elements: slice, points: Floats) -> Array:
        """Strain (e, g, 6 k) in some elements at points (g, 3) of the reference cell."""
        values, _ = shape_functions(self.part.cell_type, points)
        share, _ = shape_functions(linear_type(self.part.cell_type), points)  # (g, c)
        corners = self.corners[elements]
        x = values @ self.part.points[self.part.cells[elements]]  # (e, g, 3)
        off = x[:, None] - self.places[corners][:, :, None]  # (e, c, g, 3)
        off = (off @ self.axes[corners]).transpose(0, 2, 1, 3)
        terms = _terms(off, self.coefficients.shape[1]) * share[:, :, None]  # (e, g, c, q)
        weights = terms.reshape(*terms.shape[:2], -1)
        return weights @ self.coefficients[corners].reshape(len(corners), weights.shape[2], -1)


def patch_strain(part: Part, u: Array) -> PatchStrain:
    """Fit the strains of displacement fields."""
    points, _ = sampling(part.cell_type)
    values, _ = shape_functions(part.cell_type, points)
    linear = linear_type(part.cell_type)
    count = len(reference_element(linear).nodes)
    used, corners = np.unique(part.cells[:, :count], return_inverse=True)
    corners = corners.reshape(-1, count)
    patches = _patches(corners, len(used), FEWEST[linear])
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
    inverse = np.linalg.pinv(normal, rcond=CONDITION, hermitian=True)
    coefficients = inverse @ (right - normal[:, :, :1] * constant)
    coefficients[:, :1] += constant
    return PatchStrain(part, corners, places, axes, coefficients)


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
    squared = np.maximum(squared, FLAT**2 * squared[:, -1:] + np.finfo(float).tiny)
    return np.asarray(directions / np.sqrt(squared)[:, None])


def _terms(x: Floats, count: int) -> Floats:
    """Terms (..., count) of a linear or quadratic polynomial at places (..., 3)."""
    found = np.empty((*x.shape[:-1], count))
    found[..., 0], found[..., 1:4] = 1, x
    if count > 4:
        found[..., 4:7] = x**2
        found[..., 7:] = x * np.roll(x, 1, axis=-1)
    return found
