"""Another estimate of a mesh's error: the residual of a mode, answered by cubic bubbles.

Cubic functions of the edges and faces of quadratic tetrahedra, which vanish at all nodes, are added
to the mesh. Each bubble's three components answer the residual (ω² M - K) u by themselves, all
others held: Σ rᵀ K⁻¹ r over the bubbles estimates what the mesh adds to uᵀ K u (P. Deuflhard, P.
Leinen and H. Yserentant, Concepts of an adaptive hierarchical finite element code, IMPACT Comput.
Sci. Engng 1 (1989) 3-35).
"""

import numpy as np
from numpy.typing import NDArray

from vanelock import fem
from vanelock.fem.elements import reference_element

Floats = NDArray[np.float64]

EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
FACES = np.array([(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)])
FREE = ("fixed", "left", "right")  # no bubbles there
BLOCK = 512


def bubbles(points: Floats) -> tuple[Floats, Floats]:
    """Values (q, 10) and slopes (q, 10, 3) of the bubbles of edges and faces, reference cell."""
    L = np.column_stack([1 - points.sum(axis=1), points])
    G = np.vstack([-np.ones(3), np.eye(3)])
    values, slopes = [], []
    for a, b in EDGES:
        x, y = L[:, a, None], L[:, b, None]
        values.append(x * y * (x - y))
        slopes.append((2 * x * y - y**2) * G[a] + (x**2 - 2 * x * y) * G[b])
    for a, b, c in FACES:
        x, y, z = L[:, a, None], L[:, b, None], L[:, c, None]
        values.append(x * y * z)
        slopes.append(y * z * G[a] + x * z * G[b] + x * y * G[c])
    return np.concatenate(values, axis=1), np.stack(slopes, axis=1)


def bubble_excess(model: fem.Model, u: NDArray[np.complex128], squared: Floats) -> Floats:
    """What the mesh adds to uᴴ K u of modes (nodes, 3, k) of squared frequencies (k,)."""
    part, reference = model.part, reference_element("tetra10")
    values, slopes = bubbles(reference.points)
    number, kept, sign = _numbers(part)
    k, (lame, shear) = u.shape[2], model.material.lame
    residual = np.zeros((len(kept), 3, k), u.dtype)
    diagonal = np.zeros((len(kept), 3, 3))
    for start in range(0, len(number), BLOCK):
        block = slice(start, start + BLOCK)
        cells, here, turned = part.cells[block], number[block], sign[block]
        jacobian = part.points[cells].transpose(0, 2, 1)[:, None] @ reference.gradients
        inverse = np.linalg.inv(jacobian)
        weight = np.linalg.det(jacobian) * reference.weights
        nodal, own = reference.gradients @ inverse, slopes @ inverse * turned[:, None, :, None]
        gradient = np.einsum("egaj,eaik->egijk", nodal, u[cells], optimize=True)
        stress = shear * (gradient + gradient.transpose(0, 1, 3, 2, 4))
        pressure = lame * np.einsum("egiik->egk", gradient)
        for i in range(3):
            stress[:, :, i, i] += pressure
        load = -np.einsum("eg,egbj,egijk->ebik", weight, own, stress, optimize=True)
        moved = np.einsum("ga,eaik->egik", reference.values, u[cells], optimize=True)
        inertia = np.einsum("eg,gb,egik->ebik", weight, values, moved, optimize=True)
        load += model.material.rho * squared * turned[:, :, None, None] * inertia
        np.add.at(residual, here, load)
        product = np.einsum("eg,egbi,egbj->ebij", weight, own, own, optimize=True)
        stiffness = lame * product + shear * product.transpose(0, 1, 3, 2)
        stiffness += shear * np.einsum("ebkk->eb", product)[:, :, None, None] * np.eye(3)
        np.add.at(diagonal, here, stiffness)
    r = residual[kept]
    return np.einsum("nik,nik->k", r.conj(), np.linalg.solve(diagonal[kept], r)).real


def _numbers(part):
    """Bubble of each element's edges and faces (e, 10), which are free, and signs of the edges'."""
    corners = part.cells[:, :4]
    edges, faces = np.sort(corners[:, EDGES], axis=2), np.sort(corners[:, FACES], axis=2)
    edge, of_edge = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    face, of_face = np.unique(faces.reshape(-1, 3), axis=0, return_inverse=True)
    number = np.hstack([of_edge.reshape(-1, 6), len(edge) + of_face.reshape(-1, 4)])
    kept = np.ones(len(edge) + len(face), bool)
    for name in FREE:
        if name in part.node_sets:
            on = np.zeros(len(part.points), bool)
            on[part.node_sets[name]] = True
            kept &= ~np.concatenate([on[edge].all(axis=1), on[face].all(axis=1)])
    upwards = corners[:, EDGES[:, 0]] < corners[:, EDGES[:, 1]]
    sign = np.hstack([np.where(upwards, 1.0, -1.0), np.ones((len(corners), 4))])
    return number, kept, sign
