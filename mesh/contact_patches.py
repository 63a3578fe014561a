"""Contact patches, the pieces of the contact faces that belong to each node, and means over them.

A patch is cut out of its face by planes and does not depend on the mesh, so that the two faces of
a joint, meshed apart, share it. At the hooks it is the interval of angle nearest to its node, the
outermost ones reaching to the band's end, over the axial length in which foot and groove touch. At
the interlock it is half of the face's height times the length nearest to its node. There the face
is bounded by arcs of the ellipses in which its plane cuts the shroud's cylinders.

Means of displacement over them are weights of the mesh's nodes. The faces of quadratic tetrahedra,
curved or not, are divided evenly in their barycentric coordinates. Each piece is cut with a patch's
planes as if it were flat between its corners, but integrated over as it is: with the element's own
shape functions N_j and area. The faces' centroid x_f may differ from the patch's, x_c, and does so
differently on each part. The mean is carried from one to the other by the displacement gradient
beneath the faces,

    w_j = 1/A ∫ N_j + (x_c - x_f)·∇N_j dA,    so that  Σ w_j = 1,  Σ w_j x_j = x_c,

and both parts' means agree in every rigid-body motion, indeed in every affine one. For straight
sides the integrals are exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.mesh.cells import single, solid
from vanelock.mesh.generate.occ_solids import TOLERANCE
from vanelock.mesh.geometry import contact_places
from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.part import Part


@dataclass(frozen=True)
class _Patch:
    """A piece of a surface."""

    planes: Floats  # (p, 4)
    area: float  # m²
    centroid: Floats  # (3,), of the curved surface, m; so it lies a little inside a cylinder

    def turned(self, rotation: Floats) -> "_Patch":
        """The patch turned about the origin."""
        planes = np.column_stack([self.planes[:, :3] @ rotation.T, self.planes[:, 3]])
        return _Patch(planes, self.area, rotation @ self.centroid)


def hook_overlap(vane: VaneDimensions, casing: CasingDimensions) -> tuple[float, float]:
    """Axial range, m, in which both faces of the front foot lie on those of the groove.

    Fillets belong to neither face.
    """
    return (
        max(vane.foot_front, casing.groove_bottom + casing.fillet),
        min(vane.leg_front - vane.fillet, casing.groove_mouth),
    )


def hook_patches(
    hook: HookDimensions, overlap: tuple[float, float], sectors: int
) -> list[list[_Patch]]:
    """Patches of the nodes of `contact_places.hook_bands`, band by band."""
    front_roof = contact_places.hook_bands(hook, sectors)[0]
    limits = _nearest(np.arctan2(front_roof[:, 1], front_roof[:, 0]))  # the same on all bands
    mirrored = (2 * hook.mid_plane - overlap[1], 2 * hook.mid_plane - overlap[0])
    return [
        [_on_cylinder(radius, angles, axial) for angles in pairwise(limits)]
        for axial in (overlap, mirrored)
        for radius in (hook.roof_radius, hook.lip_radius)
    ]


def _nearest(positions: Floats) -> Floats:
    """Ends and mid-points (k + 1,) of the intervals nearest to ascending positions (k,)."""
    middles = 0.5 * (positions[:-1] + positions[1:])
    return np.concatenate([positions[:1], middles, positions[-1:]])


def _on_cylinder(radius: float, angles: tuple[float, float], axial: tuple[float, float]) -> _Patch:
    (first, last), (front, rear) = angles, axial
    planes = np.array(
        [
            [np.sin(first), -np.cos(first), 0.0, 0.0],  # half-planes from the axis outwards
            [-np.sin(last), np.cos(last), 0.0, 0.0],
            [0.0, 0.0, -1.0, -front],
            [0.0, 0.0, 1.0, rear],
        ]
    )
    half, middle = 0.5 * (last - first), 0.5 * (first + last)
    inside = radius * np.sin(half) / half
    centroid = [inside * np.cos(middle), inside * np.sin(middle), 0.5 * (front + rear)]
    return _Patch(planes, radius * (last - first) * (rear - front), np.array(centroid))


def interlock_patches(vane: VaneDimensions, sectors: int) -> tuple[list[_Patch], list[_Patch]]:
    """Patches of the nodes of the left interlock face, in their order, and of the right one."""
    frame = contact_places.interlock_frame(vane, sectors)
    origin = np.array([0.0, 0.0, vane.hook.mid_plane])
    positions = (contact_places.interlock_rows(vane, sectors)[0] - origin) @ frame[
        2
    ]  # the same on both
    slope = np.sin(np.radians(vane.interlock_slant))
    radii = (vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius)
    local = [
        _beside_arc(ends, radius, sum(radii) - radius, slope)
        for radius in radii
        for ends in pairwise(_nearest(positions))
    ]
    left = []
    for sides, area, centre in local:
        normals = sides[:, :2] @ frame[[2, 1]]
        planes = np.column_stack([normals, sides[:, 2] + normals @ origin])
        left.append(_Patch(planes, area, origin + centre @ frame[[2, 1]]))
    return left, [patch.turned(turn(sectors)) for patch in left]


def _beside_arc(
    ends: tuple[float, float], radius: float, opposite: float, slope: float
) -> tuple[Floats, float, Floats]:
    """Piece of an interlock face from one of its arcs to the line at half height.

    In coordinates of the face, across it and radial, the arcs are y² + (slope x)² = radius². The
    line is straight and meets the mean of both arcs at the ends in x.
    """

    def arc(r: float, angle: Floats) -> Floats:
        return np.sqrt(r**2 - (slope * angle) ** 2)

    start, end = ends
    low, high = 0.5 * (arc(radius, np.array(ends)) + arc(opposite, np.array(ends)))
    points, weights = np.polynomial.legendre.leggauss(20)
    x = start + (end - start) * 0.5 * (1 + points)
    y = np.stack([arc(radius, x), low + (high - low) * 0.5 * (1 + points)])
    share = 0.5 * (end - start) * weights * np.abs(y[1] - y[0])
    area = float(share.sum())
    upwards = np.array([low - high, end - start]) / np.hypot(high - low, end - start)
    towards_arc = np.sign(radius - opposite) * upwards
    corner = np.array([start, low])
    sides = np.array([[-1.0, 0.0, -start], [1.0, 0.0, end], [*-towards_arc, -towards_arc @ corner]])
    return sides, area, np.array([share @ x, share @ y.mean(axis=0)]) / area


_COVERED = 2e-2  # of a patch's area: the most that straight-sided elements may miss of a curved one
_OFFSET = 1e-13  # m; a smaller distance of the centroids is round-off
_LATTICE = np.array([(2, 0, 0), (1, 0, 1), (0, 0, 2), (1, 1, 0), (0, 1, 1), (0, 2, 0)]) / 2
_PIECES = np.array([(0, 3, 1), (1, 4, 2), (3, 5, 4), (4, 3, 1)])
"""Barycentric points of a face, and the triangles of them into which it is divided before it is
cut; finer ones do not change what elements resolve."""


@dataclass(frozen=True)
class _Facets:
    """Faces (t,) of elements on a surface: the element of each and its corners' places (t, 3)."""

    element: Integers
    corner: Integers


def _cylinder(points: Floats, cells: Integers, radius: float) -> _Facets:
    """Faces with their corners on a cylinder about z."""
    on = np.abs(np.hypot(points[:, 0], points[:, 1]) - radius) < TOLERANCE
    facets = _surface(cells, on)
    # Three corners on an arc at one end of the cylinder span a triangle that faces along the axis.
    a, b, c = np.moveaxis(points[_corners(cells, facets)], 1, 0)
    normal = np.cross(b - a, c - a)
    faces_axis = np.abs(normal[:, 2]) < np.linalg.norm(normal[:, :2], axis=1)
    return _Facets(facets.element[faces_axis], facets.corner[faces_axis])


def _plane(points: Floats, cells: Integers, origin: Floats, normal: Floats) -> _Facets:
    """Faces with their corners in a plane."""
    return _surface(cells, np.abs((points - origin) @ normal) < TOLERANCE)


def _surface(cells: Integers, on: Booleans) -> _Facets:
    """Faces whose corners all lie on the surface and that belong to one element only."""
    faces = solid("tetra").faces
    element, face = np.nonzero(on[cells[:, faces]].all(axis=2))
    facets = _Facets(element, faces[face])
    outer = single(_corners(cells, facets))
    return _Facets(facets.element[outer], facets.corner[outer])


def _corners(cells: Integers, facets: _Facets) -> Integers:
    """(t, 3) nodes."""
    return np.take_along_axis(cells[facets.element], facets.corner, axis=1)


def _averages(
    what: str, points: Floats, cells: Integers, facets: _Facets, patches: Sequence[_Patch]
) -> sp.csr_array:
    """Weights of the nodes in the mean over each patch."""
    place = _in_tetrahedron(facets.corner[:, None], _LATTICE)
    shapes, _ = solid("tetra10").functions(place.reshape(-1, 3))
    shapes = shapes.reshape(*place.shape[:2], 10)
    x = shapes @ points[cells[facets.element]]  # (t, lattice, 3)
    rows = []
    for i, patch in enumerate(patches):
        outside = x @ patch.planes[:, :3].T - patch.planes[:, 3]
        near = np.flatnonzero(np.all(outside.min(axis=1) < 0, axis=1))
        face, piece, within, share = _inside(outside[near][:, _PIECES])
        in_face = np.einsum("qc,qcb->qb", within, _LATTICE[_PIECES[piece]])
        element, corner = facets.element[near[face]], facets.corner[near[face]]
        position = _in_tetrahedron(corner, in_face)
        functions, slopes = solid("tetra10").functions(position)
        J = np.einsum("qja,qjb->qab", points[cells[element]], slopes)
        ends = solid("tetra").nodes[corner]
        sides = (ends[:, 1:] - ends[:, :1]) @ J.swapaxes(1, 2)
        weight = share * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
        area = weight.sum()
        if abs(area - patch.area) > _COVERED * patch.area:
            raise InputError(
                f"{what}: element faces cover {100 * area / patch.area:.1f} % of contact patch "
                f"{i}: choose another mesh.size"
            )
        mean = (weight / area)[:, None] * functions
        offset = patch.centroid - np.einsum("qj,qjx->x", mean, points[cells[element]])
        if np.linalg.norm(offset) > _OFFSET:
            along = np.linalg.solve(J, np.broadcast_to(offset, (len(J), 3))[..., None])
            mean += (weight / area)[:, None] * (slopes @ along)[..., 0]
        rows.append(_row(len(points), cells[element], mean))
    return sp.csr_array(sp.vstack(rows))


def _in_tetrahedron(corner: Integers, points: Floats) -> Floats:
    """Reference positions (..., 3) of barycentric ones (..., 3) in faces with corners (..., 3)."""
    return np.asarray((points[..., None, :] @ solid("tetra").nodes[corner])[..., 0, :])


def _inside(outside: Floats) -> tuple[Integers, Integers, Floats, Floats]:
    """Quadrature of the faces inside some planes, exact for quadratics in each piece."""
    face, piece = np.nonzero(np.all(outside.min(axis=2) < 0, axis=2))
    place, share = _quadrature(_cut(outside[face, piece]))
    used, point = np.nonzero(share > 0)
    share_of_face = share[used, point] / outside.shape[1]
    return face[used], piece[used], place[used, point], share_of_face


def _cut(outside: Floats) -> Floats:
    """Barycentric corners (t, 3 + p, 3) of triangles cut by p planes; the last ones may repeat.

    Sutherland and Hodgman's method, on all triangles at once.
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


def _quadrature(polygons: Floats) -> tuple[Floats, Floats]:
    """Points (t, q, 3) and shares (t, q) of the triangle's area, exact for quadratics.

    A fan of triangles from the first corner, each with the middles of its sides.
    """
    first = np.broadcast_to(polygons[:, :1], polygons[:, 2:].shape)
    fan = np.stack([first, polygons[:, 1:-1], polygons[:, 2:]], axis=2)
    share = np.abs(np.linalg.det(fan)) / 3
    middles = 0.5 * (fan + np.roll(fan, 1, axis=2))
    return middles.reshape(len(fan), 3 * fan.shape[1], 3), np.repeat(share, 3, axis=1)


def _row(size: int, nodes: Integers, mean: Floats) -> sp.csr_array:
    """Weights (1, n) of the mean over some points from those of their elements' nodes."""
    used, number = np.unique(nodes, return_inverse=True)
    total = np.bincount(number.ravel(), mean.ravel())
    row = sp.csr_array((total, (np.zeros(len(used), int), used)), shape=(1, size))
    row.eliminate_zeros()
    return row


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
        _averages(f"{part.name} {name}", part.points, part.cells, surface, band)
        for name, radius, band in zip(
            ("hook_front", "hook_front", "hook_rear", "hook_rear"),
            2 * (hook.roof_radius, hook.lip_radius),
            bands,
            strict=True,
        )
        for surface in [_cylinder(part.points, part.cells, radius)]
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
        facets = _plane(part.points, part.cells, part.points[part.node_sets[name][0]], normal)
        rows = _averages(f"{part.name} {name}", part.points, part.cells, facets, patches)
        found[name] = sp.csc_array(rows)
    return found
