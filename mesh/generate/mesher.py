"""Mesh with tetrahedra, again with slightly smaller ones where a sliver remains; as arrays.

Whether the mesher leaves a sliver somewhere is chance, and some of them cannot be curved. A size a
few per cent smaller leads to another mesh. Where all of these have a bad one, Netgen's optimiser,
which splits elements, too, takes slivers away at a third more unknowns.

Elements that lie flat on one curved face of the geometry are taken away. Four nodes of a curved
face make a tetrahedron where the mesher's triangles on it leave a dent or a ridge. Two sides of it
belong to the face; once they are curved, nothing is left between them. With the element away the
face has the other diagonal of the four nodes.
"""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.mesh.cells import condition, jacobian_bounds
from vanelock.mesh.element_size import Local, drawn_out
from vanelock.mesh.generate.occ_solids import TOLERANCE

_LINE, _TRIANGLE, _TETRAHEDRON = 1, 2, 4  # gmsh's numbers of the linear element types
_SIDES = np.array([(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)])
_Side = frozenset[int]

_FLAT = 1e-3  # condition number (SICN) below which an element has no height
_TALL = 0.05
"""And above which it stands by itself, as those do that span the columns of a rounded edge."""


def _level(gmsh: Any) -> int:
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


def _level_face(gmsh: Any, face: int, held: set[_Side], boundary: set[_Side]) -> int:
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
        if len(outer) > 2 or edge in held or joined or not inner or height > _FLAT:
            left += height < _TALL
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


def _elements(gmsh: Any, kind: int, count: int, entity: int = -1) -> tuple[Integers, Integers]:
    """Numbers (e,) and nodes (e, count) of the elements of a type."""
    numbers, nodes = gmsh.model.mesh.getElementsByType(kind, entity)
    return np.asarray(numbers, np.int64), np.asarray(nodes, np.int64).reshape(-1, count)


_FINER = (1.0, 0.98, 0.96, 0.93, 0.9, 0.86)  # sizes to try, relative to the one asked for
_ENOUGH = 0.05  # smallest condition number (SICN) at which no other size is tried
_BAD = 0.03  # smallest condition number that is not worth a third more unknowns
# Condition numbers below which the mesher changes an element: at first slivers only, since it
# tries in vain, for minutes, to improve what is flat because the wall is thin.
_SLIVER, _POOR = 0.02, 0.3


def _tetrahedra(
    gmsh: Any,
    size: float,
    local: Local | None = None,
    stretch: float = 1.0,
    same_faces: bool = False,
) -> None:
    """Mesh the current model with linear tetrahedra no larger than `size`, m."""
    attempt = partial(_attempt, gmsh, size, local, stretch, same_faces)
    reached: dict[tuple[float, bool], float] = {}
    for split in (False, True):
        if max(reached.values(), default=-1.0) > _BAD:
            break
        for finer in _FINER:
            last = finer, split
            try:
                reached[last] = attempt(*last)
            except Exception:  # all that gmsh raises
                reached[last] = -1.0
            if reached[last] > _ENOUGH:
                return
    best = max(reached, key=reached.__getitem__)
    if best != last or reached[best] < 0:
        attempt(*best)


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
    if _level(gmsh):
        return 0.0
    _, corners = gmsh.model.mesh.getElementsByType(_TETRAHEDRON)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    points = drawn_out(np.asarray(coordinates).reshape(-1, 3)[order], stretch)
    cells = np.searchsorted(tags[order], corners).reshape(-1, 4)
    return float(condition(points, cells).min())


_TETRA10 = 11  # gmsh's number of the element type
# gmsh and meshio (VTK) number the last two edges of the tetrahedron in opposite order.
_MESHIO_ORDER = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
LEAST_JACOBIAN = 0.1
"""Of a curved element, against the straight one; below, its sides are straightened."""
_RELAXED = (0.8,) * 10 + (0.0,) * 10  # shares of the bow that sides keep, round by round
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]  # corners of nodes 4 to 9, meshio's order


@dataclass(frozen=True)
class MeshArrays:
    """Nodes (n, 3) and tetra10 elements (e, 10), with gmsh's tags of the nodes (n,), ascending.

    And the volume of the geometry, m³.
    """

    points: Floats
    cells: Integers
    tags: Integers
    volume: float

    def number(self, tags: Any) -> Integers:
        """Node numbers of gmsh's node tags."""
        return np.searchsorted(self.tags, np.asarray(tags, dtype=np.int64))


def generate(
    gmsh: Any,
    size: float,
    local: Local | None = None,
    stretch: float = 1.0,
    same_faces: bool = False,
) -> MeshArrays:
    """Mesh the current model with curved quadratic tetrahedra; arguments as of `_tetrahedra`."""
    _tetrahedra(gmsh, size, local, stretch, same_faces)
    gmsh.model.mesh.setOrder(2)
    _, nodes = gmsh.model.mesh.getElementsByType(_TETRA10)
    used, cells = np.unique(np.asarray(nodes, dtype=np.int64), return_inverse=True)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    tags = np.asarray(tags, dtype=np.int64)[order]
    points = np.asarray(coordinates).reshape(-1, 3)[order]
    if not np.array_equal(tags, used):
        raise InputError(
            f"{gmsh.model.getCurrent()}: {len(tags) - len(used)} nodes belong to no tetrahedron"
        )
    volume = sum(gmsh.model.occ.getMass(*solid) for solid in gmsh.model.getEntities(3))
    return MeshArrays(points, cells.reshape(-1, 10)[:, _MESHIO_ORDER], tags, volume)


def nodes_on(gmsh: Any, mesh: MeshArrays, dim: int, tag: int) -> Integers:
    """Nodes of a point, curve or face and of its boundary, ascending."""
    tags, _, _ = gmsh.model.mesh.getNodes(dim, tag, includeBoundary=dim > 0)
    return np.unique(mesh.number(tags))


def matching(
    points: Floats, candidates: Integers, places: Floats, what: str, tolerance: float = TOLERANCE
) -> Integers:
    """The candidates in the order of the places (k, 3) where they must lie, one each.

    Nodes whose place is known in closed form come out of the kernel within its tolerance; one
    further off is the wrong node.
    """
    if len(candidates) != len(places):
        raise InputError(f"{what}: {len(candidates)} nodes, expected {len(places)}")
    distance, nearest = cKDTree(points[candidates]).query(places)
    if distance.max() > tolerance:
        raise InputError(f"{what}: a node lies {distance.max():.2g} m off its place")
    if len(np.unique(nearest)) != len(places):
        raise InputError(f"{what}: two places share a node")
    return np.asarray(candidates[nearest])


def along(points: Floats, candidates: Integers, places: Floats, what: str) -> Integers:
    """Like `matching`, for nodes that the kernel spread over a curve in its own measure."""
    spacing = np.linalg.norm(np.diff(places, axis=0), axis=1).min()
    return matching(points, candidates, places, what, 0.2 * float(spacing))


def nearest(points: Floats, candidates: Integers, places: Floats, what: str) -> Integers:
    """Like `along`, for candidates that are many more than the places (k, 3)."""
    spacing = np.linalg.norm(np.diff(places, axis=0), axis=1).min()
    _, found = cKDTree(points[candidates]).query(places)
    return matching(points, candidates[np.unique(found)], places, what, 0.05 * float(spacing))


def place(
    mesh: MeshArrays,
    nodes: Integers,
    places: Floats,
    images: tuple[Integers, Integers, Floats] | None = None,
) -> Floats:
    """Points (n, 3) with nodes moved to their exact places and no element folded.

    Mid-side nodes lie on the geometry's surfaces. Where that would distort an element, they go
    back towards their chord, as far as needed, those with an exact place apart.
    """
    points = mesh.points.copy()
    points[nodes] = places
    middle = np.full((len(points), 2), -1)
    for k, ends in enumerate(EDGES, start=4):
        middle[mesh.cells[:, k]] = mesh.cells[:, ends]
    free = middle[:, 0] >= 0
    free[nodes] = False
    if images is not None:
        left, right, turn = images
        free[right] = False
    for share in _RELAXED:
        if images is not None:
            points[right] = points[left] @ turn.T
        folded = jacobian_bounds(points, mesh.cells) < LEAST_JACOBIAN
        if not folded.any():
            break
        eased = np.unique(mesh.cells[folded][:, 4:])
        if images is not None:
            eased = np.union1d(eased, left[np.isin(right, eased)])
        eased = eased[free[eased]]
        chords = points[middle[eased]].mean(axis=1)
        points[eased] = chords + share * (points[eased] - chords)
    if images is not None:
        points[right] = points[left] @ turn.T
    return points
