"""Areas that belong to the nodes of contact faces, for stiffnesses per area."""

import numpy as np
from numpy.typing import NDArray

from vanelock.mesh.cells import surface
from vanelock.mesh.exterior import area_vectors

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

ALIKE = np.cos(np.radians(45.0))  # a face and the contact at its nodes


def nodal_areas(points: Array, faces: Integers, nodes: Integers, normal: Array) -> Array | None:
    """Area of each node of a set of contact nodes, m².

    The faces whose corners all belong to the set, and which look along the normals there, share
    their area among their nodes in the ratio of ∫ N_i², which is positive even where ∫ N_i is not
    (E. Hinton, T. Rock, O. C. Zienkiewicz, A note on mass lumping and related processes in the
    finite element method, Earthquake Engng Struct. Dyn. 4 (1976) 245-249).
    """
    cell = surface(faces.shape[1])
    whole = faces[np.isin(faces[:, : cell.corners], nodes).all(axis=1)]
    if not len(whole):
        return None
    place, weight = _quadrature(cell.corners)
    vectors = area_vectors(points, whole, place)
    order = np.argsort(nodes)
    first = order[np.searchsorted(nodes, whole[:, 0], sorter=order)]
    mean = np.einsum("q,fqx->fx", weight, vectors)
    along = np.sum(mean * normal[first], axis=1) > ALIKE * np.linalg.norm(mean, axis=1)
    area = np.linalg.norm(vectors, axis=2)[along] @ weight
    share = weight @ cell.values(place) ** 2
    found = np.zeros(len(points))
    np.add.at(found, whole[along], area[:, None] * share / share.sum())
    return found[nodes] if (found[nodes] > 0).all() else None


def _quadrature(corners: int) -> tuple[Array, Array]:
    """Gauss points (q, 2) and weights (q,) of the square, or folded onto the triangle."""
    x, w = np.polynomial.legendre.leggauss(4)
    u, v = (grid.ravel() for grid in np.meshgrid(0.5 * (x + 1), 0.5 * (x + 1), indexing="ij"))
    weight = np.outer(w, w).ravel() / 4
    if corners == 4:
        return np.column_stack([u, v]), weight
    return np.column_stack([u, v * (1 - u)]), weight * (1 - u)
