"""Loads at rest by their resultants: a traction over faces that has a given force and moment.

    t(x) = Σ_k a_k φ_k(x),    ∫ φ_kᵀ φ_l dA a_l = (F, M)_k,

φ the six rigid motions about the centroid of the faces: of all tractions of that force and moment
the one whose square has the least integral.
"""

from collections.abc import Sequence

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.loads.pressure import face_rule
from vanelock.fem.model import Model
from vanelock.mesh import Part
from vanelock.mesh.cells import area_vectors


def traction(
    model: Model,
    faces: Integers,
    force: Sequence[float],
    moment: Sequence[float] = (0.0, 0.0, 0.0),
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
    places, weights, values = face_rule(faces.shape[1])
    area = np.linalg.norm(area_vectors(part.points, faces, places), axis=2) * weights
    return values, area, np.einsum("qa,fai->fqi", values, part.points[faces])
