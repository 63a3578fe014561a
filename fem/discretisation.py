"""How much a mesh stiffens a part, found from its displacement fields alone.

Finite elements are too stiff: a mode's ω² exceeds the true one by ∫ ε(e) : C : ε(e) dV, at unit
modal mass, e being the error of its shape, but for smaller terms (G. Strang and G. Fix, An Analysis
of the Finite Element Method, 1973, 6.3). The strain ε(e) is estimated as the difference between a
continuous strain, recovered from the elements' own, and these (O. C. Zienkiewicz and J. Z. Zhu, A
simple error estimator and adaptive procedure for practical engineering analysis, Int. J. Numer.
Meth. Engng 24 (1987) 337-357).
"""

from collections.abc import Iterator

import numpy as np

from vanelock.common.arrays import Array, Floats
from vanelock.fem.elements.reference import reference_element
from vanelock.fem.model import Model
from vanelock.fem.stresses.patch_strains import patch_strain
from vanelock.fem.stresses.strains import columns, hooke, strain_blocks


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
    smooth = patch_strain(model.part, fields)
    done = 0
    for cells, strains, determinant in strain_blocks(model.part, fields, reference.points):
        block = slice(done, done + len(cells))
        done = block.stop
        error = smooth.at(block, reference.points).reshape(strains.shape) - strains
        weighted = hooke(model.material, error, axis=2)
        weighted *= (determinant * reference.weights)[:, :, None, None]
        yield error, weighted
