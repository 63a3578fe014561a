"""Loads at rest: thermal strain, rotation, pressure on faces, tractions of a given resultant.

    f = ∫ Bᵀ D ε_T dV = ∫ (3λ + 2μ) ε_T ∇N dV,    ε_T = α (T - T_ref)
    f = ∫ ρ Ω² r N dV,                            r from the engine axis z

(O. C. Zienkiewicz and R. L. Taylor, The Finite Element Method, vol. 1, 5th ed. 2000, 2.2 and 2.3),
at the points at which stiffness and mass are integrated.

Of a pressure on faces of the surface,

    f = -∫ N p n dA,    n dA = ∂x/∂ξ × ∂x/∂η dξ dη

whose integrand is a polynomial on curved faces, too: the rule integrates it exactly.

A traction over faces that has a given force and moment is

    t(x) = Σ_k a_k φ_k(x),    ∫ φ_kᵀ φ_l dA a_l = (F, M)_k,

φ the six rigid motions about the centroid of the faces: of all tractions of that force and moment
the one whose square has the least integral.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike
from skfem import quadrature, refdom

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.elements import reference_element
from vanelock.fem.model import Model
from vanelock.fem.stresses import nodal_values, slopes
from vanelock.mesh import Part
from vanelock.mesh.cells import area_vectors, exterior, solid, surface

_BLOCK = 4096  # elements at a time: some 20 MB of derivatives


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
    at_nodes = nodal_values(part, growth, "thermal strain")
    lame, shear = model.material.lame
    reference = reference_element(part.cell_type)
    nodal = np.zeros((len(part.points), 3))
    for cells, gradients, determinant in _blocks(part, reference.points):
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
    for cells, _, determinant in _blocks(part, reference.points):
        mass = np.tensordot(determinant * reference.weights, pairs, 1)
        np.add.at(nodal, cells, mass @ (part.points[cells] * [1, 1, 0]))
    return model.free(model.material.rho * speed**2 * nodal)


def _blocks(part: Part, points: Floats) -> Iterator[tuple[Integers, Floats, Floats]]:
    """Elements (e, a) in blocks, with slopes of their functions and determinants; see `slopes`."""
    for start in range(0, len(part.cells), _BLOCK):
        cells = part.cells[start : start + _BLOCK]
        yield cells, *slopes(part, cells, points)


_DEGREE = {3: 2, 4: 5, 6: 6, 8: 9, 9: 9}
"""Of p N n dA on a face with so many nodes, p a field of the face's own functions."""


def pressure(model: Model, node_set: str, value: ArrayLike) -> Floats:
    """Nodal loads of a pressure, which acts against the outward normal.

    Parameters
    ----------
    model : Model
        The part.
    node_set : str
        Name of a node set: the faces of the surface all of whose nodes belong to it are loaded.
    value : float or (nodes,) float
        Pressure, Pa, constant or at each node of the part.

    Returns
    -------
    (n,) float
        On the free degrees of freedom, N.

    Raises
    ------
    InputError
        If there is no such set, no face lies in it, or the pressure does not belong to the part.
    """
    part = model.part
    faces = faces_of(part, node_set)
    at_nodes = nodal_values(part, value, "pressure")
    places, weights, values = _face_rule(faces.shape[1])
    strength = (at_nodes[faces] @ values.T) * weights
    vectors = area_vectors(part.points, faces, places)
    nodal = np.zeros((len(part.points), 3))
    np.add.at(nodal, faces, -np.einsum("fq,qa,fqi->fai", strength, values, vectors))
    return model.free(nodal)


def faces_of(part: Part, node_set: str) -> Integers:
    """(f, m) nodes of the surface's faces that a set covers, outward by the right-hand rule."""
    inside = np.zeros(len(part.points), bool)
    inside[part.nodes(node_set)] = True
    faces = exterior(part.cells, solid(part.cell_type))
    faces = faces[inside[faces].all(axis=1)]
    if not len(faces):
        raise InputError(f"{part.name}: no face of the surface has all its nodes in {node_set!r}")
    return faces


def _face_rule(count: int) -> tuple[Floats, Floats, Floats]:
    """Points (q, 2) on the reference face of m = `count` nodes, weights (q,), functions (q, m)."""
    kind = refdom.RefTri if count in (3, 6) else refdom.RefQuad
    places, weights = quadrature.get_quadrature(kind, _DEGREE[count])
    return places.T, weights, surface(count).functions(places.T)[0]


def traction(
    model: Model, faces: Integers, force: Sequence[float], moment: Sequence[float] = (0.0, 0.0, 0.0)
) -> Floats:
    """Nodal loads of a traction over faces with a force and a moment about their centroid.

    Parameters
    ----------
    model : Model
        The part.
    faces : (f, m) int
        Nodes of faces of its surface.
    force : (3,) float
        N.
    moment : (3,) float
        About the centroid of the faces, N m.

    Returns
    -------
    (n,) float
        On the free degrees of freedom, N.

    Raises
    ------
    InputError
        If there are no faces, or force or moment is not finite.
    """
    wanted = np.concatenate([np.asarray(force, float), np.asarray(moment, float)])
    if not len(faces):
        raise InputError(f"{model.part.name}: traction: no faces are given")
    if wanted.shape != (6,) or not np.isfinite(wanted).all():
        raise InputError(
            f"{model.part.name}: traction: force and moment: three finite numbers each"
        )
    values, area, place = _points(model.part, faces)
    arm = place - np.einsum("fq,fqi->i", area, place) / area.sum()
    rigid = np.zeros((*arm.shape[:2], 6, 3))
    rigid[:, :, :3] = np.eye(3)
    rigid[:, :, 3:] = np.cross(np.eye(3), arm[:, :, None, :])
    gram = np.einsum("fq,fqki,fqli->kl", area, rigid, rigid)
    size = np.sqrt(np.diagonal(gram))
    share = np.linalg.solve(gram / np.outer(size, size), wanted / size) / size
    strength = np.einsum("k,fqki->fqi", share, rigid)
    nodal = np.zeros((len(model.part.points), 3))
    np.add.at(nodal, faces, np.einsum("fq,qa,fqi->fai", area, values, strength))
    return model.free(nodal)


def centroid(model: Model, faces: Integers) -> Floats:
    """(3,) centroid of faces, m."""
    _, area, place = _points(model.part, faces)
    return np.asarray(np.einsum("fq,fqi->i", area, place) / area.sum())


def _points(part: Part, faces: Integers) -> tuple[Floats, Floats, Floats]:
    """Shape functions (q, m), areas (f, q) in m², places (f, q, 3) in m at a rule's points."""
    places, weights, values = _face_rule(faces.shape[1])
    area = np.linalg.norm(area_vectors(part.points, faces, places), axis=2) * weights
    return values, area, np.einsum("qa,fai->fqi", values, part.points[faces])
