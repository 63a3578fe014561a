"""From gmsh's mesh to arrays: nodes, elements, and the nodes on curves, faces and points."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vanelock.common.errors import InputError
from vanelock.mesh.checks.tetrahedra import jacobian_bounds
from vanelock.mesh.generate.mesher import tetrahedra
from vanelock.mesh.generate.occ_solids import TOLERANCE
from vanelock.mesh.geometry.element_size import Local

TETRA10 = 11  # gmsh's number of the element type
# gmsh and meshio (VTK) number the last two edges of the tetrahedron in opposite order.
_MESHIO_ORDER = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
LEAST_JACOBIAN = 0.1
"""Of a curved element, against the straight one; below, its sides are straightened."""
RELAXED = (0.8,) * 10 + (0.0,) * 10
"""Shares of the bow that sides keep, round by round."""
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]  # corners of nodes 4 to 9, meshio's order


@dataclass(frozen=True)
class MeshArrays:
    """Nodes (n, 3) and tetra10 elements (e, 10), with gmsh's tags of the nodes (n,), ascending.

    And the volume of the geometry, m³.
    """

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    tags: NDArray[np.int64]
    volume: float

    def number(self, tags: Any) -> NDArray[np.int64]:
        """Node numbers of gmsh's node tags."""
        return np.searchsorted(self.tags, np.asarray(tags, dtype=np.int64))


def generate(
    gmsh: Any,
    size: float,
    local: Local | None = None,
    stretch: float = 1.0,
    same_faces: bool = False,
) -> MeshArrays:
    """Mesh the current model with curved quadratic tetrahedra; arguments as of `tetrahedra`."""
    tetrahedra(gmsh, size, local, stretch, same_faces)
    gmsh.model.mesh.setOrder(2)
    _, nodes = gmsh.model.mesh.getElementsByType(TETRA10)
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


def nodes_on(gmsh: Any, mesh: MeshArrays, dim: int, tag: int) -> NDArray[np.int64]:
    """Nodes of a point, curve or face and of its boundary, ascending."""
    tags, _, _ = gmsh.model.mesh.getNodes(dim, tag, includeBoundary=dim > 0)
    return np.unique(mesh.number(tags))


def matching(
    points: NDArray[np.float64],
    candidates: NDArray[np.int64],
    places: NDArray[np.float64],
    what: str,
    tolerance: float = TOLERANCE,
) -> NDArray[np.int64]:
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


def along(
    points: NDArray[np.float64],
    candidates: NDArray[np.int64],
    places: NDArray[np.float64],
    what: str,
) -> NDArray[np.int64]:
    """Like `matching`, for nodes that the kernel spread over a curve in its own measure."""
    spacing = np.linalg.norm(np.diff(places, axis=0), axis=1).min()
    return matching(points, candidates, places, what, 0.2 * float(spacing))


def nearest(
    points: NDArray[np.float64],
    candidates: NDArray[np.int64],
    places: NDArray[np.float64],
    what: str,
) -> NDArray[np.int64]:
    """Like `along`, for candidates that are many more than the places (k, 3)."""
    spacing = np.linalg.norm(np.diff(places, axis=0), axis=1).min()
    _, found = cKDTree(points[candidates]).query(places)
    return matching(points, candidates[np.unique(found)], places, what, 0.05 * float(spacing))


def place(
    mesh: MeshArrays,
    nodes: NDArray[np.int64],
    places: NDArray[np.float64],
    images: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]] | None = None,
) -> NDArray[np.float64]:
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
    for share in RELAXED:
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
