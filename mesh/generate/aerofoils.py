"""Aerofoils as solids: ruled between two sections, or sewn from faces where they have fillets.

They reach from inside the inner to inside the outer shroud, with which they are then united.

Their faces are divided into rows and columns before they are meshed. A rounded edge is a face up to
a thousand times longer than wide, and the two sides of an aerofoil may lie closer to each other
than an element is long. Left to itself the mesher joins nodes across such a face from one shroud to
the other, or lets the triangles of the two sides cross. Divided like a chessboard, in as many
columns along the chord and rows along the span on both sides, they keep their distance, and the
places of the output nodes are corners of the board.

Rows are short at the shrouds, where stresses grow, and long between, unless the thickness of the
rounded edges asks for short ones everywhere. With u from 0 to 1 along the rows and s along the
span,

    s = 1/2 + tanh(κ (2u - 1)) / (2 tanh κ),

which gmsh calls "Bump", its coefficient 1 - tanh²κ. κ is such that a corner stays at each quarter.

So are those of aerofoils with fillets: the fillets have the same columns as the aerofoil, and rows
across their arcs. The faces between them are cut at the quarters of the span, where output nodes
lie.
"""

from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from vanelock.common.arrays import Floats
from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh.element_size import SLENDER, thin
from vanelock.mesh.generate.occ_solids import TOLERANCE, Entity
from vanelock.mesh.geometry import aerofoil, root_fillet
from vanelock.mesh.geometry.dimensions import VaneDimensions

_TURN = np.radians(30.0)
"""Largest angle by which a fillet's elements turn from one row to the next, rad."""
_OFF = 5 * TOLERANCE  # m; where faces meet at a small angle, the kernel finds less exactly
_LEVELS = 7  # foot, top, three quarters, top, foot
_PIECES = _LEVELS - 1

_Corner = tuple[int, int, int]  # aerofoil, level outwards, and the strip that begins there


def divide_aerofoils(gmsh: Any, vane: VaneDimensions, sectors: int, size: float) -> list[int]:
    """Prescribe the nodes on all faces of the aerofoils of the current model; their sides."""
    if vane.root_fillet:
        return _divide_filleted(gmsh, vane, sectors, size)
    return _divide_ruled(gmsh, vane, size)


def _divide_filleted(gmsh: Any, vane: VaneDimensions, sectors: int, size: float) -> list[int]:
    corners = _corners(gmsh, vane, sectors)
    faces = {}
    for _, face in gmsh.model.getEntities(2):
        bounding = gmsh.model.getBoundary([(2, face)], oriented=False, recursive=True)
        if len(bounding) == 4 and all(tag in corners for _, tag in bounding):
            faces[face] = [corners[tag] for _, tag in bounding]
    expected = vane.aerofoils * _PIECES * root_fillet.STRIPS
    if len(faces) != expected:
        raise InputError(
            f"vane.root_fillet = {vane.root_fillet or 0.0:g} m: {len(faces)} faces between the "
            f"shrouds instead of {expected}: the fillets leave their shrouds or meet"
        )
    across, divided = arc_rows(vane), divisions(vane, size)
    inner = divided.rows // 2 - divided.outer
    rows = (across, divided.outer, inner, inner, divided.outer, across)
    for face in faces:
        for _, curve in gmsh.model.getBoundary([(2, face)], oriented=False):
            ends = gmsh.model.getBoundary([(1, curve)], oriented=False)
            elements = _elements(rows, divided.columns, [corners[tag] for _, tag in ends])
            gmsh.model.mesh.setTransfiniteCurve(curve, elements + 1)
        gmsh.model.mesh.setTransfiniteSurface(face, "AlternateRight")
    return [face for face, ends in faces.items() if _on_a_side(ends)]


@lru_cache(maxsize=64)
def arc_rows(vane: VaneDimensions) -> int:
    """Rows of elements across a fillet."""
    return int(np.ceil(root_fillet.sweep(vane) / _TURN))


def _elements(rows: tuple[int, ...], columns: int, ends: list[_Corner]) -> int:
    """Elements along the curve between two corners, of rows from level to level and columns."""
    (_, low, one), (_, high, other) = sorted(ends)
    if low == high:
        return columns if _strip(one, other) % 2 == 0 else ROUND
    return rows[low]


def _strip(one: int, other: int) -> int:
    """The strip between the beginnings of two that follow each other."""
    return one if (one + 1) % root_fillet.STRIPS == other else other


def _on_a_side(ends: list[_Corner]) -> bool:
    inside = all(0 < level < _LEVELS - 1 for _, level, _ in ends)
    one, other = {strip for _, _, strip in ends}
    return inside and _strip(one, other) % 2 == 0


def _corners(gmsh: Any, vane: VaneDimensions, sectors: int) -> dict[int, _Corner]:
    """The model's vertices in which faces of aerofoils meet."""
    low, high = (root_fillet.strips(vane, outer) for outer in (False, True))
    quarters = np.array([root_fillet.levels(vane, k)[1:-1, 0] for k in range(root_fillet.STRIPS)])
    grid = np.concatenate(
        [
            root_fillet.feet(vane, False)[None],
            np.array([strip.top[0] for strip in low])[None],
            quarters.swapaxes(0, 1),
            np.array([strip.top[0] for strip in high])[None],
            root_fillet.feet(vane, True)[None],
        ]
    )
    grid[..., 2] += vane.hook.mid_plane
    turned = [grid @ rotation(angle).T for angle in aerofoil.angles(vane, sectors)]
    names = list(product(range(vane.aerofoils), range(_LEVELS), range(root_fillet.STRIPS)))
    tree = cKDTree(np.concatenate(turned).reshape(-1, 3))
    found: dict[int, _Corner] = {}
    for _, tag in gmsh.model.getEntities(0):
        place: Floats = gmsh.model.getValue(0, tag, [])
        distance, nearest = tree.query(place)
        if distance < _OFF:
            found[tag] = names[nearest]
    return found


ROUND = 2
"""Columns around a rounded edge. A single element's side there bows by half its length, which
makes thin aerofoils stiffer in torsion than even straight sides do."""

_MESH_ADAPT = 1  # gmsh's number of the algorithm that grades a face to edges of 1 % of its size

_WIDE = 0.5  # elements across an aerofoil's chord, in element sizes: its bending is found from few
_NEAR = 5 / 3
"""Rows in each outer quarter of the span, over those in each inner one, by the elements' size."""


class _Divisions(NamedTuple):
    """Rows along the span, those of them in each outer quarter, and columns along the chord."""

    rows: int
    outer: int
    columns: int

    @property
    def bump(self) -> float:
        """The coefficient of rows that have corners at the quarters of the span."""
        from scipy.optimize import brentq  # checks count elements, and need not load it

        share = 1 - 2 * self.outer / self.rows
        if share >= 0.5:
            return 1.0
        kappa = brentq(lambda k: np.tanh(k * share) - np.tanh(k) / 2, 1e-3, 20.0)
        return float(1 - np.tanh(kappa) ** 2)


def _divide_ruled(gmsh: Any, vane: VaneDimensions, size: float) -> list[int]:
    ends = _ends(gmsh, vane)
    faces = []
    for _, tag in gmsh.model.getEntities(2):
        corners = gmsh.model.getBoundary([(2, tag)], recursive=True)
        if all(corner in ends for _, corner in corners):
            faces.append(tag)
    if len(faces) != 4 * vane.aerofoils:
        raise InputError(
            f"vane.aerofoils = {vane.aerofoils}: {len(faces)} faces between the shrouds instead of "
            f"{4 * vane.aerofoils}: the aerofoils leave their shrouds"
        )
    rows, _, columns = found = divisions(vane, size)
    sides: list[int] = []
    shrouds: set[int] = set()
    for face in faces:
        for _, curve in gmsh.model.getBoundary([(2, face)], oriented=False):
            first, last = (ends[corner] for _, corner in gmsh.model.getBoundary([(1, curve)]))
            if first != last:
                gmsh.model.mesh.setTransfiniteCurve(curve, rows + 1, "Bump", found.bump)
                continue
            along = gmsh.model.occ.getMass(1, curve) > 0.5 * vane.chord  # or round an edge
            gmsh.model.mesh.setTransfiniteCurve(curve, (columns if along else ROUND) + 1)
            shrouds.update(gmsh.model.getAdjacencies(1, curve)[0].tolist())
            if along and face not in sides:
                sides.append(face)
        gmsh.model.mesh.setTransfiniteSurface(face, "AlternateRight")
    if thin(vane, size):
        for shroud in shrouds.difference(faces):
            gmsh.model.mesh.setAlgorithm(2, shroud, _MESH_ADAPT)
    return sides


def divisions(vane: VaneDimensions, size: float) -> _Divisions:
    """How an aerofoil's sides are divided; columns are an even number.

    Elements are no longer than `SLENDER` edges are thick, a tenth more where rows differ in height,
    and the camber line's arc stands no further off an element's side than a quarter of the
    aerofoil's thickness.
    """
    span = vane.outer_shroud_inner_radius - vane.inner_shroud_outer_radius
    span /= np.cos(np.radians(vane.lean))
    by_size, by_edge = (
        int(np.ceil(span / 4 / longest)) for longest in (size, SLENDER * vane.edge_thickness)
    )
    inner = max(by_size, by_edge)
    outer = max(int(np.ceil(_NEAR * by_size)), by_edge)
    bent = np.sqrt(4 * vane.camber * vane.chord / vane.thickness)
    columns = max(vane.chord / (_WIDE * size), bent, 1.0)
    return _Divisions(2 * (inner + outer), outer, 2 * int(np.ceil(columns / 2)))


def _ends(gmsh: Any, vane: VaneDimensions) -> dict[int, int]:
    """The vertices where aerofoils meet the inner shroud, 0, and the outer one, 1."""
    radii = np.array([vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius])
    half = max(float(np.abs(aerofoil.around(vane, radius)[:, 1]).max()) for radius in radii)
    found = {}
    for _, tag in gmsh.model.getEntities(0):
        x, y, z = gmsh.model.getValue(0, tag, [])
        off = np.abs(np.hypot(x, y) - radii)
        if off.min() < TOLERANCE and abs(z - vane.hook.mid_plane) < half + TOLERANCE:
            found[tag] = int(off.argmin())
    return found


_DECIMALS = 10
"""Of the places, m, and weights that the kernel gets of an aerofoil: processors differ in digits
beyond, and where they do the mesher connects other nodes."""


def aerofoil_solids(gmsh: Any, vane: VaneDimensions, sectors: int) -> list[Entity]:
    """The aerofoils of a segment, in the open session."""
    made = []
    strips = root_fillet.faces(vane) if vane.root_fillet else []
    for angle in aerofoil.angles(vane, sectors):
        solid = _filleted(gmsh, vane, strips) if strips else _ruled(gmsh, vane)
        gmsh.model.occ.rotate([solid], 0, 0, 0, 0, 0, 1, angle)
        made.append(solid)
    return made


def _ruled(gmsh: Any, vane: VaneDimensions) -> Entity:
    kernel = gmsh.model.occ
    start, end = aerofoil.ends(vane)
    root = _section(gmsh, vane, start)
    if vane.twist == 0:
        shift = np.tan(np.radians(vane.lean)) * (end - start)
        face = (2, kernel.addPlaneSurface([root]))
        swept = kernel.extrude([face], end - start, shift, 0)
    else:
        tip = _section(gmsh, vane, end)
        swept = kernel.addThruSections([root, tip], makeSolid=True, makeRuled=True)
    solid: Entity = next(entity for entity in swept if entity[0] == 3)
    return solid


def _section(gmsh: Any, vane: VaneDimensions, along: float) -> int:
    """Closed wire around an aerofoil's section, in the frame of its radial axis."""
    kernel = gmsh.model.occ

    def point(position: Floats) -> int:
        return _put(gmsh, along, position[0], vane.hook.mid_plane + position[1])

    sides = [[point(p) for p in s] for s in aerofoil.outline(vane, aerofoil.STATIONS, along)]
    leading, trailing = (point(place) for place in aerofoil.edges(vane, along).control)
    convex, concave = sides[0], sides[1][::-1]
    wire: int = kernel.addWire(
        [
            kernel.addSpline(convex),
            kernel.addBezier([convex[-1], trailing, concave[0]]),
            kernel.addSpline(concave),
            kernel.addBezier([concave[-1], leading, convex[0]]),
        ]
    )
    # Only the ends of its curves are points of the wire.
    kernel.remove([(0, tag) for tag in (*convex[1:-1], *concave[1:-1], leading, trailing)])
    return wire


def _filleted(
    gmsh: Any, vane: VaneDimensions, strips: list[list[root_fillet.RationalFace]]
) -> Entity:
    kernel = gmsh.model.occ
    faces = [_face(gmsh, vane, face) for strip in strips for face in strip]
    for end, row in ((0, 0), (-1, -1)):
        rim = [_curve(gmsh, vane, strip[end], row) for strip in strips]
        faces.append(kernel.addPlaneSurface([kernel.addWire(rim)]))
    solid = (3, kernel.addVolume([kernel.addSurfaceLoop(faces, sewing=True)]))
    kernel.remove([(2, face) for face in faces], recursive=True)
    return solid


def _face(gmsh: Any, vane: VaneDimensions, face: root_fillet.RationalFace) -> int:
    points, weights, knots = face.control()
    values, counts = np.unique(knots, return_counts=True)
    degree = len(points) - 1
    tags = [_point(gmsh, vane, place) for row in points for place in row]
    made: int = gmsh.model.occ.addBSplineSurface(
        tags,
        points.shape[1],
        degreeU=3,
        degreeV=degree,
        weights=np.round(weights, _DECIMALS).ravel().tolist(),
        knotsU=np.round(values, _DECIMALS).tolist(),
        knotsV=[0.0, 1.0],
        multiplicitiesU=counts.tolist(),
        multiplicitiesV=[degree + 1, degree + 1],
    )
    gmsh.model.occ.remove([(0, tag) for tag in tags])
    return made


def _curve(gmsh: Any, vane: VaneDimensions, face: root_fillet.RationalFace, row: int) -> int:
    """The first or the last of the curves along a face."""
    points, _, knots = face.control()
    values, counts = np.unique(knots, return_counts=True)
    tags = [_point(gmsh, vane, place) for place in points[row]]
    curve: int = gmsh.model.occ.addBSpline(
        tags, degree=3, knots=np.round(values, _DECIMALS).tolist(), multiplicities=counts.tolist()
    )
    gmsh.model.occ.remove([(0, tag) for tag in tags[1:-1]])
    return curve


def _point(gmsh: Any, vane: VaneDimensions, position: Floats) -> int:
    return _put(gmsh, position[0], position[1], vane.hook.mid_plane + position[2])


def _put(gmsh: Any, *coordinates: float) -> int:
    tag: int = gmsh.model.occ.addPoint(*np.round(coordinates, _DECIMALS))
    return tag
