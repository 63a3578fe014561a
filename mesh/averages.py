"""Mean displacement over contact patches, as weights of the mesh's nodes.

The faces of straight-sided tetrahedra are cut with a patch exactly: its planes cut a triangle along
straight lines, in the triangle's barycentric coordinates λ. The quadratic shape functions N_j are
then integrated exactly over the pieces. The facets of a curved surface have another centroid x_f
than the patch, x_c, and another one on each part. The mean is carried from one to the other by
the displacement gradient beneath the facets,

    w_j = 1/A ∫ N_j + (x_c - x_f)·∇N_j dA,    so that  Σ w_j = 1,  Σ w_j x_j = x_c,

and both parts' means agree in every rigid-body motion, indeed in every affine one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.mesh.dimensions import HookDimensions, VaneDimensions
from vanelock.mesh.occ import TOLERANCE
from vanelock.mesh.part import Part
from vanelock.mesh.patches import Patch, hook_patches, interlock_patches

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FACETS = 2e-2  # of a patch's area: the most that flat facets may miss of a curved one
OFFSET = 1e-13  # m; a smaller distance of the centroids is round-off

_FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
_EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])  # of nodes 4 to 9


@dataclass(frozen=True)
class Facets:
    """Triangles (t,) of a surface: the element of each and its corners' places (t, 3) there."""

    element: Integers
    corner: Integers


def cylinder(points: Array, cells: Integers, radius: float, tolerance: float = TOLERANCE) -> Facets:
    """Surface triangles on a cylinder about z, or no further off it than a tolerance, m."""
    on = np.abs(np.hypot(points[:, 0], points[:, 1]) - radius) < tolerance
    facets = _surface(cells, on)
    # Three nodes on an arc at one end of the cylinder span a triangle that faces along the axis.
    a, b, c = np.moveaxis(points[_corners(cells, facets)], 1, 0)
    normal = np.cross(b - a, c - a)
    faces_axis = np.abs(normal[:, 2]) < np.linalg.norm(normal[:, :2], axis=1)
    return Facets(facets.element[faces_axis], facets.corner[faces_axis])


def plane(points: Array, cells: Integers, origin: Array, normal: Array) -> Facets:
    """Surface triangles in a plane."""
    return _surface(cells, np.abs((points - origin) @ normal) < TOLERANCE)


def _surface(cells: Integers, on: NDArray[np.bool_]) -> Facets:
    """Faces whose corners all lie on the surface and that belong to one element only."""
    element, face = np.nonzero(on[cells[:, _FACES]].all(axis=2))
    found = Facets(element, _FACES[face])
    key = np.sort(_corners(cells, found), axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    outer = first[count == 1]
    return Facets(found.element[outer], found.corner[outer])


def _corners(cells: Integers, facets: Facets) -> Integers:
    """(t, 3) nodes."""
    return np.take_along_axis(cells[facets.element], facets.corner, axis=1)


def averages(
    what: str, points: Array, cells: Integers, facets: Facets, patches: Sequence[Patch]
) -> sp.csr_array:
    """Weights of the nodes in the mean over each patch.

    Parameters
    ----------
    what : str
        Part and set, for errors.
    points : (n, 3) float
        Nodes, m.
    cells : (e, 10) int
        Straight-sided quadratic tetrahedra.
    facets : Facets
        Their faces on the patches' surface.
    patches : sequence of Patch
        k patches.

    Returns
    -------
    (k, n) csr_array
        Times displacements (n, 3): the means.

    Raises
    ------
    InputError
        If the faces do not cover a patch.
    """
    corners = points[_corners(cells, facets)]
    rows = []
    for i, patch in enumerate(patches):
        outside = corners @ patch.planes[:, :3].T - patch.planes[:, 3]
        near = np.flatnonzero(np.all(outside.min(axis=1) < 0, axis=1))
        polygons = _cut(outside[near])
        place, share = _quadrature(polygons)
        a, b, c = np.moveaxis(corners[near], 1, 0)
        weight = share * np.linalg.norm(np.cross(b - a, c - a), axis=1)[:, None] / 2
        area = weight.sum()
        if abs(area - patch.area) > FACETS * patch.area:
            raise InputError(
                f"{what}: element faces cover {100 * area / patch.area:.1f} % of contact patch "
                f"{i}: choose another mesh.size"
            )
        rows.append(_row(points, cells, _of(facets, near), place, weight / area, patch.centroid))
    return sp.csr_array(sp.vstack(rows))


def _of(facets: Facets, which: Integers) -> Facets:
    return Facets(facets.element[which], facets.corner[which])


def _cut(outside: Array) -> Array:
    """Barycentric corners (t, 3 + p, 3) of triangles cut by p planes; the last ones may repeat.

    Sutherland and Hodgman's method, on all triangles at once.

    Parameters
    ----------
    outside : (t, 3, p) float
        Distance of each triangle's corners from each plane, positive outside.
    """
    polygon = np.broadcast_to(np.eye(3), (len(outside), 3, 3))
    for k in range(outside.shape[2]):
        beyond = np.einsum("tvb,tb->tv", polygon, outside[:, :, k])
        following, beyond_following = np.roll(polygon, -1, axis=1), np.roll(beyond, -1, axis=1)
        kept = beyond <= 0
        crossed = beyond * beyond_following < 0
        fraction = beyond / np.where(crossed, beyond - beyond_following, 1.0)
        crossing = polygon + fraction[..., None] * (following - polygon)
        count, corners = kept.shape
        candidates = np.stack([polygon, crossing], axis=2).reshape(count, 2 * corners, 3)
        valid = np.stack([kept, crossed], axis=2).reshape(count, 2 * corners)
        order = np.argsort(~valid, axis=1, kind="stable")[:, : corners + 1]
        # What is left over repeats the first corner, whatever it is where nothing is left at all.
        order = np.where(np.take_along_axis(valid, order, axis=1), order, order[:, :1])
        polygon = np.take_along_axis(candidates, order[..., None], axis=1)
    return polygon


def _quadrature(polygons: Array) -> tuple[Array, Array]:
    """Points (t, q, 3) and shares (t, q) of the triangle's area, exact for quadratics.

    A fan of triangles from the first corner, each with the middles of its sides.
    """
    first = np.broadcast_to(polygons[:, :1], polygons[:, 2:].shape)
    fan = np.stack([first, polygons[:, 1:-1], polygons[:, 2:]], axis=2)
    share = np.abs(np.linalg.det(fan)) / 3
    middles = 0.5 * (fan + np.roll(fan, 1, axis=2))
    return middles.reshape(len(fan), 3 * fan.shape[1], 3), np.repeat(share, 3, axis=1)


def _row(
    points: Array, cells: Integers, facets: Facets, place: Array, weight: Array, centroid: Array
) -> sp.csr_array:
    """Weights (1, n) of the mean over some facets, carried to the patch's centroid.

    Parameters
    ----------
    place : (t, q, 3) float
        Barycentric quadrature points.
    weight : (t, q) float
        Their weights, which sum to one.
    """
    L = np.zeros((*place.shape[:2], 4))  # barycentric in the tetrahedron
    np.put_along_axis(L, facets.corner[:, None, :], place, axis=2)
    nodes = cells[facets.element]
    first, second = _EDGES.T
    shape = np.concatenate([L * (2 * L - 1), 4 * L[..., first] * L[..., second]], axis=2)
    mean = np.einsum("tq,tqj->tj", weight, shape)
    offset = centroid - np.einsum("tj,tjx->x", mean, points[nodes])
    if np.linalg.norm(offset) > OFFSET:
        vertices = np.concatenate([points[nodes[:, :4]], np.ones((len(nodes), 4, 1))], axis=2)
        along = np.linalg.inv(vertices)[:, :3].swapaxes(1, 2) @ offset  # of the four λ, (t, 4)
        corner = (4 * L - 1) * along[:, None]
        side = 4 * (L[..., first] * along[:, None, second] + L[..., second] * along[:, None, first])
        mean += np.einsum("tq,tqj->tj", weight, np.concatenate([corner, side], axis=2))
    used = mean != 0
    at = (np.zeros(int(used.sum()), int), nodes[used])
    return sp.csr_array((mean[used], at), shape=(1, len(points)))


def hook_averages(
    part: Part, hook: HookDimensions, overlap: tuple[float, float]
) -> dict[str, sp.csc_array]:
    """Weights of a part's hook patches, `Part.patches`.

    None where the bands lie outside the overlap, as in a part meshed for another mate.
    """
    if not overlap[0] < hook.band_position < overlap[1]:
        return {}
    bands = hook_patches(hook, overlap, part.sectors)
    rows = [
        averages(f"{part.name} {name}", part.points, part.cells, surface, band)
        for name, radius, band in zip(
            ("hook_front", "hook_front", "hook_rear", "hook_rear"),
            2 * (hook.roof_radius, hook.lip_radius),
            bands,
            strict=True,
        )
        for surface in [cylinder(part.points, part.cells, radius)]
    ]
    return {
        "hook_front": sp.csc_array(sp.vstack(rows[:2])),
        "hook_rear": sp.csc_array(sp.vstack(rows[2:])),
    }


def interlock_averages(part: Part, vane: VaneDimensions) -> dict[str, sp.csc_array]:
    """Weights of a vane's interlock patches, `Part.patches`."""
    found = {}
    for name, patches in zip(
        ("interlock_left", "interlock_right"), interlock_patches(vane, part.sectors), strict=True
    ):
        normal = part.frames[name][0, 0]
        facets = plane(part.points, part.cells, part.points[part.node_sets[name][0]], normal)
        rows = averages(f"{part.name} {name}", part.points, part.cells, facets, patches)
        found[name] = sp.csc_array(rows)
    return found
