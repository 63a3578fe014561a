"""The faces on the outside of a mesh, and the normals of the surface at their nodes."""

import numpy as np
from numpy.typing import NDArray

from vanelock.mesh.cells import Cell, surface

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


def exterior(cells: Integers, reference: Cell) -> Integers:
    """(f, m) nodes of the faces that belong to one element only, outward by the right-hand rule."""
    faces = cells[:, reference.faces].reshape(-1, reference.faces.shape[1])
    corners = 3 if reference.corners == 4 else 4
    key = np.sort(faces[:, :corners], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return np.asarray(faces[np.sort(first[count == 1])])


def area_vectors(points: Array, faces: Integers, places: Array) -> Array:
    """(f, q, 3) outward normals times dA over dξ dη at places (q, 2) of curved faces (f, m), m²."""
    slopes = surface(faces.shape[1]).slopes(places)
    tangents = np.einsum("fkx,qkd->fqdx", points[faces], slopes)
    return np.asarray(np.cross(tangents[:, :, 0], tangents[:, :, 1]))


def normals(points: Array, faces: Integers) -> tuple[Array, Array]:
    """Unit outward normals (f, m, 3) of curved faces at each of their nodes, and areas (f,).

    A normal is zero where the face's sides lie on one line. The areas, of the corners' polygons,
    serve as weights.
    """
    cell = surface(faces.shape[1])
    normal = area_vectors(points, faces, cell.nodes)
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    corners = points[faces[:, : cell.corners]] - points[faces[:, [0]]]
    polygon = np.cross(corners[:, 1:-1], corners[:, 2:]).sum(axis=1)
    unit = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    return unit, 0.5 * np.linalg.norm(polygon, axis=1)
