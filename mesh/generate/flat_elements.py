"""Take away elements that lie flat on one curved face of the geometry.

Four nodes of a curved face make a tetrahedron where the mesher's triangles on it leave a dent or a
ridge. Two sides of it belong to the face; once they are curved, nothing is left between them. With
the element away the face has the other diagonal of the four nodes.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_LINE, _TRIANGLE, _TETRAHEDRON = 1, 2, 4  # gmsh's numbers of the linear element types
_SIDES = np.array([(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)])
Side = frozenset[int]

FLAT = 1e-3
"""Condition number (SICN) below which an element has no height."""
TALL = 0.05
"""And above which it stands by itself, as those do that span the columns of a rounded edge."""


def level(gmsh: Any) -> int:
    """Remove such elements from the current model's linear mesh, and count the low that stay.

    Those stay that have some height of their own, that bound another face as well, or where a
    curve, such as a contact band, joins the two nodes that would be parted. The tall ones among
    them are sound and do not count.
    """
    held = {frozenset(pair) for pair in _elements(gmsh, _LINE, 2)[1].tolist()}
    boundary = {frozenset(triangle) for triangle in _elements(gmsh, _TRIANGLE, 3)[1].tolist()}
    left = 0
    for _, face in gmsh.model.getEntities(2):
        if gmsh.model.getType(2, face) != "Plane":
            left += _level_face(gmsh, face, held, boundary)
    return left


def _level_face(gmsh: Any, face: int, held: set[Side], boundary: set[Side]) -> int:
    numbers, corners = _elements(gmsh, _TRIANGLE, 3, face)
    triangles = {frozenset(t): int(n) for t, n in zip(corners.tolist(), numbers, strict=True)}
    tags, cells = _elements(gmsh, _TETRAHEDRON, 4)
    ((_, body),) = gmsh.model.getEntities(3)
    mesh = gmsh.model.mesh
    left = 0
    for index in np.flatnonzero(np.isin(cells, corners).all(axis=1)):
        sides = [frozenset(side) for side in cells[index][_SIDES].tolist()]
        outer = [side for side in sides if side in triangles]
        if len(outer) < 2:
            continue
        edge, across = outer[0] & outer[1], outer[0] ^ outer[1]
        height = float(mesh.getElementQualities([tags[index]], "minSICN")[0])
        joined = any(across <= triangle for triangle in triangles)
        inner = not any(side in boundary for side in sides if side not in outer)
        if len(outer) > 2 or edge in held or joined or not inner or height > FLAT:
            left += height < TALL
            continue
        mesh.removeElements(3, body, [int(tags[index])])
        mesh.removeElements(2, face, [triangles.pop(side) for side in outer])
        first = mesh.getMaxElementTag() + 1
        new = {side: first + k for k, side in enumerate(s for s in sides if s not in outer)}
        nodes = [node for side in new for node in sorted(side)]
        mesh.addElementsByType(face, _TRIANGLE, list(new.values()), nodes)
        triangles.update(new)
        boundary.difference_update(outer)
        boundary.update(new)
    return left


def _elements(
    gmsh: Any, kind: int, count: int, entity: int = -1
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Numbers (e,) and nodes (e, count) of the elements of a type."""
    numbers, nodes = gmsh.model.mesh.getElementsByType(kind, entity)
    return np.asarray(numbers, np.int64), np.asarray(nodes, np.int64).reshape(-1, count)
