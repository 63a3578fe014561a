"""Mesh with linear tetrahedra, again with slightly smaller ones where a sliver remains.

Whether the mesher leaves a sliver somewhere is chance, and some of them cannot be curved. A size a
few per cent smaller leads to another mesh. Where all of these have a bad one, Netgen's optimiser,
which splits elements, too, takes slivers away at a third more unknowns.

Take away elements that lie flat on one curved face of the geometry.

Four nodes of a curved face make a tetrahedron where the mesher's triangles on it leave a dent or a
ridge. Two sides of it belong to the face; once they are curved, nothing is left between them. With
the element away the face has the other diagonal of the four nodes.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.mesh.checks.tetrahedra import condition
from vanelock.mesh.generate.stretch import drawn_out
from vanelock.mesh.geometry.element_size import Local

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


FINER = (1.0, 0.98, 0.96, 0.93, 0.9, 0.86)
"""Sizes to try, relative to the one asked for."""
ENOUGH = 0.05
"""Smallest condition number (SICN) at which no other size is tried."""
BAD = 0.03
"""Smallest condition number that is not worth a third more unknowns."""
# Condition numbers below which the mesher changes an element: at first slivers only, since it
# tries in vain, for minutes, to improve what is flat because the wall is thin.
_SLIVER, _POOR = 0.02, 0.3


def tetrahedra(
    gmsh: Any,
    size: float,
    local: Local | None = None,
    stretch: float = 1.0,
    same_faces: bool = False,
) -> None:
    """Mesh the current model with linear tetrahedra no larger than `size`, m."""
    reached: dict[tuple[float, bool], float] = {}
    for split in (False, True):
        if max(reached.values(), default=-1.0) > BAD:
            break
        for finer in FINER:
            last = finer, split
            try:
                reached[last] = _attempt(gmsh, size, local, stretch, same_faces, *last)
            except Exception:  # all that gmsh raises
                reached[last] = -1.0
            if reached[last] > ENOUGH:
                return
    best = max(reached, key=reached.__getitem__)
    if best != last or reached[best] < 0:
        _attempt(gmsh, size, local, stretch, same_faces, *best)


def _attempt(
    gmsh: Any,
    size: float,
    local: Local | None,
    stretch: float,
    same_faces: bool,
    finer: float,
    split: bool,
) -> float:
    """Mesh anew; the smallest condition number, or 0 if an element lies flat on a face."""
    gmsh.model.mesh.clear()
    gmsh.option.setNumber("Mesh.MeshSizeMax", size if same_faces else finer * size)
    gmsh.model.mesh.removeSizeCallback()
    if local is not None or (same_faces and finer != 1):

        def largest(dim: int, _tag: int, x: float, y: float, z: float, lc: float) -> float:
            here = size if local is None else local(x, y, z)
            return min(lc, here if same_faces and dim < 3 else finer * here)

        gmsh.model.mesh.setSizeCallback(largest)
    gmsh.option.setNumber("Mesh.OptimizeThreshold", _SLIVER)
    gmsh.model.mesh.generate(3)
    # Generation leaves slivers in fine meshes.
    gmsh.option.setNumber("Mesh.OptimizeThreshold", _POOR)
    gmsh.model.mesh.optimize("Relocate3D")
    gmsh.model.mesh.optimize("")
    if split:
        gmsh.model.mesh.optimize("Netgen")
    if level(gmsh):
        return 0.0
    _, corners = gmsh.model.mesh.getElementsByType(_TETRAHEDRON)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    points = drawn_out(np.asarray(coordinates).reshape(-1, 3)[order], stretch)
    cells = np.searchsorted(tags[order], corners).reshape(-1, 4)
    return float(condition(points, cells).min())
