"""Loads at rest of pressure on faces of the surface.

    f = -∫ N p n dA,    n dA = ∂x/∂ξ × ∂x/∂η dξ dη

whose integrand is a polynomial on curved faces, too: the rule integrates it exactly.
"""

import numpy as np
from numpy.typing import ArrayLike
from skfem import quadrature, refdom

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.model import Model
from vanelock.fem.stresses.strains import nodal_values
from vanelock.mesh import Part
from vanelock.mesh.cells import area_vectors, exterior, solid, surface

DEGREE = {3: 2, 4: 5, 6: 6, 8: 9, 9: 9}
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
    places, weights, values = face_rule(faces.shape[1])
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


def face_rule(count: int) -> tuple[Floats, Floats, Floats]:
    """Points (q, 2) on the reference face of m = `count` nodes, weights (q,), functions (q, m)."""
    kind = refdom.RefTri if count in (3, 6) else refdom.RefQuad
    places, weights = quadrature.get_quadrature(kind, DEGREE[count])
    return places.T, weights, surface(count).values(places.T)
