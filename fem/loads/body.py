"""Loads at rest that act in the volume: thermal strain and rotation.

    f = ∫ Bᵀ D ε_T dV = ∫ (3λ + 2μ) ε_T ∇N dV,    ε_T = α (T - T_ref)
    f = ∫ ρ Ω² r N dV,                            r from the engine axis z

(O. C. Zienkiewicz and R. L. Taylor, The Finite Element Method, vol. 1, 5th ed. 2000, 2.2 and 2.3),
at the points at which stiffness and mass are integrated.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.elements.reference import ReferenceElement, reference_element
from vanelock.fem.model import Model
from vanelock.fem.stresses.strains import slopes, thermal_strain
from vanelock.mesh import Part

BLOCK = 4096
"""Elements at a time: some 20 MB of derivatives."""


def thermal(model: Model, growth: ArrayLike) -> Floats:
    """Nodal loads of a thermal strain.

    Parameters
    ----------
    model : Model
        Part and material.
    growth : float or (nodes,) float
        Thermal strain α (T - T_ref), the same everywhere or at each node.

    Returns
    -------
    (n,) float
        On the free degrees of freedom, N. The displacement that they cause is that of the heated
        part; its stress is `fem.stress(model, u, growth)`.

    Raises
    ------
    InputError
        If the strain does not belong to the part or is not finite.

    Examples
    --------
    A free body grows and has no stress:

    >>> import numpy as np
    >>> from vanelock import fem
    >>> from vanelock.mesh import Part
    >>> corner = np.vstack([np.zeros(3), np.eye(3)])
    >>> part = Part("tetrahedron", corner, np.arange(4)[None], "tetra", {}, {}, 1)
    >>> model = fem.assemble(part, fem.Material(E=210e9, nu=0.3, rho=6000.0))
    >>> grown = 1e-3 * model.part.points.ravel()
    >>> bool(np.allclose(model.K @ grown, fem.thermal(model, 1e-3), atol=1e-3))
    True
    """
    part = model.part
    at_nodes = thermal_strain(part, growth)
    lame, shear = model.material.lame
    reference = reference_element(part.cell_type)
    nodal = np.zeros((len(part.points), 3))
    for cells, gradients, determinant in _blocks(part, reference):
        stress = (3 * lame + 2 * shear) * (at_nodes[cells] @ reference.values.T)
        weights = stress * determinant * reference.weights
        np.add.at(nodal, cells, np.einsum("eg,egai->eai", weights, gradients))
    return model.free(nodal)


def centrifugal(model: Model, speed: float) -> Floats:
    """Nodal loads of rotation about the engine axis z.

    Parameters
    ----------
    model : Model
        Part and material.
    speed : float
        Ω, rad/s.

    Returns
    -------
    (n,) float
        On the free degrees of freedom, N. The stiffness stays that of the part at rest.

    Raises
    ------
    InputError
        If the speed is not finite.
    """
    if not math.isfinite(speed):
        raise InputError(f"speed = {speed:g} rad/s: must be finite")
    part = model.part
    reference = reference_element(part.cell_type)
    pairs = np.einsum("ga,gb->gab", reference.values, reference.values)
    nodal = np.zeros((len(part.points), 3))
    for cells, _, determinant in _blocks(part, reference):
        mass = np.tensordot(determinant * reference.weights, pairs, 1)
        np.add.at(nodal, cells, mass @ (part.points[cells] * [1, 1, 0]))
    return model.free(model.material.rho * speed**2 * nodal)


def _blocks(part: Part, reference: ReferenceElement) -> Iterator[tuple[Integers, Floats, Floats]]:
    """Elements (e, a) in blocks, with slopes of their functions and determinants; see `slopes`."""
    for start in range(0, len(part.cells), BLOCK):
        cells = part.cells[start : start + BLOCK]
        yield cells, *slopes(part, cells, reference.points)
